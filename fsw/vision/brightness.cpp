#include "fsw/vision/brightness.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace relnav::vision {
namespace {

constexpr std::size_t levels = 256;
using Histogram = std::array<std::uint32_t, levels>;

/// Lowest level over `dark` that leaves at most `above` pixels of higher ones.
std::uint8_t level_below(const Histogram& histogram, std::size_t top, std::size_t dark, std::uint64_t above) {
  std::uint64_t seen = 0;
  for (std::size_t level = top; level > dark; --level) {
    seen += histogram[level];
    if (seen > above) return static_cast<std::uint8_t>(level);
  }
  return 0;
}

template <typename Pixel>
Brightness measure(const GreyImageView<Pixel>& image, int bits, const BrightnessSettings& settings) {
  Brightness out;
  if (!image.is_valid()) return out;
  Histogram histogram{};
  const int shift = std::clamp(bits, 8, 16) - 8;
  const int step = settings.sample_step_px;
  for (int v = step / 2; v < image.height; v += step) {
    const Pixel* const row = image.at(0, v);
    for (int u = step / 2; u < image.width; u += step) {
      const auto level = static_cast<std::size_t>(row[u]) >> static_cast<unsigned>(shift);
      ++histogram[std::min(level, levels - 1)];
      ++out.samples;
    }
  }
  const std::size_t dark = settings.dark_level;
  for (std::size_t level = dark + 1; level < levels; ++level) {
    out.bright += histogram[level];
    if (level >= saturated_level) out.saturated += histogram[level];
  }
  if (out.bright == 0) return out;
  const std::uint64_t allowed = std::uint64_t{out.bright} * settings.saturated_permille / 1000U;
  out.peak_level = level_below(histogram, levels - 1, dark, allowed);
  // The over-exposed that may be say nothing about the rest.
  const std::uint64_t left_out = std::min<std::uint64_t>(out.saturated, allowed);
  const std::uint64_t counted = out.bright - left_out;
  out.level = level_below(histogram, levels - 1, dark, left_out + counted * (1000U - settings.bright_permille) / 1000U);
  return out;
}

}  // namespace

Brightness measure_brightness(const ImageView& image, int bits, const BrightnessSettings& settings) {
  return measure(image, bits, settings);
}

Brightness measure_brightness(const ImageView16& image, int bits, const BrightnessSettings& settings) {
  return measure(image, bits, settings);
}

}  // namespace relnav::vision
