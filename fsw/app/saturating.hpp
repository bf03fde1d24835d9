#pragma once
#include <limits>

namespace relnav::app {

/// Counts stay at their largest value.
template <typename Count>
constexpr void increment(Count& count) {
  if (count < std::numeric_limits<Count>::max()) ++count;
}

/// a + b, at most the largest value.
template <typename Count>
[[nodiscard]] constexpr Count saturated_sum(Count a, Count b) {
  const Count room = static_cast<Count>(std::numeric_limits<Count>::max() - a);
  return b < room ? static_cast<Count>(a + b) : std::numeric_limits<Count>::max();
}

}  // namespace relnav::app
