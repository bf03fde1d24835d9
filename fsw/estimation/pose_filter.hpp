#pragma once
#include "fsw/base/time.hpp"
#include "fsw/estimation/motion_model.hpp"
#include "fsw/estimation/pose_least_squares.hpp"
#include "fsw/estimation/relative_state.hpp"

namespace relnav {

struct PoseFilterConfig {
  double velocity_sigma_m_s = 0.5;  ///< of the start velocity, each axis
  double rate_sigma_rad_s = 0.2;    ///< of the start rate
  ProcessNoise noise{0.05, 0.1};    ///< m/s^1.5, rad/s^1.5: targets under control
  double gate_chi2 = 35.9;          ///< six degrees of freedom, 3e-6: a pose beyond contradicts the motion
  double image_gate_chi2 = 13.8;    ///< two, 1e-3: the same of a single image

  /// invalid_argument: outside of the domain.
  [[nodiscard]] Status check() const {
    const bool valid = velocity_sigma_m_s > 0.0 && rate_sigma_rad_s > 0.0 && noise.acceleration_psd >= 0.0 &&
                       noise.angular_psd >= 0.0 && gate_chi2 > 0.0 && image_gate_chi2 > 0.0;
    return valid ? Status::ok : Status::invalid_argument;
  }
};

/// Velocity and rate from solved poses: Kalman filter over the rigid-target motion model, poses with their covariances as
/// measurements. Between frames it says where the target should be.
class PoseFilter {
 public:
  void configure(const PoseFilterConfig& config) { config_ = config; }
  [[nodiscard]] bool has_started() const { return started_; }
  void restart() { started_ = false; }
  void start(Time time, const PoseEstimate& measured);
  /// out_of_order: time does not advance; not_configured: not started.
  Status predict(Time time);
  /// inconsistent: the pose lies outside of the gate and was not used; not_positive_definite.
  Status update(const PoseEstimate& measured);
  /// Images of single markers, for frames that have too few for a pose: one after the other, in the order given. `used`
  /// tells which lay inside the gate.
  /// ok: at least one; inconsistent: none; not_positive_definite.
  Status update(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                ObservationMask& used);

  /// Where the target is by the filter.
  [[nodiscard]] Pose pose() const;
  [[nodiscard]] Mat6 pose_covariance() const;
  /// Normalised innovation squared of the latest update, 6 degrees of freedom.
  [[nodiscard]] double nis() const { return nis_; }
  [[nodiscard]] RelativeState output() const;

 private:
  PoseFilterConfig config_;
  /// Corrects the state by K innovation and P by K H P, from PH' and S (Size x Size) of the innovation; sets nis_.
  template <int Size>
  Status correct(const Mat<12, Size>& PH, Mat<Size, Size> S, Mat<Size> innovation, double gate_chi2);

  RigidTargetMotion model_;
  MotionState state_;
  Mat12 P_ = Mat12::Identity();
  Time time_;
  double nis_ = 0.0;
  bool started_ = false;
};

}  // namespace relnav
