#pragma once
#include <array>

#include "fsw/app/navigator.hpp"
#include "fsw/estimation/cooperative_estimator.hpp"
#include "fsw/estimation/marker_sights.hpp"
#include "fsw/estimation/pose_filter.hpp"
#include "fsw/estimation/spot_acquisition.hpp"
#include "fsw/estimation/spot_tracking.hpp"
#include "fsw/vision/light_spot_finder.hpp"
#include "hal/clock.hpp"

namespace relnav::app {

struct CoopNavigatorConfig {
  TargetModel target;
  vision::SpotSettings spots;
  SpotSearchSettings search;
  SpotTrackingSettings tracking;
  CooperativeConfig estimator;
  PoseFilterConfig filter;
  /// Decides between poses that a symmetric layout leaves open, and helps where spots alone are too close to chance; not used
  /// otherwise. Default: the target's axes near the camera's, as in an approach. Zero: such a target is never acquired.
  double expected_cone_rad = 0.6;
  Mat3 R_CT_expected = Mat3::Identity();
  std::uint16_t min_observations = 4;  ///< of a frame that gives a pose
};

/// Images in, relative state of a target with known light spots out: finder, acquisition, assignment, least squares, filter.
/// The pose is that of the frame's least squares; the filter predicts where to look and gives the rates.
class CoopNavigator final : public Navigator {
 public:
  explicit CoopNavigator(hal::Clock& clock) : clock_(clock) {}

  /// invalid_argument: the rig or target is refused by the estimator, or settings are outside their domain.
  Status configure(const CoopNavigatorConfig& config, const CameraRig& rig);
  void restart() override;
  [[nodiscard]] bool has_started() const override { return filter_.has_started(); }
  [[nodiscard]] bool is_starting() const override { return false; }
  /// Not started: too_few_features (no spots that make up the target), ambiguous (nothing decides between poses).
  Status process(std::span<const vision::ImageView> images, Time time, StepReport& report) override;
  [[nodiscard]] Status check() const override { return Status::ok; }

 private:
  Status acquire(std::span<const vision::ImageView> images, Time time, StepReport& report);
  Status track(std::span<const vision::ImageView> images, Time time, StepReport& report);
  /// Spots where markers are expected.
  Status look_for_expected(std::span<const vision::ImageView> images, const Pose& pose, const Mat6& covariance,
                           StepReport& report);
  /// Too few for a pose of their own: they correct the predicted one.
  void update_from_few(StepReport& report);
  /// Which markers are in sight, by the pose just solved.
  void look_at_sights();
  void take(Time time, StepReport& report);
  void report_markers(StepReport& report) const;
  [[nodiscard]] std::int64_t lap(Time& since);

  hal::Clock& clock_;
  CoopNavigatorConfig config_;
  CooperativeEstimator estimator_;
  vision::LightSpotFinder finder_;
  SpotAcquisition acquisition_;
  PoseFilter filter_;
  MarkerSights sights_;

  RigSpots spots_;
  ExpectedMarkers markers_;
  SpotAssignment assignment_;
  ExpectedMarkers agreeing_markers_;
  SpotAssignment agreeing_;
  CooperativeSolution solution_;
  AcquiredSpots acquired_;
};

}  // namespace relnav::app
