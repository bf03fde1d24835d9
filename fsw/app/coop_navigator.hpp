#pragma once
#include <array>

#include "fsw/app/navigator.hpp"
#include "fsw/estimation/cooperative_estimator.hpp"
#include "fsw/estimation/marker_sights.hpp"
#include "fsw/estimation/pose_filter.hpp"
#include "fsw/estimation/spot_acquisition.hpp"
#include "fsw/estimation/torn_image.hpp"
#include "fsw/vision/light_spot_finder.hpp"
#include "hal/clock.hpp"

namespace relnav::app {

struct CoopNavigatorConfig {
  static constexpr std::size_t least_markers = 4;  ///< fewer make up no pose that chance does not
  static constexpr std::size_t most_markers = max_search_markers;

  TargetModel target;
  vision::SpotSettings spots;  ///< in the levels of an 8-bit image
  SpotSearchSettings search;
  SpotTrackingSettings tracking;
  TearSettings tear;
  CooperativeConfig estimator;
  PoseFilterConfig filter;
  /// Decides between poses that a symmetric layout leaves open, and helps where spots alone are too close to chance; not used
  /// otherwise. Default: the target's axes near the camera's, as in an approach. Zero: such a target is never acquired.
  double expected_cone_rad = 0.6;
  Vec3 phi_CT_expected = Vec3::Zero();  ///< rotation vector, rad: R_CT = Exp([phi x])
  std::uint16_t min_observations = 4;   ///< of a frame that gives a pose of its own
  std::uint8_t sensor_bits = 16;        ///< that a 16-bit image uses, 8 to 16: full scale is 2^bits - 1

  /// invalid_argument: a setting is outside of its domain, too few markers or too many.
  [[nodiscard]] Status check() const;
  /// `spots` for a whole picture, where a search needs no more than a few hundredths of a pixel.
  [[nodiscard]] vision::SpotSettings coarse_spots() const;
};

/// Images in, relative state of a target with known light spots out: finder, acquisition, assignment, least squares, filter.
/// The pose is that of the frame's least squares; the filter predicts where to look and gives the rates.
class CoopNavigator final : public Navigator {
 public:
  explicit CoopNavigator(hal::Clock& clock) : clock_(clock) {}

  /// invalid_argument: the rig or target is refused by the estimator, or settings are outside their domain; nothing changes.
  Status configure(const CoopNavigatorConfig& config, const CameraRig& rig);
  void restart() override;
  [[nodiscard]] bool has_started() const override { return filter_.has_started(); }
  [[nodiscard]] bool is_starting() const override { return false; }
  /// A camera without an image is left out. Not started: unfinished (the work of a frame is bounded; the spots of one are
  /// searched during the next ones), too_few_features (no spots that make up the target), ambiguous (nothing decides between
  /// poses). Started: inconsistent (chi-square alarm, or the motion contradicts the pose),
  /// ambiguous and what else solve_pose() says: not used. Fewer than min_observations: ok, they correct the predicted pose.
  Status process(std::span<const CameraImage> images, Time time, StepReport& report) override;
  [[nodiscard]] Status check() const override { return Status::ok; }

 private:
  /// Spots of one camera, in `windows`; anywhere if there are none or they cover so much that it takes less.
  Status find_spots(const CameraImage& image, std::span<const vision::PixelRegion> windows, LightSpots& spots,
                    StepReport& report);
  /// Not started: looks at a frame and searches what was seen, for some frames more if need be, until what was found is met
  /// again in the next one. The work of each is bounded, `budget` is in three-point problems.
  Status acquire(std::span<const CameraImage> images, Time time, StepReport& report);
  Status look(std::span<const CameraImage> images, Time time, StepReport& report);
  Status search(int budget, StepReport& report);
  /// With what was found in the same frame.
  Status start(Time time, StepReport& report);
  void begin_filter();
  void restart_search();
  Status track(std::span<const CameraImage> images, Time time, StepReport& report);
  /// Spots where markers are expected.
  Status look_for_expected(std::span<const CameraImage> images, const Pose& pose, const Mat6& covariance,
                           StepReport& report);
  /// Where the filter has its markers, before it goes on to this frame.
  void remember_markers(std::span<const CameraImage> images);
  /// Take out what still shows the frame before: what spots tell by themselves, then what a pose has left out. True: some, of
  /// one camera that is not `done` yet; the pose then has to be solved anew before the other is looked at.
  void drop_torn_parts(std::span<const CameraImage> images, StepReport& report);
  bool drop_torn_outliers(std::span<const CameraImage> images, std::array<bool, config::max_cameras>& done,
                          StepReport& report);
  void drop_late_spots(const Tear& tear, StepReport& report);
  Status update(std::span<const CameraImage> images, const Pose& predicted, Time time, StepReport& report);
  /// Too few for a pose of their own: they correct the predicted one. inconsistent: none of them fits it.
  Status update_from_few(std::span<const CameraImage> images, StepReport& report);
  /// Which markers are in sight of the cameras that gave a whole image, by the pose just solved.
  void look_at_sights(std::span<const CameraImage> images, const StepReport& report);
  void take(Time time, StepReport& report);
  void report_markers(StepReport& report) const;

  hal::Clock& clock_;
  CoopNavigatorConfig config_;
  CooperativeEstimator estimator_;
  vision::LightSpotFinder finder_;
  SpotAcquisition acquisition_;
  PoseFilter filter_;
  MarkerSights sights_;

  RigSpots spots_;
  ExpectedMarkers markers_;
  ExpectedMarkers markers_before_;  ///< in the frame before
  SpotAssignment assignment_;
  ExpectedMarkers agreeing_markers_;
  SpotAssignment agreeing_;
  CooperativeSolution solution_;
  AcquiredSpots acquired_;
  /// Of one camera: its latest tear, and torn frames in a row up to the frame before.
  struct Torn {
    Tear tear;
    int frames = 0;
  };
  std::array<Torn, config::max_cameras> torn_;
  enum class Search : std::uint8_t { none, running, found };
  Search search_ = Search::none;
  Time looked_at_;              ///< of the spots that are or were searched
  int searches_left_ = 0;       ///< frames that go on with them
  bool uses_expected_ = false;  ///< the search has turned to poses near the expected attitude
};

}  // namespace relnav::app
