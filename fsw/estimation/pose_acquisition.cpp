#include "fsw/estimation/pose_acquisition.hpp"

#include <cmath>
#include <limits>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/attitude/so3.hpp"
#include "fsw/math/symmetric_eigen.hpp"

namespace relnav {
namespace {

constexpr std::size_t least_features = 4;
/// Second principal spread over the first under which the features count as lying on a line.
constexpr double least_width = 1e-8;
/// Two solutions closer than this (cosine of half the angle between them) are one: 0.6 deg.
constexpr double same_attitude = 0.99999;

/// Rotation that takes the unit vector d to the optical axis, the shortest way.
Mat3 turned_to_axis(const Vec3& d) {
  const Quaternion q{d.y(), -d.x(), 0.0, 1.0 + d.z()};  // d.z() > 0: never zero
  return q.normalised().dcm();
}

/// With rows I, J up to scale: the nearest rotation with these first two rows, by equal treatment of both.
Mat3 rotation_from_rows(const Vec3& I, const Vec3& J) {
  const Vec3 i = I.normalized();
  const Vec3 j = J.normalized();
  const Vec3 sum = (i + j).normalized();
  const Vec3 difference = (i - j).normalized();
  constexpr double half = 0.70710678118654752440;
  Mat3 R;
  R.row(0) = half * (sum + difference).transpose();
  R.row(1) = half * (sum - difference).transpose();
  R.row(2) = (cross_matrix(Vec3(R.row(0).transpose())) * R.row(1).transpose()).transpose();
  return R;
}

/// Features of one camera: rays turned to the axis, points about their middle.
struct Cluster {
  std::array<Vec2, config::max_target_features> xy;
  std::array<Vec3, config::max_target_features> X_T;
  std::size_t count = 0;
  Vec3 middle_T = Vec3::Zero();
  Vec2 middle_xy = Vec2::Zero();
  Mat3 R_AC = Mat3::Identity();  ///< C to the camera turned to the features
};

Status gather(const RigCamera& camera, const TargetModel& target, const PoseObservations& observations,
              const ObservationMask& used, std::uint16_t number, Cluster& out) {
  std::array<Vec3, config::max_target_features> rays;
  Vec3 axis = Vec3::Zero();
  for (std::size_t i = 0; i < observations.size() && out.count < rays.size(); ++i) {
    const PoseObservation& o = observations[i];
    if (!used[i] || o.camera != number) continue;
    if (o.feature >= target.features.size()) return Status::invalid_argument;
    const Status status = camera.model.unproject(o.uv_px, rays[out.count]);
    if (status != Status::ok) return status;
    axis += rays[out.count].normalized();
    out.X_T[out.count] = target.features[o.feature].p_T;
    out.middle_T += out.X_T[out.count];
    ++out.count;
  }
  if (out.count < least_features) return Status::too_few_features;
  out.R_AC = turned_to_axis(axis.normalized());
  const double n = static_cast<double>(out.count);
  out.middle_T /= n;
  for (std::size_t i = 0; i < out.count; ++i) {
    const Vec3 ray_A = out.R_AC * rays[i];
    if (!(ray_A.z() > 0.0)) return Status::outside_domain;
    out.xy[i] = ray_A.head<2>() / ray_A.z();
    out.middle_xy += out.xy[i];
    out.X_T[i] -= out.middle_T;
  }
  out.middle_xy /= n;
  return Status::ok;
}

/// The camera that sees most features, and how many.
std::size_t largest_count(const PoseObservations& observations, const ObservationMask& used, std::uint16_t& camera) {
  std::array<std::size_t, config::max_cameras> count{};
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (used[i] && observations[i].camera < count.size()) ++count[observations[i].camera];
  }
  camera = 0;
  for (std::size_t c = 1; c < count.size(); ++c) {
    if (count[c] > count[camera]) camera = static_cast<std::uint16_t>(c);
  }
  return count[camera];
}

Vec3 middle_of(const TargetModel& target, const PoseObservations& observations, const ObservationMask& used) {
  Vec3 sum = Vec3::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    sum += target.features[observations[i].feature].p_T;
    count += 1.0;
  }
  return sum / count;
}

/// Attitudes spread evenly: the 24 rotations of a cube.
Mat3 cube_rotation(int k) {
  const int axis = k / 4 % 3;
  const double sign = k < 12 ? 1.0 : -1.0;
  Vec3 z = Vec3::Zero();
  z[axis] = sign;
  Vec3 x = Vec3::Zero();
  x[(axis + 1) % 3] = 1.0;
  const Vec3 y = cross_matrix(z) * x;
  constexpr double cosine[4] = {1.0, 0.0, -1.0, 0.0};
  constexpr double sine[4] = {0.0, 1.0, 0.0, -1.0};
  Mat3 R;
  R.col(0) = cosine[k % 4] * x + sine[k % 4] * y;
  R.col(1) = cosine[k % 4] * y - sine[k % 4] * x;
  R.col(2) = z;
  return R;
}
constexpr int cube_rotations = 24;

/// Keeps the two best different minima.
class Minima {
 public:
  void offer(const PoseEstimate& e) {
    if (has_best_ && are_same(e, best_)) {
      if (e.chi2 < best_.chi2) best_ = e;
      return;
    }
    if (!has_best_ || e.chi2 < best_.chi2) {
      if (has_best_) set_other(best_);
      best_ = e;
      has_best_ = true;
    } else if (!has_other_ || e.chi2 < other_.chi2) {
      set_other(e);
    }
  }
  [[nodiscard]] bool has_best() const { return has_best_; }
  [[nodiscard]] bool has_other() const { return has_other_; }
  [[nodiscard]] const PoseEstimate& best() const { return best_; }
  [[nodiscard]] const PoseEstimate& other() const { return other_; }

