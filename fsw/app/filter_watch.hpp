#pragma once
#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/estimation/noncoop_filter.hpp"
#include "fsw/estimation/relative_state.hpp"

namespace relnav::app {

struct FilterLimits {
  std::uint16_t max_refused_in_a_row = 5;    ///< updates without a usable result
  double max_test_ratio = 5.0;               ///< normalised innovation squared over its 99 % bound
  std::uint16_t max_test_ratio_frames = 20;  ///< frames in a row above it
};

/// What one frame's update was like.
struct UpdateSummary {
  Status status = Status::ok;
  double test_ratio = 0.0;
  bool starting = false;  ///< the start adjustment still corrects the state: its test ratio means nothing
};

/// Judges whether the filter is still to be believed. One judge() a frame.
class FilterWatch {
 public:
  void configure(const FilterLimits& limits) { limits_ = limits; }
  /// The filter starts anew.
  void restart();
  /// ok, or why the filter has failed: `inner` (what the navigator says of its own numbers), not_finite (output),
  /// not_positive_definite (covariance diagonal, or too many refused updates), no_convergence (test ratio far too high for
  /// too long).
  [[nodiscard]] Status judge(Status inner, const RelativeState& output, const UpdateSummary& update);

 private:
  FilterLimits limits_;
  std::uint16_t refused_in_a_row_ = 0;
  std::uint16_t high_ratio_in_a_row_ = 0;
};

/// not_finite; not_positive_definite: a variance below zero by more than rounding. A variance of exactly zero is a quantity
/// known by definition (the pose at the start).
[[nodiscard]] Status check_variances(const FilterState& state);
[[nodiscard]] Status check_output(const RelativeState& output);

}  // namespace relnav::app
