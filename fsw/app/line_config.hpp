#pragma once
#include <cstdint>

#include "fsw/app/time_map.hpp"

namespace relnav::app {

/// What is wired to which line of hal::GpioLines; ignored where the platform has no lines.
struct LineConfig {
  static constexpr std::int32_t none = -1;

  std::int32_t heartbeat = none;  ///< output, changes its level once for each completed step
  std::int32_t pulse = none;      ///< input: rises with each second of TAI (PPS)
  std::int32_t exposure = none;   ///< input: high while the first camera exposes
  TimeMapConfig time;

  [[nodiscard]] bool is_valid() const {
    const auto may_be = [](std::int32_t line) { return line >= none; };
    const auto differ = [](std::int32_t a, std::int32_t b) { return a == none || a != b; };
    return may_be(heartbeat) && may_be(pulse) && may_be(exposure) && differ(heartbeat, pulse) &&
           differ(heartbeat, exposure) && differ(pulse, exposure) && TimeMap::is_valid(time);
  }
};

}  // namespace relnav::app
