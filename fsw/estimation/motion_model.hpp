#pragma once
#include <cstdint>

#include "fsw/estimation/attitude_state.hpp"
#include "fsw/estimation/relative_state.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

using Mat12 = Mat<12, 12>;

/// First twelve filter states: [position | attitude chart | velocity | rate]. What position, velocity and rate mean
/// is the motion model's business; the attitude is R_CT always.
struct MotionState {
  Vec3 position = Vec3::Zero();
  AttitudeState attitude;
  Vec3 velocity = Vec3::Zero();
  Vec3 rate = Vec3::Zero();
};

/// Pose of T in C and its dependence on the states: [dt_CT dphi_C] = J [d position, d chart parameters].
struct PoseLinearisation {
  Mat3 R_CT = Mat3::Identity();
  Vec3 t_CT = Vec3::Zero();
  Mat6 J = Mat6::Identity();
};

/// White-noise accelerations driving velocity and rate (power spectral densities, 1 sigma).
struct ProcessNoise {
  double acceleration_psd = 0.0;  ///< m/s^1.5
  double angular_psd = 0.0;       ///< rad/s^1.5
};

/// How the motion states evolve and what pose they mean. Two models, one interface (spec/noncooperative.md, last section).
class MotionModel {
 public:
  /// Propagates over dt_s. camera_rate_C is the camera's own inertial rate (known input, rad/s, zero by default).
  /// F = d next / d previous (12 x 12), Q the process noise covariance of the step.
  virtual void propagate(MotionState& state, double dt_s, const ProcessNoise& noise, const Vec3& camera_rate_C,
                         Mat12& F, Mat12& Q) const = 0;
  [[nodiscard]] virtual PoseLinearisation pose(const MotionState& state) const = 0;
  /// v_C and omega_C of RelativeState and J = d[v_C omega_C]/d states (6 x 12).
  virtual void rates(const MotionState& state, Vec3& v_C, Vec3& omega_C, Mat<6, 12>& J) const = 0;
  /// Motion states that mean the given pose at rest.
  [[nodiscard]] virtual MotionState at_rest(AttitudeChartKind chart, const Mat3& R_CT, const Vec3& t_CT) const = 0;

 protected:
  MotionModel() = default;
  MotionModel(const MotionModel&) = default;
  MotionModel& operator=(const MotionModel&) = default;
  ~MotionModel() = default;
};

/// The paper's model, eq. (14) with the misprint in its attitude row mended: the camera moves through T with constant
/// velocity and rate. position = r_TC (m), velocity = v_T (m/s), rate = omega_C of the camera relative to T (rad/s).
class CameraMotion final : public MotionModel {
 public:
  void propagate(MotionState& state, double dt_s, const ProcessNoise& noise, const Vec3& camera_rate_C, Mat12& F,
                 Mat12& Q) const override;
  [[nodiscard]] PoseLinearisation pose(const MotionState& state) const override;
  void rates(const MotionState& state, Vec3& v_C, Vec3& omega_C, Mat<6, 12>& J) const override;
  [[nodiscard]] MotionState at_rest(AttitudeChartKind chart, const Mat3& R_CT, const Vec3& t_CT) const override;
};

/// Principal moments of inertia of a target over the first of them, and where their axes lie.
struct InertiaRatios {
  double second = 1.0;
  double third = 1.0;
  Vec3 phi_TP = Vec3::Zero();  ///< principal axes P in T: R_TP = Exp([phi_TP x]), rad

  /// All moments equal: the rate is constant.
  [[nodiscard]] bool is_sphere() const;
  /// Finite, positive, and no moment larger than the sum of the other two.
  [[nodiscard]] bool is_physical() const;
};

/// A free rigid target seen from a camera whose own motion is known. Its centre drifts; its rate is constant, or, with unequal
/// moments of inertia, obeys Euler's equations without torque, J omega' = -omega x J omega (Wertz, Spacecraft Attitude
/// Determination and Control, ch. 16), in steps of at most max_step_s and at most max_steps of them.
/// position = t_CT (m), velocity = d t_CT/dt in a camera that does not turn (m/s), rate = inertial rate of the target,
/// expressed in C (rad/s).
class RigidTargetMotion final : public MotionModel {
 public:
  static constexpr double max_step_s = 0.05;
  static constexpr int max_steps = 64;

  RigidTargetMotion() = default;
  explicit RigidTargetMotion(const InertiaRatios& inertia);

  void propagate(MotionState& state, double dt_s, const ProcessNoise& noise, const Vec3& camera_rate_C, Mat12& F,
                 Mat12& Q) const override;
  [[nodiscard]] PoseLinearisation pose(const MotionState& state) const override;
  void rates(const MotionState& state, Vec3& v_C, Vec3& omega_C, Mat<6, 12>& J) const override;
  [[nodiscard]] MotionState at_rest(AttitudeChartKind chart, const Mat3& R_CT, const Vec3& t_CT) const override;

 private:
  /// Attitude and rate over dt_s in a camera that does not turn. G = d[attitude chart, rate] next / d previous.
  void turn(MotionState& state, double dt_s, Mat6& G) const;

  bool constant_rate_ = true;
  Mat3 J_T_ = Mat3::Identity();  ///< inertia over its first moment, axes of T
  Mat3 J_inverse_T_ = Mat3::Identity();
};

}  // namespace relnav