 private:
  static bool are_same(const PoseEstimate& a, const PoseEstimate& b) {
    const Quaternion q = Quaternion::from_dcm(a.pose.R_CT * b.pose.R_CT.transpose());
    return q.w > same_attitude;
  }
  void set_other(const PoseEstimate& e) {
    other_ = e;
    has_other_ = true;
  }
  PoseEstimate best_;
  PoseEstimate other_;
  bool has_best_ = false;
  bool has_other_ = false;
};

}  // namespace

Status orthographic_starts(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                           const ObservationMask& used, std::uint16_t camera, std::array<Pose, 2>& starts) {
  if (camera >= rig.size()) return Status::invalid_argument;
  Cluster cluster;
  const Status status = gather(rig[camera], target, observations, used, camera, cluster);
  if (status != Status::ok) return status;

  // Principal axes of the features: the image depends on the first two linearly, uncorrelated with the third.
  Mat3 scatter = Mat3::Zero();
  Mat<3, 2> mixed = Mat<3, 2>::Zero();
  for (std::size_t i = 0; i < cluster.count; ++i) {
    scatter += cluster.X_T[i] * cluster.X_T[i].transpose();
    mixed += cluster.X_T[i] * (cluster.xy[i] - cluster.middle_xy).transpose();
  }
  Mat3 axes;
  symmetric_eigen<double, 3>(scatter, axes);
  int third = 0;
  for (int k = 1; k < 3; ++k) {
    if (scatter(k, k) < scatter(third, third)) third = k;
  }
  const int first = third == 0 ? 1 : 0;
  const int second = 3 - third - first;
  const double spread1 = std::max(scatter(first, first), scatter(second, second));
  const double spread2 = std::min(scatter(first, first), scatter(second, second));
  if (!(spread2 > least_width * spread1)) return Status::rank_deficient;
  const Vec2 along1 = mixed.transpose() * axes.col(first) / scatter(first, first);
  const Vec2 along2 = mixed.transpose() * axes.col(second) / scatter(second, second);

  // x = I.X, y = J.X with I = (along1.x, along2.x, alpha), J = (along1.y, along2.y, beta) in the principal axes; alpha and
  // beta up to a common sign from I.J = 0, |I| = |J|.
  const double c = -(along1.x() * along1.y() + along2.x() * along2.y());
  const double d =
      (along1.y() * along1.y() + along2.y() * along2.y()) - (along1.x() * along1.x() + along2.x() * along2.x());
  const double root = std::sqrt(d * d + 4.0 * c * c);
  double alpha = std::sqrt(std::max(0.0, 0.5 * (root + d)));
  double beta = std::sqrt(std::max(0.0, 0.5 * (root - d)));
  if (c < 0.0) beta = -beta;

  for (std::size_t k = 0; k < 2; ++k) {
    const Vec3 I = along1.x() * axes.col(first) + along2.x() * axes.col(second) + alpha * axes.col(third);
    const Vec3 J = along1.y() * axes.col(first) + along2.y() * axes.col(second) + beta * axes.col(third);
    const double scale = std::sqrt(I.norm() * J.norm());
    if (!(scale > 0.0)) return Status::rank_deficient;
    const Mat3 R_AT = rotation_from_rows(I, J);
    const double depth = 1.0 / scale;
    const Vec3 middle_A(depth * cluster.middle_xy.x(), depth * cluster.middle_xy.y(), depth);
    const Mat3 R_KT = cluster.R_AC.transpose() * R_AT;
    const Vec3 t_KT = cluster.R_AC.transpose() * (middle_A - R_AT * cluster.middle_T);
    const Mat3 R_CK = rig[camera].R_KC.transpose();
    starts[k].R_CT = R_CK * R_KT;
    starts[k].t_CT = R_CK * (t_KT - rig[camera].t_KC);
    alpha = -alpha;
    beta = -beta;
  }
  return Status::ok;
}

Status acquire_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                    const ObservationMask& used, const AcquisitionSettings& settings, AcquiredPose& out) {
  std::uint16_t camera = 0;
  if (largest_count(observations, used, camera) < least_features) return Status::too_few_features;
  std::array<Pose, 2> starts;
  Status status = orthographic_starts(rig, target, observations, used, camera, starts);
  if (status != Status::ok) return status;
  Minima minima;
  Status last = Status::no_convergence;
  for (const Pose& start : starts) {
    PoseEstimate e;
    status = solve_pose(rig, target, observations, used, start, settings.solver, e);
    if (status == Status::ok) {
      minima.offer(e);
    } else if (status == Status::invalid_argument) {
      return status;  // of any camera: what follows takes the indices for granted
    } else {
      last = status;
    }
  }
  const auto fits = [&] {
    return minima.has_best() &&
           minima.best().chi2 <= settings.alarm_chi2_factor * static_cast<double>(minima.best().degrees_of_freedom + 6);
  };
  const Vec3 middle_T = middle_of(target, observations, used);
  const Vec3 middle_C = starts[0].R_CT * middle_T + starts[0].t_CT;
  for (int k = 0; k < cube_rotations && !fits(); ++k) {
    // The middle stays where it is seen; only the attitude about it is another one.
    Pose start;
    start.R_CT = starts[0].R_CT * cube_rotation(k);
    start.t_CT = middle_C - start.R_CT * middle_T;
    PoseEstimate e;
    status = solve_pose(rig, target, observations, used, start, settings.solver, e);
    if (status == Status::ok) minima.offer(e);
  }
  if (!minima.has_best()) return last;
  out.best = minima.best();
  out.ambiguous = minima.has_other() && minima.other().chi2 - minima.best().chi2 < settings.ambiguous_chi2;
  if (out.ambiguous) out.other = minima.other();
  return Status::ok;
}

}  // namespace relnav
