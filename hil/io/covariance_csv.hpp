#pragma once
#include <string>
#include <vector>

#include "fsw/base/time.hpp"
#include "fsw/math/types.hpp"

namespace relnav::hil {

/// Covariance of the pose error [dt dphi] (m, rad; R_true = Exp([dphi x]) R_est) at an instant.
struct TimedCovariance {
  Time time;
  Mat6 P = Mat6::Zero();
};

/// `t_ns,c00,c01,...,c55`: header line, then the row-major upper triangle. Throws InputError on anything else.
[[nodiscard]] std::vector<TimedCovariance> read_covariances(const std::string& path);
[[nodiscard]] std::string covariance_header();
[[nodiscard]] std::string covariance_line(const TimedCovariance& covariance);

}  // namespace relnav::hil
