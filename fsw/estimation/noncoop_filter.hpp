#pragma once
#include "fsw/base/time.hpp"
#include "fsw/estimation/ekf_update.hpp"
#include "fsw/estimation/filter_state.hpp"
#include "fsw/estimation/noncoop_config.hpp"
#include "fsw/estimation/one_point_ransac.hpp"
#include "fsw/estimation/start_adjustment.hpp"
#include "fsw/geometry/camera_model.hpp"
#include "fsw/geometry/feature_exchange.hpp"

namespace relnav {

/// Verdict on one match.
enum class MatchVerdict : std::uint8_t { incompatible, outlier, low_innovation, high_innovation };

struct FilterUpdate {
  Status status = Status::ok;  ///< not ok: an update was refused, the state is the predicted one
  int compatible = 0;          ///< matches inside their own gate
  int inliers = 0;             ///< used, low and high innovation
  int hypotheses = 0;          ///< of the one-point RANSAC
  double nis = 0.0;            ///< of the low-innovation update
  int rows = 0;                ///< its degrees of freedom
  std::array<MatchVerdict, config::max_features> verdict{};  ///< by position in the matches
  bool chart_switched = false;
};

/// Inverse-depth EKF with one-point RANSAC: spec/noncooperative.md, after Liu 2017 and Civera 2010.
/// Call order per frame: predict, predict_features, update, then add features in free slots.
class NoncoopFilter {
 public:
  /// invalid_argument as NoncoopConfig::validate(); the filter then keeps what it had.
  Status configure(const NoncoopConfig& config, const CameraModel& camera);

  /// Places T: axes as C now; origin `range` along los_C (rigid target) or at the camera (camera motion).
  /// half_extent: the target's apparent half width over its distance; sets how deep it may be.
  void start(Time time, const Vec3& los_C, double half_extent);
  /// Adds the common-scale uncertainty of the start range; once, after the first features.
  void add_scale_uncertainty();

  /// To the time of the next frame. camera_rate_C: the camera's own inertial rate, rad/s.
  Status predict(Time time, const Vec3& camera_rate_C = Vec3::Zero());
  /// Where each feature should be seen. Features outside the image or behind the camera are left out.
  void predict_features(FeaturePredictions& predictions);
  FilterUpdate update(const FeatureMatches& matches);

  [[nodiscard]] bool has_room() const { return state_.has_room(); }
  /// New feature at a pixel, in inverse depth. Status as make_new_feature(), or no_capacity.
  Expected<SlotHandle> add_feature(const Vec2& uv_px);
  /// Drops features that have served; their handles are appended to `dropped`.
  void drop_spent_features(BoundedVector<SlotHandle, config::max_features>& dropped);

  /// The start adjustment has not yet handed over for good.
  [[nodiscard]] bool is_starting() const { return starting_; }
  [[nodiscard]] RelativeState output() const;
  [[nodiscard]] const FilterState& state() const { return state_; }
  [[nodiscard]] const NoncoopConfig& config() const { return config_; }

 private:
  [[nodiscard]] bool is_rigid() const { return config_.motion == MotionKind::rigid_target; }
  [[nodiscard]] const MotionModel& model() const;
  [[nodiscard]] Mat2 appearance_warp(const Feature& feature, const PoseLinearisation& pose) const;
  /// Features move over the target a little as it turns.
  void let_features_walk(double dt_s);
  /// Linearises a match at the current state. True when it is predictable and inside its gate.
  [[nodiscard]] bool linearise(const CompatibleMatch& match, const PoseLinearisation& pose,
                               Innovation& innovation) const;
  /// Most depths negative: the mirror image of the camera's motion has been taken; turned back exactly.
  void undo_mirrored_scale();
  void convert_linear_features();
  /// The parts of update(): gate each match, update with the RANSAC's inliers and rescue the rest, keep the records.
  void gather_compatible(const FeatureMatches& matches, FilterUpdate& out);
  void update_with_inliers(const RansacResult& low, FilterUpdate& out);
  void record_use(const FilterUpdate& out);
  /// Feeds the start adjustment with this frame. True when it has an answer; the filter is then set to it.
  bool adjust_start(const FeatureMatches& matches);
  /// Over the first frames turning and moving look the same: all hypotheses are linearised about flat relief and rest, and sure
  /// of it. Until the start is adjusted over start_frames, what the prior allows of either across the line of sight stays open:
  /// P += (sigma t)^2 (I - l l^T), l along t_CT; m, rad, and without t m/s, rad/s (docs/estimators.md, honesty of the covariance).
  void widen_by_prior(RelativeState& out) const;
  [[nodiscard]] double since_start_s() const { return (time_ - start_time_).seconds(); }

  NoncoopConfig config_;
  CameraModel camera_;
  CameraMotion camera_motion_;
  RigidTargetMotion rigid_motion_;
  FilterState state_;
  EkfUpdate ekf_;
  CompatibleMatches compatible_;
  std::array<std::size_t, config::max_features> match_of_{};  ///< compatible -> position in the matches
  Innovations innovations_;
  Generator generator_{1};
  Time time_;
  Time start_time_;
  StartAdjustment start_;
  StartAdjustment::Result start_result_;
  int start_frames_ = 0;      ///< frames fed to the start adjustment
  bool start_valid_ = false;  ///< start_result_ belongs to this frame
  bool starting_ = false;     ///< the start adjustment still runs
  double relief_ = 0.1;       ///< relative depth spread of the target
};

}  // namespace relnav
