#include "tests/unit/estimation/stereo_reference.hpp"

#include <Eigen/Geometry>
#include <cstdlib>

#include "tests/support/dense.hpp"

namespace relnav::test {

Vec3 reference_point(const CameraRig& rig, const PoseObservation& left, const PoseObservation& right) {
  Eigen::MatrixXd A(4, 3);
  Eigen::VectorXd b(4);
  for (const PoseObservation* o : {&left, &right}) {
    Vec3 ray;
    if (rig[o->camera].model.unproject(o->uv_px, ray) != Status::ok) std::abort();
    for (int k = 0; k < 2; ++k) {
      Vec3 row = Vec3::Zero();
      row(k) = -1.0;
      row.z() = ray(k) / ray.z();
      const Vec3 turned = rig[o->camera].R_KC.transpose() * row;
      for (int c = 0; c < 3; ++c) A(2 * o->camera + k, c) = turned(c);
      b(2 * o->camera + k) = -row.dot(rig[o->camera].t_KC);
    }
  }
  return solve_least_squares(A, b);
}

Pose reference_motor(const std::vector<Vec3>& p_T, const std::vector<Vec3>& p_C,
                     const std::vector<std::pair<std::size_t, std::size_t>>& lines, LineScale scale) {
  const auto rows = static_cast<Eigen::Index>(lines.size());
  const auto line = [&](const std::vector<Vec3>& p, const std::pair<std::size_t, std::size_t>& ends) {
    const Vec3 n = p[ends.second] - p[ends.first];
    const Vec3 m = p[ends.first].cross(p[ends.second]);
    const double length = scale == LineScale::unit ? n.norm() : 1.0;
    return std::pair<Vec3, Vec3>{n / length, m / length};
  };
  Eigen::MatrixXd N(4 * rows, 4);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Vec3 n_T = line(p_T, lines[static_cast<std::size_t>(i)]).first;
    const Vec3 n_C = line(p_C, lines[static_cast<std::size_t>(i)]).first;
    for (int k = 0; k < 4; ++k) {
      const Eigen::Quaterniond unit(Eigen::Vector4d(Eigen::Vector4d::Unit(k)));
      const Eigen::Quaterniond left = Eigen::Quaterniond(0.0, n_C.x(), n_C.y(), n_C.z()) * unit;
      const Eigen::Quaterniond right = unit * Eigen::Quaterniond(0.0, n_T.x(), n_T.y(), n_T.z());
      for (int r = 0; r < 4; ++r) N(4 * i + r, k) = left.coeffs()(r) - right.coeffs()(r);
    }
  }
  const Eigen::MatrixXd V = singular_vectors_of(N).V;
  Pose pose;
  pose.R_CT = Eigen::Quaterniond(V(3, 3), V(0, 3), V(1, 3), V(2, 3)).toRotationMatrix();
  Eigen::MatrixXd P(3 * rows, 3);
  Eigen::VectorXd Q(3 * rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto [n_T, m_T] = line(p_T, lines[static_cast<std::size_t>(i)]);
    const auto [n_C, m_C] = line(p_C, lines[static_cast<std::size_t>(i)]);
    const Vec3 difference = m_C - pose.R_CT * m_T;
    for (int k = 0; k < 3; ++k) {
      const Vec3 column = Vec3::Unit(k).cross(n_C);
      for (int r = 0; r < 3; ++r) P(3 * i + r, k) = column(r);
      Q(3 * i + k) = difference(k);
    }
  }
  pose.t_CT = solve_least_squares(P, Q);
  return pose;
}

Mat3 reference_rotation(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  Mat3 B = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) B += to[i] * from[i].transpose();
  const SingularVectors singular = singular_vectors_of(B);
  // The third pair made right-handed, which is Kabsch's sign of the least singular value.
  Mat3 U;
  Mat3 V;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 2; ++c) {
      U(r, c) = singular.U(r, c);
      V(r, c) = singular.V(r, c);
    }
  }
  U.col(2) = U.col(0).cross(U.col(1));
  V.col(2) = V.col(0).cross(V.col(1));
  return U * V.transpose();
}

Pose reference_orthogonal(const std::vector<Vec3>& p_T, const std::vector<Vec3>& p_C) {
  const std::size_t n = p_T.size();
  const auto axes = [n](const std::vector<Vec3>& p) {
    std::vector<Vec3> all;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 b = (p[(i + 1) % n] - p[i]).normalized();
      const Vec3 c = (p[(i + 2) % n] - p[i]).normalized();
      all.insert(all.end(), {b, c, b.cross(c).normalized()});
    }
    return all;
  };
  Pose pose;
  pose.R_CT = reference_rotation(axes(p_T), axes(p_C));
  for (const Vec3& p : p_C) pose.t_CT += p / static_cast<double>(n);
  return pose;
}

}  // namespace relnav::test
