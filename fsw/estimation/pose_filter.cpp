#include "fsw/estimation/pose_filter.hpp"

#include "fsw/attitude/quaternion.hpp"
#include "fsw/geometry/marker_image.hpp"
#include "fsw/math/covariance_kernels.hpp"

namespace relnav {
namespace {

Mat6 symmetric(const Mat6& m) { return 0.5 * (m + m.transpose()); }

}  // namespace

void PoseFilter::start(Time time, const PoseEstimate& measured) {
  time_ = time;
  state_ = model_.at_rest(AttitudeChartKind::rodrigues, measured.pose.R_CT, measured.pose.t_CT);
  // The chart's errors from those of the pose.
  Mat6 J_inverse = Mat6::Identity();
  J_inverse.block<3, 3>(3, 3) = state_.attitude.error_jacobian_inverse();
  P_.setZero();
  P_.block<6, 6>(0, 0) = symmetric(J_inverse.lazyProduct(measured.covariance).lazyProduct(J_inverse.transpose()));
  const double v2 = config_.velocity_sigma_m_s * config_.velocity_sigma_m_s;
  const double w2 = config_.rate_sigma_rad_s * config_.rate_sigma_rad_s;
  P_.diagonal().tail<6>() << v2, v2, v2, w2, w2, w2;
  nis_ = 0.0;
  started_ = true;
}

Status PoseFilter::predict(Time time) {
  if (!started_) return Status::not_configured;
  const double dt_s = (time - time_).seconds();
  if (!(dt_s > 0.0)) return Status::out_of_order;
  time_ = time;
  Mat12 F;
  Mat12 Q;
  model_.propagate(state_, dt_s, config_.noise, Vec3::Zero(), F, Q);
  const Mat12 FP = F.lazyProduct(P_);
  P_ = FP.lazyProduct(F.transpose());
  P_ += Q;
  Mat3 J;
  if (state_.attitude.switch_if_due(J)) {
    Mat12 T = Mat12::Identity();
    T.block<3, 3>(3, 3) = J;
    const Mat12 TP = T.lazyProduct(P_);
    P_ = TP.lazyProduct(T.transpose());
  }
  return Status::ok;
}

template <int Size>
Status PoseFilter::correct(const Mat<12, Size>& PH, Mat<Size, Size> S, Mat<Size> innovation, double gate_chi2) {
  const Status status = cholesky_lower(MatrixView{S.data(), Size, Size, Size});
  if (status != Status::ok) return status;
  // B = P H' L^-T, y = L^-1 innovation: K innovation = B y, K H P = B B'.
  Mat<12, Size> B = PH;
  solve_right_transposed({S.data(), Size, Size, Size}, {B.data(), 12, Size, 12});
  solve_lower({S.data(), Size, Size, Size}, {innovation.data(), Size});
  nis_ = innovation.squaredNorm();
  if (!(nis_ < gate_chi2)) return Status::inconsistent;
  const Mat<12> d = B.lazyProduct(innovation);
  state_.position += d.template segment<3>(0);
  state_.attitude.add(d.template segment<3>(3));
  state_.velocity += d.template segment<3>(6);
  state_.rate += d.template segment<3>(9);
  P_ -= B.lazyProduct(B.transpose());
  return Status::ok;
}

Status PoseFilter::update(const PoseEstimate& measured) {
  const PoseLinearisation predicted = model_.pose(state_);
  Vec6 innovation;
  innovation << measured.pose.t_CT - predicted.t_CT,
      Quaternion::from_dcm(measured.pose.R_CT * predicted.R_CT.transpose()).rotation_vector();
  const Mat<12, 6> PH = P_.leftCols<6>().lazyProduct(predicted.J.transpose());
  const Mat6 S = symmetric(predicted.J.lazyProduct(PH.topRows<6>())) + measured.covariance;
  return correct<6>(PH, S, innovation, config_.gate_chi2);
}

Status PoseFilter::update(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                          ObservationMask& used) {
  used.fill(false);
  Status result = Status::inconsistent;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PoseObservation& o = observations[i];
    const PoseLinearisation predicted = model_.pose(state_);
    MarkerImage image;
    if (image_of(rig[o.camera], target.features[o.feature].p_T, {predicted.R_CT, predicted.t_CT}, image) !=
        Status::ok) {
      continue;
    }
    const Mat<2, 6> H = image.J.lazyProduct(predicted.J);
    const Mat<12, 2> PH = P_.leftCols<6>().lazyProduct(H.transpose());
    Mat2 S = H.lazyProduct(PH.topRows<6>());
    S.diagonal().array() += o.sigma_px * o.sigma_px;
    const Status status = correct<2>(PH, S, o.uv_px - image.uv_px, config_.image_gate_chi2);
    if (status == Status::inconsistent) continue;
    if (status != Status::ok) return status;
    used[i] = true;
    result = Status::ok;
  }
  return result;
}

Pose PoseFilter::pose() const {
  const PoseLinearisation p = model_.pose(state_);
  return {p.R_CT, p.t_CT};
}

Mat6 PoseFilter::pose_covariance() const {
  const Mat6 J = model_.pose(state_).J;
  return symmetric(J.lazyProduct(P_.block<6, 6>(0, 0)).lazyProduct(J.transpose()));
}

RelativeState PoseFilter::output() const {
  RelativeState out;
  out.time = time_;
  const Pose p = pose();
  out.R_CT = p.R_CT;
  out.t_CT = p.t_CT;
  out.pose_covariance = pose_covariance();
  Mat<6, 12> J;
  model_.rates(state_, out.v_C, out.omega_C, J);
  const Mat<6, 12> JP = J.lazyProduct(P_);
  out.rate_covariance = symmetric(JP.lazyProduct(J.transpose()));
  return out;
}

}  // namespace relnav
