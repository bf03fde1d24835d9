#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "fsw/base/time.hpp"

namespace relnav::app {

/// The middles of the latest exposures, by the edges of a line that is high while the camera exposes: what the stamps of its
/// frames should be.
class ExposureLine {
 public:
  void reset() { *this = ExposureLine(); }
  void edge(bool rising, Time time) {
    if (!rising && is_high_) {
      middles_[count_ % kept] = Time{since_.ns + (time - since_).ns / 2};
      ++count_;
    }
    is_high_ = rising;
    since_ = time;
  }
  /// `stamp` minus the middle nearest to it; 0: none within a second.
  [[nodiscard]] std::int32_t offset_ns(Time stamp) const {
    constexpr std::int64_t furthest_ns = 1'000'000'000;
    std::int64_t nearest_ns = furthest_ns;
    for (std::size_t i = 0; i < kept && i < count_; ++i) {
      const std::int64_t offset_ns = (stamp - middles_[i]).ns;
      const std::int64_t distance_ns = offset_ns < 0 ? -offset_ns : offset_ns;
      if (distance_ns < (nearest_ns < 0 ? -nearest_ns : nearest_ns)) nearest_ns = offset_ns;
    }
    return nearest_ns == furthest_ns ? 0 : static_cast<std::int32_t>(nearest_ns);
  }

 private:
  static constexpr std::size_t kept = 8;
  std::array<Time, kept> middles_{};
  std::size_t count_ = 0;
  bool is_high_ = false;
  Time since_;
};

}  // namespace relnav::app
