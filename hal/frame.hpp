#pragma once
#include <cstdint>

#include "fsw/base/time.hpp"

namespace relnav::hal {

enum class PixelFormat : std::uint8_t { mono8, mono16 };

/// Which clock a time stamp was read from.
enum class ClockId : std::uint8_t { monotonic, tai, device };

/// One image in the driver's memory, valid while its lease is held. Rows are top to bottom.
struct Frame {
  const std::uint8_t* pixels = nullptr;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t stride_bytes = 0;
  PixelFormat format = PixelFormat::mono8;
  Time mid_exposure;  ///< the stamp that navigation uses
  Time first_data;    ///< first byte seen by the receiver
  Time dequeued;      ///< handed to the application
  ClockId clock = ClockId::monotonic;
  std::uint32_t sequence = 0;
  Duration exposure;
  std::uint32_t lease = 0;  ///< names the lease towards Camera::release
};

}  // namespace relnav::hal
