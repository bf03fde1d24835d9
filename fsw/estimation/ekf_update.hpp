#pragma once
#include <array>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/estimation/filter_state.hpp"
#include "fsw/math/covariance_kernels.hpp"

namespace relnav {

/// Two measured coordinates against their prediction.
struct Innovation {
  SparseRowPair H{};
  Vec2 nu_px = Vec2::Zero();  ///< measured - predicted
  double variance_px2 = 1.0;  ///< of each coordinate's measurement noise
};
using Innovations = BoundedVector<Innovation, config::max_features>;

struct UpdateResult {
  Status status = Status::ok;
  double nis = 0.0;  ///< normalised innovation squared nu' S^-1 nu
  int rows = 0;      ///< its degrees of freedom
};

/// EKF measurement update on the kernels of math/covariance_kernels.hpp, with its scratch memory.
class EkfUpdate {
 public:
  /// P H' of all innovations, kept for state_step() and apply().
  void prepare(FilterState& state, const Innovations& innovations);
  /// State step from innovation `index` alone: dx = P H_i' S_i^-1 nu_i (state_size entries). For one-point RANSAC.
  Status state_step(const FilterState& state, const Innovations& innovations, std::size_t index, double* dx) const;
  /// Updates state and covariance with all innovations. Refused (state unchanged) when S is not positive definite.
  UpdateResult apply(FilterState& state, const Innovations& innovations);

 private:
  static constexpr int max_n = static_cast<int>(config::max_states);
  static constexpr int max_m = static_cast<int>(config::max_measurement_rows);

  MatrixStorage<max_n, max_m> PHt_;
  MatrixStorage<max_m, max_m> S_;
  std::array<SparseRowPair, config::max_features> H_{};
  std::array<double, static_cast<std::size_t>(max_m)> r_{};
  std::array<double, static_cast<std::size_t>(max_m)> nu_{};
  std::array<double, static_cast<std::size_t>(max_n)> dx_{};
};

}  // namespace relnav
