#include "hil/io/fast_crc32.hpp"

#include <zlib.h>

namespace relnav::hil {

std::uint32_t fast_crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  return static_cast<std::uint32_t>(::crc32_z(crc, bytes.data(), bytes.size()));
}

}  // namespace relnav::hil
