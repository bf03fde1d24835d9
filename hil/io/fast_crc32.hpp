#pragma once
#include <cstdint>
#include <span>

namespace relnav::hil {

/// The value of relnav::crc32(), many times as fast: a capture at full rate has no time for a byte at a time.
[[nodiscard]] std::uint32_t fast_crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

}  // namespace relnav::hil
