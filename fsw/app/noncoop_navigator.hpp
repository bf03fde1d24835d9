#pragma once
#include <array>

#include "fsw/app/navigator.hpp"
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
class NoncoopNavigator final : public Navigator {
 public:
  explicit NoncoopNavigator(hal::Clock& clock) : clock_(clock) {}

  /// invalid_argument as NoncoopFilter::configure.
  Status configure(const NavigatorConfig& config, const CameraModel& camera);
  void restart() override;
  [[nodiscard]] bool has_started() const override { return started_; }
  [[nodiscard]] bool is_starting() const override { return filter_.is_starting(); }
  /// One image. Not started: too_few_features.
  Status process(std::span<const CameraImage> images, Time time, StepReport& report) override;
  /// not_finite, not_positive_definite: a variance of the filter.
  [[nodiscard]] Status check() const override;
  [[nodiscard]] const NoncoopFilter& filter() const { return filter_; }

 private:
  static constexpr std::size_t max_corners = 4096;

  Status start(const vision::ImageView& image, Time time, StepReport& report);
  /// A feature in the filter and a patch in the tracker for every candidate.
  void plant(const vision::ImageView& image, const vision::CornerCandidates& candidates, StepReport& report);
  void add_features(const vision::ImageView& image, StepReport& report);
  Status find_corners(const vision::ImageView& image, std::size_t wanted, vision::CornerCandidates& candidates);
  void report_matches(const FilterUpdate& update, StepReport& report) const;

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
