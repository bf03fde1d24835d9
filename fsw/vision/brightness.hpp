#pragma once
#include <cstdint>

#include "fsw/vision/image_view.hpp"

namespace relnav::vision {

/// Levels are of 255, whatever the depth of the image.
struct BrightnessSettings {
  std::int32_t sample_step_px = 4;        ///< every so many pixels of every so many rows are looked at, 1 to 16
  std::uint8_t dark_level = 24;           ///< up to here a pixel is space, and does not count
  std::uint16_t bright_permille = 900;    ///< of the pixels that count, so many are not brighter than `level`; 1 to 999
  std::uint16_t saturated_permille = 20;  ///< of them, so many may be over-exposed; 1000: all
  [[nodiscard]] bool is_valid() const {
    return sample_step_px >= 1 && sample_step_px <= 16 && dark_level < saturated_level && bright_permille >= 1 &&
           bright_permille <= 999 && saturated_permille <= 1000;
  }
};

/// How bright the lit part of an image is.
struct Brightness {
  std::uint32_t samples = 0;    ///< looked at
  std::uint32_t bright = 0;     ///< of these, over the dark level
  std::uint32_t saturated = 0;  ///< of these, over-exposed (saturated_level)
  std::uint8_t level = 0;       ///< see bright_permille; over-exposed pixels that may be are left out
  std::uint8_t peak_level = 0;  ///< all but saturated_permille of the bright ones are not brighter
};

/// By a histogram of 256 levels: integers only, (width / step) (height / step) pixels are read. `bits`: significant ones of a
/// pixel, 8 to 16. An image that is not valid has no samples.
[[nodiscard]] Brightness measure_brightness(const ImageView& image, int bits, const BrightnessSettings& settings);
[[nodiscard]] Brightness measure_brightness(const ImageView16& image, int bits, const BrightnessSettings& settings);

}  // namespace relnav::vision
