#include "fsw/estimation/ekf_update.hpp"

#include <cmath>

namespace relnav {

void EkfUpdate::prepare(FilterState& state, const Innovations& innovations) {
  for (std::size_t i = 0; i < innovations.size(); ++i) H_[i] = innovations[i].H;
  MatrixView PHt = PHt_.view(state.size(), 2 * static_cast<int>(innovations.size()));
  multiply_p_ht(state.P(), {H_.data(), innovations.size()}, PHt);
}

Status EkfUpdate::state_step(const FilterState& state, const Innovations& innovations, std::size_t index,
                             double* dx) const {
  const SparseRowPair& H = innovations[index].H;
  const int col = 2 * static_cast<int>(index);
  const ConstMatrixView PHt = PHt_.view(state.size(), 2 * static_cast<int>(innovations.size()));
  Mat2 S;
  for (int a = 0; a < 2; ++a) {
    for (int b = 0; b < 2; ++b) {
      double sum = 0.0;
      for (int k = 0; k < FilterState::motion_size; ++k) sum += H.motion[a][k] * PHt(k, col + b);
      for (int k = 0; k < H.feature_size; ++k) sum += H.feature[a][k] * PHt(H.feature_offset + k, col + b);
      S(a, b) = sum;
    }
    S(a, a) += innovations[index].variance_px2;
  }
  const double det = S(0, 0) * S(1, 1) - S(0, 1) * S(1, 0);
  if (!(det > 0.0) || !(S(0, 0) > 0.0)) return Status::not_positive_definite;
  const Vec2& nu = innovations[index].nu_px;
  const double w0 = (S(1, 1) * nu(0) - S(0, 1) * nu(1)) / det;
  const double w1 = (S(0, 0) * nu(1) - S(1, 0) * nu(0)) / det;
  for (int k = 0; k < state.size(); ++k) dx[k] = PHt(k, col) * w0 + PHt(k, col + 1) * w1;
  return Status::ok;
}

UpdateResult EkfUpdate::apply(FilterState& state, const Innovations& innovations) {
  UpdateResult result;
  const int n = state.size();
  const int m = 2 * static_cast<int>(innovations.size());
  result.rows = m;
  if (m == 0) return result;

  prepare(state, innovations);
  for (std::size_t i = 0; i < innovations.size(); ++i) {
    r_[2 * i] = r_[2 * i + 1] = innovations[i].variance_px2;
    nu_[2 * i] = innovations[i].nu_px(0);
    nu_[2 * i + 1] = innovations[i].nu_px(1);
  }
  MatrixView PHt = PHt_.view(n, m);
  MatrixView S = S_.view(m, m);
  innovation_covariance({H_.data(), innovations.size()}, PHt, {r_.data(), static_cast<std::size_t>(m)}, S);
  result.status = cholesky_lower(S);
  if (result.status != Status::ok) return result;

  solve_lower(S, {nu_.data(), static_cast<std::size_t>(m)});
  for (int i = 0; i < m; ++i) result.nis += nu_[static_cast<std::size_t>(i)] * nu_[static_cast<std::size_t>(i)];
  if (!std::isfinite(result.nis)) {
    result.status = Status::not_finite;
    return result;
  }
  solve_right_transposed(S, PHt);
  state_increment(PHt, {nu_.data(), static_cast<std::size_t>(m)}, {dx_.data(), static_cast<std::size_t>(n)});
  state.correct(dx_.data());
  downdate_symmetric(state.P(), PHt);
  return result;
}

}  // namespace relnav
