#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/app/flight_config.hpp"

namespace relnav::app {

/// A FlightLoopConfig as bytes, for a target without files: cameras, target, motion and every value that hil's configuration file
/// can set; what it cannot set keeps its default. Big-endian: magic, version, size of the body, body, CRC-32 over all before.
inline constexpr std::size_t max_config_image_bytes = 8192;

/// `size`: of the image. no_capacity.
Status write_config_image(const FlightLoopConfig& config, std::span<std::uint8_t> image, std::size_t& size);

/// unsupported: no image, or another version; incomplete: another size than it says; crc_mismatch; invalid_argument: a number
/// that does not fit its place. `config` changes only on ok.
Status read_config_image(std::span<const std::uint8_t> image, FlightLoopConfig& config);

}  // namespace relnav::app
