#include "fsw/estimation/start_handover.hpp"

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/inverse_depth.hpp"
#include "fsw/estimation/motion_model.hpp"

namespace relnav {
namespace {

using Theta = StartAdjustment::Theta;

Vec3 rate_C(const Theta& theta, double t_s) { return theta.segment<3>(6) + t_s * theta.segment<3>(9); }

/// Inverse-depth block of a track, with d y / d theta and the covariance that theta leaves.
void restore_feature(const Theta& theta, const StartAdjustment::TrackResult& track, std::size_t index,
                     FilterState& state) {
  const Vec3 phi = StartBundle::rotation_vector_C(theta, track.t_s);
  const Vec3 t_CT = StartBundle::centre_C(theta, track.t_s);
  const Mat3 R_CT = exp_so3(phi);
  const Mat3 R_TC = R_CT.transpose();
  const Vec3 ray_C(track.p(0), track.p(1), 1.0);
  const double length = ray_C.norm();
  Vec6 y;
  y.head<3>() = -(R_TC * t_CT);
  Mat23 J_angles;
  inverse_depth::angles_of(Vec3(R_TC * ray_C), y(3), y(4), J_angles);
  y(5) = track.p(2) / length;

  const Mat3 Jl = left_jacobian_so3(phi);
  const Mat3 dphi_domega = track.t_s * Jl;
  const Mat3 dphi_dalpha = (0.5 * track.t_s * track.t_s) * Jl;
  const Mat3 dr_dphi = -(R_TC * cross_matrix(t_CT));
  const Mat23 dangles_dphi = J_angles * (R_TC * cross_matrix(ray_C));
  Mat<6, 12> J = Mat<6, 12>::Zero();
  J.block<3, 3>(0, 0) = -R_TC;
  J.block<3, 3>(0, 3) = -track.t_s * R_TC;
  J.block<3, 3>(0, 6) = dr_dphi * dphi_domega;
  J.block<3, 3>(0, 9) = dr_dphi * dphi_dalpha;
  J.block<2, 3>(3, 6) = dangles_dphi * dphi_domega;
  J.block<2, 3>(3, 9) = dangles_dphi * dphi_dalpha;
  // y through p = (x y rho) of the first sight: angles turn with the ray, inverse distance = rho / |ray|.
  Mat<6, 3> J_p = Mat<6, 3>::Zero();
  J_p.block<2, 2>(3, 0) = (J_angles * R_TC).leftCols<2>();
  J_p.block<1, 2>(5, 0) = (-y(5) / (length * length)) * track.p.head<2>().transpose();
  J_p(5, 2) = 1.0 / length;
  J += J_p.lazyProduct(track.dp_dtheta);
  const Mat6 noise = J_p * track.covariance * J_p.transpose();
  state.restore(index, y, J, noise);
  Feature& f = state.features()[index];
  f.R_CT0 = R_CT;
  f.r_TC0 = y.head<3>();
}

}  // namespace

void take_over_start(const StartAdjustment::Result& start, double now_s, AttitudeChartKind chart, FilterState& state) {
  const Theta& theta = start.theta;
  const Vec3 phi = StartBundle::rotation_vector_C(theta, now_s);
  MotionState motion = RigidTargetMotion().at_rest(chart, exp_so3(phi), StartBundle::centre_C(theta, now_s));
  motion.velocity = theta.segment<3>(3);
  motion.rate = rate_C(theta, now_s);

  // theta plays the motion block's part while the features are rebuilt on it; the map from theta to the motion states now
  // is then one structured "prediction".
  state.begin_restore(motion, start.covariance);
  for (std::size_t i = 0; i < state.features().size(); ++i) {
    restore_feature(theta, start.tracks[state.features()[i].slot.index], i, state);
  }
  Mat12 F = Mat12::Zero();
  const Mat3 I = Mat3::Identity();
  const Mat3 dchart_dphi = motion.attitude.error_jacobian_inverse() * left_jacobian_so3(phi);
  F.block<3, 3>(0, 0) = I;
  F.block<3, 3>(0, 3) = now_s * I;
  F.block<3, 3>(3, 6) = now_s * dchart_dphi;
  F.block<3, 3>(3, 9) = (0.5 * now_s * now_s) * dchart_dphi;
  F.block<3, 3>(6, 3) = I;
  F.block<3, 3>(9, 6) = I;
  F.block<3, 3>(9, 9) = now_s * I;
  predict_motion(state.P(), F, Mat12::Zero());
}

void blend_start_hypotheses(const StartAdjustment::Result& start, double now_s, RelativeState& out) {
  const auto motion_of = [now_s](const Theta& theta) {
    Mat<12> m;  // t_CT, phi, v, omega
    m << StartBundle::centre_C(theta, now_s), StartBundle::rotation_vector_C(theta, now_s), theta.segment<3>(3),
        rate_C(theta, now_s);
    return m;
  };
  Mat<12> mean = Mat<12>::Zero();
  for (std::size_t i = 0; i < start.weights.size(); ++i) mean += start.weights[i] * motion_of(start.thetas[i]);
  for (std::size_t i = 0; i < start.weights.size(); ++i) {
    const Mat<12> d = motion_of(start.thetas[i]) - mean;
    const Vec6 pose = d.head<6>();
    const Vec6 rate = d.tail<6>();
    out.pose_covariance += start.weights[i] * (pose * pose.transpose());
    out.rate_covariance += start.weights[i] * (rate * rate.transpose());
  }
  out.t_CT = mean.segment<3>(0);
  out.R_CT = exp_so3(Vec3(mean.segment<3>(3)));
  out.v_C = mean.segment<3>(6);
  out.omega_C = mean.segment<3>(9);
}

}  // namespace relnav
