#pragma once
#include <array>

#include "fsw/app/step_report.hpp"
#include "fsw/estimation/noncoop_filter.hpp"
#include "fsw/geometry/camera_model.hpp"
#include "fsw/vision/corner_spread.hpp"
#include "fsw/vision/fast_corners.hpp"
#include "fsw/vision/feature_tracker.hpp"
#include "hal/clock.hpp"

namespace relnav::app {

struct NavigatorConfig {
  NoncoopConfig filter;
  vision::TrackerOptions tracker;
  vision::SpreadOptions spread;
  std::uint8_t fast_threshold = 15;
  std::uint16_t min_start_features = 10;  ///< corners needed to begin
};

/// Images in, relative state of a non-cooperative target out: joins the front end and the filter, which do not see each
/// other. One process() a frame.
class NoncoopNavigator {
 public:
  explicit NoncoopNavigator(hal::Clock& clock) : clock_(clock) {}

  /// invalid_argument as NoncoopFilter::configure.
  Status configure(const NavigatorConfig& config, const CameraModel& camera);
  /// Forgets everything learnt; the next image starts anew.
  void restart();
  [[nodiscard]] bool has_started() const { return started_; }

  /// Fills state, counts, feature reports and stage times of `report`.
  /// too_few_features: not started, and the image does not offer enough to start on. not_positive_definite, not_finite:
  /// an update was refused, the state is the predicted one. out_of_order: time does not advance, nothing was done.
  Status process(const vision::ImageView& image, Time time, StepReport& report);
  [[nodiscard]] const NoncoopFilter& filter() const { return filter_; }

 private:
  static constexpr std::size_t max_corners = 4096;

  Status start(const vision::ImageView& image, Time time, StepReport& report);
  /// A feature in the filter and a patch in the tracker for every candidate.
  void plant(const vision::ImageView& image, const vision::CornerCandidates& candidates, StepReport& report);
  void add_features(const vision::ImageView& image, StepReport& report);
  Status find_corners(const vision::ImageView& image, std::size_t wanted, vision::CornerCandidates& candidates);
  void report_matches(const FilterUpdate& update, StepReport& report) const;
  [[nodiscard]] std::int64_t lap(Time& since);

  hal::Clock& clock_;
  NavigatorConfig config_;
  CameraModel camera_;
  NoncoopFilter filter_;
  vision::FeatureTracker tracker_;
  bool started_ = false;

  FeaturePredictions predictions_;
  FeatureMatches matches_;
  vision::MatchReport match_report_;
  std::array<vision::FastCorner, max_corners> corners_{};
  BoundedVector<Vec2, config::max_features> tracked_px_;
};

}  // namespace relnav::app
