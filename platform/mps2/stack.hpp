#pragma once
#include <cstdint>

namespace relnav::platform::mps2 {

/// What the stack is filled with at the start.
inline constexpr std::uint32_t stack_paint = 0xA5A5A5A5U;

/// Bytes of the stack ever used, and all there are.
[[nodiscard]] std::uint32_t stack_used();
[[nodiscard]] std::uint32_t stack_size();

}  // namespace relnav::platform::mps2
