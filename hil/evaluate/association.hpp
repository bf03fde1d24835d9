#pragma once
#include <cstddef>
#include <vector>

#include "hil/io/trajectory.hpp"

namespace relnav::hil {

/// Which poses of two trajectories belong to the same instant.
struct Association {
  struct Pair {
    std::size_t truth;
    std::size_t estimate;
  };
  std::vector<Pair> pairs;           ///< in order of time; each pose is used once
  std::vector<std::size_t> missing;  ///< truth poses without an estimate
  std::size_t estimates_without_truth = 0;
  Duration tolerance;
};

/// Nearest stamps within half the shorter median period of the two, and at most 5 ms.
[[nodiscard]] Association associate(const Trajectory& truth, const Trajectory& estimate);

/// Median of the time steps; zero with fewer than two poses.
[[nodiscard]] Duration median_period(const Trajectory& trajectory);

}  // namespace relnav::hil
