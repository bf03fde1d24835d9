#include "platform/mps2/stack.hpp"

#include <algorithm>

extern "C" {
extern const std::uint32_t __stack_bottom[];
extern const std::uint32_t __stack_top[];
}

namespace relnav::platform::mps2 {

std::uint32_t stack_used() {
  const std::uint32_t* const touched =
      std::find_if(__stack_bottom, __stack_top, [](std::uint32_t word) { return word != stack_paint; });
  return static_cast<std::uint32_t>(__stack_top - touched) * sizeof(std::uint32_t);
}

std::uint32_t stack_size() { return static_cast<std::uint32_t>(__stack_top - __stack_bottom) * sizeof(std::uint32_t); }

}  // namespace relnav::platform::mps2
