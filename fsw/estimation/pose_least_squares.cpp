#include "fsw/estimation/pose_least_squares.hpp"

#include <cmath>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/attitude/rodrigues.hpp"
#include "fsw/estimation/pose_iteration.hpp"

namespace relnav {
namespace {

/// Converged when the next step would improve chi-square by less than this: 3e-7 sigma.
constexpr double converged_gain = 1e-13;
constexpr double converged_step = 1e-14;
constexpr double cost_slack = 1e-12;
/// Rounding leaves up to 1.3e-9 of features on a line (27 000 random ones); three features with T's origin tens of their
/// size away come down to 2.5e-8.
constexpr double least_pivot = 5e-9;

class PixelRows {
 public:
  PixelRows(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations, double huber_sigma)
      : rig_(rig), target_(target), observations_(observations), huber_sigma_(huber_sigma) {}

  /// The i-th row is this observation.
  void use(std::size_t observation) {
    index_[count_] = static_cast<std::uint16_t>(observation);
    weight_[count_++] = 1.0 / observations_[observation].sigma_px;
  }
  [[nodiscard]] std::size_t count() const { return count_; }

  Status operator()(int i, const Mat3& R_CT, const Vec3& t_CT, PoseRow<double>& row) const {
    const PoseObservation& o = observations_[index_[static_cast<std::size_t>(i)]];
    row.X_r = R_CT * target_.features[o.feature].p_T;
    const Vec3 p_C = row.X_r + t_CT;
    const RigCamera& camera = rig_[o.camera];
    Vec2 uv_px;
    Mat23 J_uv_p;
    if (o.camera == 0) {
      const Status status = camera.model.project(p_C, uv_px, J_uv_p);
      if (status != Status::ok) return status;
      row.J = J_uv_p;
      row.axis = Vec3::UnitZ();
      row.depth = p_C.z();
    } else {
      const Vec3 p_K = camera.R_KC * p_C + camera.t_KC;
      const Status status = camera.model.project(p_K, uv_px, J_uv_p);
      if (status != Status::ok) return status;
      row.J = J_uv_p * camera.R_KC;
      row.axis = camera.R_KC.row(2);
      row.depth = p_K.z();
    }
    double weight = weight_[static_cast<std::size_t>(i)];
    row.r = weight * (o.uv_px - uv_px);
    row.extra_cost = 0.0;
    if (huber_sigma_ > 0.0) {
      const double e2 = row.r.squaredNorm();
      if (e2 > huber_sigma_ * huber_sigma_) {
        // Loss 2 k e - k^2, as a quadratic one with the weight k / e and a constant.
        const double e = std::sqrt(e2);
        const double share = std::sqrt(huber_sigma_ / e);
        row.r *= share;
        weight *= share;
        row.extra_cost = huber_sigma_ * (e - huber_sigma_);
      }
    }
    row.J *= weight;
    return Status::ok;
  }

 private:
  const CameraRig& rig_;
  const TargetModel& target_;
  const PoseObservations& observations_;
  double huber_sigma_;
  std::array<std::uint16_t, config::max_observations> index_;
  std::array<double, config::max_observations> weight_;
  std::size_t count_ = 0;
};

[[nodiscard]] bool is_valid(const CameraRig& rig, const TargetModel& target, const PoseObservation& o) {
  return o.camera < rig.size() && o.feature < target.features.size() && std::isfinite(o.sigma_px) && o.sigma_px > 0.0 &&
         std::isfinite(o.uv_px(0)) && std::isfinite(o.uv_px(1));
}

Status gather(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
              const ObservationMask& used, PixelRows& rows) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    if (!is_valid(rig, target, observations[i])) return Status::invalid_argument;
    rows.use(i);
  }
  return Status::ok;
}

GibbsSet<double> gibbs_set_of(const Mat3& R_CT, bool switching) {
  if (switching) {
    const RodriguesChart chart = RodriguesChart::from_dcm(R_CT);
    return {chart.parameters(), chart.set_index()};
  }
  const Quaternion q = Quaternion::from_dcm(R_CT);
  return {-q.vector() / q.w, 0};
}

void report(const PoseIteration<double>& iteration, int count, PoseEstimate& out) {
  out.pose = {iteration.attitude.dcm(), iteration.t};
  out.covariance = iteration.covariance();
  out.chi2 = iteration.cost();
  out.degrees_of_freedom = 2 * count - 6;
  out.used = count;
  out.iterations = iteration.iterations();
}

}  // namespace

Status solve_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                  const ObservationMask& used, const Pose& start, const PoseSolverSettings& settings,
                  PoseEstimate& out) {
  PixelRows rows(rig, target, observations, settings.huber_sigma);
  Status status = gather(rig, target, observations, used, rows);
  if (status != Status::ok) return status;
  PoseIteration<double> iteration;
  iteration.attitude = gibbs_set_of(start.R_CT, settings.switching);
  iteration.t = start.t_CT;
  IterationLimits<double> limits;
  limits.max_iterations = settings.max_iterations;
  limits.gain = converged_gain;
  limits.step = converged_step;
  limits.cost_slack = cost_slack;
  limits.least_pivot = least_pivot;
  limits.switching = settings.switching;
  const int count = static_cast<int>(rows.count());
  status = iteration.solve(count, rows, limits);
  if (status != Status::ok) return status;
  report(iteration, count, out);
  return Status::ok;
}

Status assess_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                   const ObservationMask& used, const Pose& pose, PoseEstimate& out) {
  PixelRows rows(rig, target, observations, 0.0);
  Status status = gather(rig, target, observations, used, rows);
  if (status != Status::ok) return status;
  PoseIteration<double> iteration;
  iteration.attitude = gibbs_set_of(pose.R_CT, true);
  iteration.t = pose.t_CT;
  const int count = static_cast<int>(rows.count());
  status = iteration.assess(count, rows, least_pivot);
  if (status != Status::ok) return status;
  report(iteration, count, out);
  return Status::ok;
}

Status whitened_residual(const CameraRig& rig, const TargetModel& target, const PoseObservation& observation,
                         const Pose& pose, Vec2& residual) {
  if (!is_valid(rig, target, observation)) return Status::invalid_argument;
  const Vec3 p_C = pose.R_CT * target.features[observation.feature].p_T + pose.t_CT;
  const RigCamera& camera = rig[observation.camera];
  Vec2 uv_px;
  const Status status = camera.model.project(Vec3(camera.R_KC * p_C + camera.t_KC), uv_px);
  if (status != Status::ok) return status;
  residual = (observation.uv_px - uv_px) / observation.sigma_px;
  return Status::ok;
}

}  // namespace relnav
