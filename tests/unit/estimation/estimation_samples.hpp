#pragma once
// What the estimation tests share: a camera, random vectors and attitudes, dense copies of the filter's matrices.
#include <cstdlib>
#include <string>
#include <vector>

#include "fsw/attitude/so3.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/estimation/filter_state.hpp"
#include "fsw/geometry/camera_model.hpp"

namespace relnav::test {

constexpr double degree = 0.017453292519943295;

inline CameraModel sample_camera() {
  CameraIntrinsics k;
  k.fu = 700.0;
  k.fv = 705.0;
  k.cu = 510.0;
  k.cv = 385.0;
  k.width_px = 1024;
  k.height_px = 768;
  const Expected<CameraModel> camera = CameraModel::create(k);
  if (!camera) std::abort();
  return camera.value();
}

class Samples {
 public:
  explicit Samples(std::uint64_t seed) : generator_(seed, 5) {}
  double uniform(double low, double high) { return low + (high - low) * generator_.uniform(); }
  /// Between two corners. The order of the draws is ours, not each compiler's order of a call's arguments.
  Vec3 within(const Vec3& low, const Vec3& high) {
    Vec3 v;
    for (int k = 2; k >= 0; --k) v(k) = uniform(low(k), high(k));
    return v;
  }
  template <int Rows, int Cols = 1>
  Mat<Rows, Cols> matrix(double size = 1.0) {
    Mat<Rows, Cols> m;
    for (int c = 0; c < Cols; ++c) {
      for (int r = 0; r < Rows; ++r) m(r, c) = uniform(-size, size);
    }
    return m;
  }
  /// Symmetric positive definite.
  template <int N>
  Mat<N, N> covariance(double size = 1.0) {
    const Mat<N, N> a = matrix<N, N>(size);
    Mat<N, N> P;  // element by element: Eigen's product of this size is slow to compile
    for (int c = 0; c < N; ++c) {
      for (int r = 0; r < N; ++r) {
        double sum = r == c ? 0.05 * size * size : 0.0;
        for (int k = 0; k < N; ++k) sum += a(r, k) * a(c, k);
        P(r, c) = sum;
      }
    }
    return P;
  }
  Mat3 attitude(double angle_rad) { return exp_so3(Vec3(angle_rad * matrix<3>().normalized())); }
  MotionState motion(AttitudeChartKind chart, double angle_rad) {
    MotionState m;
    m.position = matrix<3>(3.0);
    m.attitude = AttitudeState(chart, attitude(angle_rad));
    m.velocity = matrix<3>(0.5);
    m.rate = matrix<3>(0.4);
    return m;
  }
  /// Inverse-depth point a few metres before the anchor.
  Feature feature() {
    Feature f;
    f.y << matrix<3>(0.5), uniform(-2.0, 2.0), uniform(-0.9, 0.9), uniform(0.2, 0.6);
    return f;
  }
  Generator& generator() { return generator_; }

 private:
  Generator generator_;
};

inline constexpr AttitudeChartKind both_charts[] = {AttitudeChartKind::mrp, AttitudeChartKind::rodrigues};
/// Of rotations, rad. Beyond half a turn the charts stand in another set.
inline constexpr double attitude_angles[] = {0.0, 0.3, 1.5, 2.9, 3.1, 4.0, 6.0};

/// The states as one vector changes them: position, chart parameters (additive), velocity, rate.
inline MotionState moved(const MotionState& at, const Mat<12>& dx) {
  MotionState m = at;
  m.position += dx.segment<3>(0);
  m.attitude.add(Vec3(dx.segment<3>(3)));
  m.velocity += dx.segment<3>(6);
  m.rate += dx.segment<3>(9);
  return m;
}

inline Eigen::MatrixXd dense_covariance(const FilterState& state) {
  Eigen::MatrixXd P(state.size(), state.size());
  for (int c = 0; c < state.size(); ++c) {
    for (int r = 0; r < state.size(); ++r) P(r, c) = state.P_at(r, c);
  }
  return P;
}

inline Eigen::MatrixXd dense_rows(const SparseRowPair& row, int states) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, states);
  for (int r = 0; r < 2; ++r) {
    for (int k = 0; k < 12; ++k) H(r, k) = row.motion[r][k];
    for (int k = 0; k < row.feature_size; ++k) H(r, row.feature_offset + k) = row.feature[r][k];
  }
  return H;
}

/// Largest difference over the largest element (or 1); infinite when sizes differ or something is not finite.
inline double matrix_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols() || !a.allFinite() || !b.allFinite()) return HUGE_VAL;
  if (a.size() == 0) return 0.0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
}

}  // namespace relnav::test
