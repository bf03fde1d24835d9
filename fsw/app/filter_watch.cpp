#include "fsw/app/filter_watch.hpp"

#include <cmath>

namespace relnav::app {
namespace {

/// Variances (m^2, rad^2, 1/m^2 ...) that are zero by definition may come out this far below it.
constexpr double rounding_variance = -1e-12;

Status check_variance(double variance) {
  if (!std::isfinite(variance)) return Status::not_finite;
  return variance < rounding_variance ? Status::not_positive_definite : Status::ok;
}

}  // namespace

void FilterWatch::restart() {
  refused_in_a_row_ = 0;
  high_ratio_in_a_row_ = 0;
}

Status check_variances(const FilterState& state) {
  for (int i = 0; i < state.size(); ++i) {
    const Status status = check_variance(state.P_at(i, i));
    if (status != Status::ok) return status;
  }
  return Status::ok;
}

Status check_output(const RelativeState& output) {
  const bool finite = output.t_CT.allFinite() && output.R_CT.allFinite() && output.v_C.allFinite() &&
                      output.omega_C.allFinite() && output.pose_covariance.allFinite() &&
                      output.rate_covariance.allFinite();
  if (!finite) return Status::not_finite;
  for (int i = 0; i < 6; ++i) {
    const Status pose = check_variance(output.pose_covariance(i, i));
    if (pose != Status::ok) return pose;
    const Status rate = check_variance(output.rate_covariance(i, i));
    if (rate != Status::ok) return rate;
  }
  return Status::ok;
}

Status FilterWatch::judge(Status inner, const RelativeState& output, const UpdateSummary& update) {
  const Status numbers = check_output(output);
  if (numbers != Status::ok) return numbers;
  if (inner != Status::ok) return inner;

  if (update.status == Status::ok) {
    refused_in_a_row_ = 0;
  } else if (++refused_in_a_row_ >= limits_.max_refused_in_a_row) {
    return Status::not_positive_definite;
  }
  const bool high = !update.starting && !(update.test_ratio <= limits_.max_test_ratio);
  if (!high) {
    high_ratio_in_a_row_ = 0;
  } else if (++high_ratio_in_a_row_ >= limits_.max_test_ratio_frames) {
    return Status::no_convergence;
  }
  return Status::ok;
}

}  // namespace relnav::app
