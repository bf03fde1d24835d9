#pragma once
#include <compare>
#include <cstdint>

namespace relnav {

/// Length of time in integer nanoseconds.
struct Duration {
  std::int64_t ns = 0;
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }
  friend constexpr auto operator<=>(Duration, Duration) = default;
};

/// Instant on a monotonic, TAI-like time scale, in integer nanoseconds. Never a float.
struct Time {
  std::int64_t ns = 0;
  friend constexpr auto operator<=>(Time, Time) = default;
  friend constexpr Duration operator-(Time a, Time b) { return {a.ns - b.ns}; }
  friend constexpr Time operator+(Time t, Duration d) { return {t.ns + d.ns}; }
};

}  // namespace relnav
