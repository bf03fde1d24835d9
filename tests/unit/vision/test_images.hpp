#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fsw/base/generator.hpp"
#include "fsw/math/types.hpp"
#include "fsw/vision/image_view.hpp"

namespace relnav::vision::test {

/// Pixels with an owner; `slack` bytes of another level follow each row.
class OwnedImage {
 public:
  OwnedImage(int width, int height, int slack = 0, std::uint8_t level = 0)
      : width_(width),
        height_(height),
        stride_(width + slack),
        pixels_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height), level) {}

  [[nodiscard]] std::uint8_t& at(int u, int v) {
    return pixels_[static_cast<std::size_t>(v) * static_cast<std::size_t>(stride_) + static_cast<std::size_t>(u)];
  }
  [[nodiscard]] ImageView view() const { return {pixels_.data(), width_, height_, stride_}; }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::uint8_t* data() { return pixels_.data(); }

  /// Level of every pixel (slack too) from a function of (u, v), rounded and clipped.
  template <typename Function>
  void fill(Function&& level) {
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < stride_; ++u) {
        const double value = std::clamp(level(static_cast<double>(u), static_cast<double>(v)), 0.0, 255.0);
        at(u, v) = static_cast<std::uint8_t>(std::lround(value));
      }
    }
  }

 private:
  int width_;
  int height_;
  int stride_;
  std::vector<std::uint8_t> pixels_;
};

/// Facets of random level and size on black, with noise: corners and edges of every contrast, over-exposed areas too.
inline OwnedImage facets(int width, int height, std::uint64_t seed, int slack = 0) {
  OwnedImage image(width, height, slack);
  Generator generator(seed);
  const int count = 20 + width * height / 400;
  for (int i = 0; i < count; ++i) {
    const int u0 = static_cast<int>(generator.below(static_cast<std::uint32_t>(width)));
    const int v0 = static_cast<int>(generator.below(static_cast<std::uint32_t>(height)));
    const int u1 = std::min(width, u0 + 2 + static_cast<int>(generator.below(24)));
    const int v1 = std::min(height, v0 + 2 + static_cast<int>(generator.below(24)));
    const int level = std::min(255, static_cast<int>(generator.below(330)));
    const int slope = static_cast<int>(generator.below(7)) - 3;
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) {
        image.at(u, v) = static_cast<std::uint8_t>(std::clamp(level + slope * (u - u0), 0, 255));
      }
    }
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width + slack; ++u) {
      const int noisy = image.at(u, v) + static_cast<int>(generator.below(9)) - 4;
      image.at(u, v) = static_cast<std::uint8_t>(std::clamp(noisy, 0, 255));
    }
  }
  return image;
}

/// Sum of plane waves with at most 0.18 cycles a pixel: can be shifted and warped exactly. Mean 110, standard deviation 40.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) {
    Generator generator(seed);
    for (Wave& wave : waves_) {
      const double frequency = 2.0 * std::numbers::pi * (0.03 + 0.15 * generator.uniform());
      const double direction = 2.0 * std::numbers::pi * generator.uniform();
      wave = {frequency * std::cos(direction), frequency * std::sin(direction),
              2.0 * std::numbers::pi * generator.uniform()};
    }
  }
  [[nodiscard]] double operator()(double u, double v) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::cos(wave.ku * u + wave.kv * v + wave.phase);
    return 110.0 + 40.0 * sum * std::sqrt(2.0 / static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    double ku, kv, phase;
  };
  std::array<Wave, 24> waves_{};
};

/// Approximately normal, mean 0, standard deviation 1 (sum of 12 uniform numbers).
inline double normal(Generator& generator) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += generator.uniform();
  return sum;
}

}  // namespace relnav::vision::test
