#pragma once
#include <cstdint>
#include <variant>

#include "fsw/vision/image_view.hpp"
#include "hal/frame.hpp"

namespace relnav::app {

/// What one camera contributes to a step: an image of 8 or 16 bits, or none (std::monostate).
using CameraImage = std::variant<std::monostate, vision::ImageView, vision::ImageView16>;

/// The frame's pixels as they are; FrameChecks has seen to it that rows and alignment fit.
[[nodiscard]] inline CameraImage image_of(const hal::Frame& frame) {
  const auto width = static_cast<int>(frame.width_px);
  const auto height = static_cast<int>(frame.height_px);
  const auto stride = static_cast<int>(frame.stride_bytes);
  if (frame.format == hal::PixelFormat::mono16) {
    const void* const pixels = frame.pixels;
    return vision::ImageView16{static_cast<const std::uint16_t*>(pixels), width, height, stride / 2};
  }
  return vision::ImageView{frame.pixels, width, height, stride};
}

}  // namespace relnav::app
