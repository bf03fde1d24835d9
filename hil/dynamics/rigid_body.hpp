#pragma once
#include <Eigen/LU>

#include "hil/dynamics/grid_integrator.hpp"
#include "hil/dynamics/turning.hpp"

namespace relnav::hil {

/// Attitude and rate of a rigid body without torque but a random one: Euler's equations in body axes,
/// J domega/dt = -omega x J omega + torque, and dq/dt = q (0, omega) / 2 for the quaternion of R_IT (Wertz, Spacecraft
/// Attitude Determination and Control, 1978, eqs. 16-2 and 16-52).
struct RigidBodyModel {
  using State = Mat<7>;               ///< quaternion of R_IT (x y z w), omega_IT_T (rad/s)
  Mat3 inertia_T = Mat3::Identity();  ///< about the centre of mass, kg m^2
  Mat3 inverse_inertia_T = Mat3::Identity();

  explicit RigidBodyModel(const Mat3& inertia) : inertia_T(inertia), inverse_inertia_T(inertia.inverse()) {}

  [[nodiscard]] State rates(const State& x, const Vec3& torque_T) const {
    const Vec3 q = x.head<3>();
    const Vec3 omega_T = x.tail<3>();
    State d;
    d << 0.5 * (x(3) * omega_T + q.cross(omega_T)), -0.5 * q.dot(omega_T),
        inverse_inertia_T * (torque_T - omega_T.cross(inertia_T * omega_T));
    return d;
  }
  void tidy(State& x) const { x.head<4>().normalize(); }
};

/// On a grid of 50 ms; good for rates to some 360 deg/s. `density`: of the random torque, N m s^0.5 (two-sided, each
/// axis): without gyroscopic terms it lets a rate wander by density / J sqrt(t).
class RigidBody {
 public:
  RigidBody(const Mat3& inertia_T, const Mat3& R_IT, const Vec3& omega_IT_T, double density, std::uint64_t seed)
      : motion_(RigidBodyModel(inertia_T), start(R_IT, omega_IT_T), Time{0}, Duration{50'000'000}, density, seed) {}

  /// T against I.
  [[nodiscard]] Turning at(Time time) {
    const RigidBodyModel::State x = motion_.at(time);
    const Mat3 R_IT = Eigen::Quaterniond(x(3), x(0), x(1), x(2)).toRotationMatrix();
    return {R_IT, R_IT * x.tail<3>()};
  }

 private:
  [[nodiscard]] static RigidBodyModel::State start(const Mat3& R_IT, const Vec3& omega_IT_T) {
    const Eigen::Quaterniond q(R_IT);
    return (RigidBodyModel::State() << q.vec(), q.w(), omega_IT_T).finished();
  }

  GridIntegrator<RigidBodyModel> motion_;
};

}  // namespace relnav::hil
