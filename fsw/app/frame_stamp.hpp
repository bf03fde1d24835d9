#pragma once
#include <cstdint>

#include "fsw/base/time.hpp"

namespace relnav::app {

/// Which frame packets are about.
struct FrameStamp {
  Time time;
  std::uint32_t sequence = 0;
};

}  // namespace relnav::app
