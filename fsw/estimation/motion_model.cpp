#include "fsw/estimation/motion_model.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "fsw/attitude/so3.hpp"

namespace relnav {
namespace {

/// Covariance of [x, x'] driven by white acceleration of the given density over dt (continuous white noise, exact).
void add_white_acceleration(Mat12& Q, int position, int velocity, const Mat3& M_position, double psd, double dt_s) {
  const double q = psd * psd;
  const Mat3 I = Mat3::Identity();
  Q.block<3, 3>(position, position) += (q * dt_s * dt_s * dt_s / 3.0) * (M_position * M_position.transpose());
  Q.block<3, 3>(position, velocity) += (q * dt_s * dt_s / 2.0) * M_position;
  Q.block<3, 3>(velocity, position) += (q * dt_s * dt_s / 2.0) * M_position.transpose();
  Q.block<3, 3>(velocity, velocity) += (q * dt_s) * I;
}

}  // namespace

void CameraMotion::propagate(MotionState& state, double dt_s, const ProcessNoise& noise, const Vec3& /*camera_rate_C*/,
                             Mat12& F, Mat12& Q) const {
  F.setIdentity();
  Q.setZero();
  state.position += dt_s * state.velocity;
  F.block<3, 3>(0, 6) = dt_s * Mat3::Identity();

  // R_TC' = R_TC [omega x], so R_CT is turned by -omega dt from the left.
  Mat3 dp_dp;
  Mat3 dp_dphi;
  state.attitude.rotate(-dt_s * state.rate, dp_dp, dp_dphi);
  F.block<3, 3>(3, 3) = dp_dp;
  F.block<3, 3>(3, 9) = -dt_s * dp_dphi;

  add_white_acceleration(Q, 0, 6, Mat3::Identity(), noise.acceleration_psd, dt_s);
  add_white_acceleration(Q, 3, 9, -dp_dphi, noise.angular_psd, dt_s);
}

PoseLinearisation CameraMotion::pose(const MotionState& state) const {
  PoseLinearisation out;
  out.R_CT = state.attitude.dcm();
  out.t_CT = -(out.R_CT * state.position);
  const Mat3 A = state.attitude.error_jacobian();
  out.J.setZero();
  out.J.block<3, 3>(0, 0) = -out.R_CT;
  out.J.block<3, 3>(0, 3) = -(cross_matrix(out.t_CT) * A);
  out.J.block<3, 3>(3, 3) = A;
  return out;
}

void CameraMotion::rates(const MotionState& state, Vec3& v_C, Vec3& omega_C, Mat<6, 12>& J) const {
  // t_CT = -R_CT r, R_CT' = -[w x] R_CT: t_CT' = -w x t_CT - R_CT v.
  const PoseLinearisation p = pose(state);
  omega_C = -state.rate;
  v_C = -state.rate.cross(p.t_CT) - p.R_CT * state.velocity;
  J.setZero();
  const Mat3 W = cross_matrix(state.rate);
  J.block<3, 6>(0, 0) = -(W * p.J.block<3, 6>(0, 0));
  J.block<3, 3>(0, 3) += cross_matrix(Vec3(p.R_CT * state.velocity)) * p.J.block<3, 3>(3, 3);
  J.block<3, 3>(0, 6) = -p.R_CT;
  J.block<3, 3>(0, 9) = cross_matrix(p.t_CT);
  J.block<3, 3>(3, 9) = -Mat3::Identity();
}

MotionState CameraMotion::at_rest(AttitudeChartKind chart, const Mat3& R_CT, const Vec3& t_CT) const {
  MotionState state;
  state.attitude = AttitudeState(chart, R_CT);
  state.position = -(R_CT.transpose() * t_CT);
  return state;
}

bool InertiaRatios::is_sphere() const { return !(second < 1.0) && !(second > 1.0) && !(third < 1.0) && !(third > 1.0); }

bool InertiaRatios::is_physical() const {
  return std::isfinite(second) && std::isfinite(third) && phi_TP.allFinite() && second > 0.0 && third > 0.0 &&
         1.0 <= second + third && second <= 1.0 + third && third <= 1.0 + second;
}

RigidTargetMotion::RigidTargetMotion(const InertiaRatios& inertia) : constant_rate_(inertia.is_sphere()) {
  const Mat3 R_TP = exp_so3(inertia.phi_TP);
  const Vec3 moments(1.0, inertia.second, inertia.third);
  J_T_ = R_TP * moments.asDiagonal() * R_TP.transpose();
  J_inverse_T_ = R_TP * moments.cwiseInverse().asDiagonal() * R_TP.transpose();
}

void RigidTargetMotion::turn(MotionState& state, double dt_s, Mat6& G) const {
  if (constant_rate_) {
    Mat3 dp_dp;
    Mat3 dp_dphi;
    state.attitude.rotate(dt_s * state.rate, dp_dp, dp_dphi);
    G.setIdentity();
    G.block<3, 3>(0, 0) = dp_dp;
    G.block<3, 3>(0, 3) = dt_s * dp_dphi;
    return;
  }
  int steps = 1;
  while (steps < max_steps && max_step_s * steps < dt_s) ++steps;  // bound: max_steps
  const double h = dt_s / steps;
  G.setIdentity();
  for (int i = 0; i < steps; ++i) {
    // omega' = R_CT a(R_TC omega), a(w) = -J^-1 (w x J w), one Euler step for the rate; the attitude turns by the mean of
    // the rates before and after.
    const Mat3 R_CT = state.attitude.dcm();
    const Vec3 w_T = R_CT.transpose() * state.rate;
    const Vec3 momentum_T = J_T_ * w_T;
    const Vec3 a_C = -(R_CT * (J_inverse_T_ * w_T.cross(momentum_T)));
    const Mat3 da_dw_T = J_inverse_T_ * (cross_matrix(momentum_T) - cross_matrix(w_T) * J_T_);
    const Mat3 da_dw = R_CT * da_dw_T * R_CT.transpose();
    // R_CT -> Exp(dphi) R_CT moves w_T by R_TC [omega x] dphi and turns a_C by dphi.
    const Mat3 da_dphi = da_dw * cross_matrix(state.rate) - cross_matrix(a_C);
    const Mat3 A = state.attitude.error_jacobian();

    Mat6 step = Mat6::Zero();
    step.block<3, 3>(3, 0) = h * da_dphi * A;
    step.block<3, 3>(3, 3) = Mat3::Identity() + h * da_dw;
    Mat3 dp_dp;
    Mat3 dp_dphi;
    const Vec3 rate_next = state.rate + h * a_C;
    state.attitude.rotate(0.5 * h * (state.rate + rate_next), dp_dp, dp_dphi);
    state.rate = rate_next;
    step.block<3, 3>(0, 0) = dp_dp + 0.5 * h * dp_dphi * step.block<3, 3>(3, 0);
    step.block<3, 3>(0, 3) = 0.5 * h * dp_dphi * (Mat3::Identity() + step.block<3, 3>(3, 3));
    G = step.lazyProduct(G).eval();
  }
}

void RigidTargetMotion::propagate(MotionState& state, double dt_s, const ProcessNoise& noise, const Vec3& camera_rate_C,
                                  Mat12& F, Mat12& Q) const {
  // In a camera frame turning at w_c every inertial vector x obeys x' = -w_c x x: one rotation E over the step.
  const Mat3 E = exp_so3(Vec3(-dt_s * camera_rate_C));
  F.setZero();
  Q.setZero();
  F.block<3, 3>(0, 0) = E;
  F.block<3, 3>(0, 6) = dt_s * E;
  F.block<3, 3>(6, 6) = E;
  state.position = E * (state.position + dt_s * state.velocity);
  state.velocity = E * state.velocity;

  // R_CT(next) = E R_CT turned by the target's own motion.
  Mat6 G;
  turn(state, dt_s, G);
  Mat3 camera_dp;
  Mat3 camera_dphi;
  state.attitude.rotate(-dt_s * camera_rate_C, camera_dp, camera_dphi);
  state.rate = E * state.rate;
  F.block<3, 3>(3, 3) = camera_dp * G.block<3, 3>(0, 0);
  F.block<3, 3>(3, 9) = camera_dp * G.block<3, 3>(0, 3);
  F.block<3, 3>(9, 3) = E * G.block<3, 3>(3, 0);
  F.block<3, 3>(9, 9) = E * G.block<3, 3>(3, 3);

  add_white_acceleration(Q, 0, 6, Mat3::Identity(), noise.acceleration_psd, dt_s);
  add_white_acceleration(Q, 3, 9, F.block<3, 3>(3, 9) / dt_s, noise.angular_psd, dt_s);
}

PoseLinearisation RigidTargetMotion::pose(const MotionState& state) const {
  PoseLinearisation out;
  out.R_CT = state.attitude.dcm();
  out.t_CT = state.position;
  out.J.setIdentity();
  out.J.block<3, 3>(3, 3) = state.attitude.error_jacobian();
  return out;
}

void RigidTargetMotion::rates(const MotionState& state, Vec3& v_C, Vec3& omega_C, Mat<6, 12>& J) const {
  v_C = state.velocity;
  omega_C = state.rate;
  J.setZero();
  J.block<6, 6>(0, 6).setIdentity();
}

MotionState RigidTargetMotion::at_rest(AttitudeChartKind chart, const Mat3& R_CT, const Vec3& t_CT) const {
  MotionState state;
  state.attitude = AttitudeState(chart, R_CT);
  state.position = t_CT;
  return state;
}

}  // namespace relnav
