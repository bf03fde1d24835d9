#include "hil/evaluate/alignment.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace relnav::hil {
namespace {

constexpr double collinear_ratio = 0.01;  // second over first standard deviation of the positions
constexpr double rank_ratio = 1e-3;       // of singular values

struct Moments {
  Vec3 mean = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();
};

Moments moments(const std::vector<Vec3>& points) {
  Moments m;
  const auto n = static_cast<double>(points.size());
  for (const Vec3& p : points) m.mean += p / n;
  for (const Vec3& p : points) m.covariance += (p - m.mean) * (p - m.mean).transpose() / n;
  return m;
}

// Second over first standard deviation.
double straightness_of(const Mat3& covariance) {
  const Vec3 values = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues();
  return values(2) > 0.0 ? std::sqrt(std::max(values(1), 0.0) / values(2)) : 0.0;
}

Mat3 nearest_rotation(const Mat3& m) {
  const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 sign = Vec3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign(2) = -1.0;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Similarity fit_similarity(const Trajectory& truth, const Trajectory& estimate, bool with_scale,
                          bool rotation_from_attitudes) {
  std::vector<Vec3> reference;
  std::vector<Vec3> moved;
  for (const TimedPose& pose : truth) reference.push_back(camera_centre(pose));
  for (const TimedPose& pose : estimate) moved.push_back(camera_centre(pose));
  const Moments to = moments(reference);
  const Moments from = moments(moved);
  Mat3 cross = Mat3::Zero();
  for (std::size_t i = 0; i < moved.size(); ++i) {
    cross += (reference[i] - to.mean) * (moved[i] - from.mean).transpose() / static_cast<double>(moved.size());
  }
  Similarity similarity;
  similarity.straightness = straightness_of(to.covariance);
  const bool spans_a_plane =
      similarity.straightness > collinear_ratio && straightness_of(from.covariance) > collinear_ratio;
  if (spans_a_plane && !rotation_from_attitudes) {
    similarity.R = nearest_rotation(cross);
  } else {
    Mat3 sum = Mat3::Zero();
    for (std::size_t i = 0; i < truth.size(); ++i) sum += truth[i].R_CT.transpose() * estimate[i].R_CT;
    similarity.R = nearest_rotation(sum);
    similarity.rotation_from_attitudes = true;
  }
  if (with_scale) {
    const double variance = from.covariance.trace();
    if (!(variance > 1e-24)) throw std::runtime_error("the estimated camera does not move: a scale cannot be fitted");
    similarity.scale = (similarity.R.transpose() * cross).trace() / variance;
    if (!(similarity.scale > 0.0))
      throw std::runtime_error("the fitted scale is not positive: the trajectories do not resemble each other");
  }
  similarity.t = to.mean - similarity.scale * similarity.R * from.mean;
  return similarity;
}

Trajectory apply_similarity(const Similarity& similarity, const Trajectory& estimate) {
  Trajectory aligned = estimate;
  for (TimedPose& pose : aligned) {
    pose.R_CT = pose.R_CT * similarity.R.transpose();
    pose.t_CT = similarity.scale * pose.t_CT - pose.R_CT * similarity.t;
  }
  return aligned;
}

BodyPointFit fit_body_point(const Trajectory& truth, const Trajectory& estimate) {
  using Mat4 = Mat<4, 4>;
  using Vec4 = Mat<4>;
  BodyPointFit fit;
  const double first_range = estimate.front().t_CT.norm();
  fit.scale = first_range > 1e-9 ? truth.front().t_CT.norm() / first_range : 1.0;
  const double prior_scale = fit.scale;
  // Unknowns: u = (scale - prior) * rms range of the estimate, and b: both then have unit columns, in metres of the truth.
  double range2 = 0.0;
  for (const TimedPose& pose : estimate) range2 += pose.t_CT.squaredNorm() / static_cast<double>(estimate.size());
  const double unit = range2 > 1e-18 ? std::sqrt(range2) : 1.0;
  Mat4 normal = Mat4::Zero();
  Vec4 right = Vec4::Zero();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    Mat<3, 4> row;
    row.leftCols<1>() = estimate[i].t_CT / unit;
    row.rightCols<3>() = -truth[i].R_CT;
    normal += row.transpose() * row;
    right += row.transpose() * (truth[i].t_CT - prior_scale * estimate[i].t_CT);
  }
  const Eigen::SelfAdjointEigenSolver<Mat4> eigen(normal);
  const Vec4 values = eigen.eigenvalues();
  Vec4 x = Vec4::Zero();
  for (int k = 0; k < 4; ++k) {
    if (values(k) <= rank_ratio * rank_ratio * values(3)) continue;
    ++fit.rank;
    x += eigen.eigenvectors().col(k) * (eigen.eigenvectors().col(k).dot(right) / values(k));
  }
  fit.condition = values(0) > 0.0 ? std::sqrt(values(3) / values(0)) : std::numeric_limits<double>::infinity();
  fit.scale += x(0) / unit;
  fit.b_T = x.tail<3>();
  return fit;
}

}  // namespace relnav::hil
