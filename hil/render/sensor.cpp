#include "hil/render/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "hil/render/any_width.hpp"
#include "hil/render/hash.hpp"

namespace relnav::hil {
namespace {

struct Conversion {
  float electrons;  // a unit of radiance
  float exposure_s;
  float full_well_e;
  float read_variance;
  float per_electron;  // levels
  float dark_level;
  float highest;
  float noise;
  std::uint32_t key;
};

/// Levels of a row, not yet in their place. Plain loops over arrays, for the compiler to make vectors of.
RELNAV_ANY_WIDTH void convert(const float* radiance, const float* response, const float* dark_e_s, std::uint32_t first,
                              std::size_t n, const Conversion& to, std::int32_t* levels) {
  const Conversion c = to;
  for (std::size_t i = 0; i < n; ++i) {
    const float mean = response[i] * (radiance[i] * c.electrons + dark_e_s[i] * c.exposure_s);
    // lowbias32 twice (hash.hpp), written out.
    std::uint32_t x = (first + static_cast<std::uint32_t>(i)) ^ c.key;
    x ^= x >> 16U;
    x *= 0x7feb352dU;
    x ^= x >> 15U;
    x *= 0x846ca68bU;
    x ^= x >> 16U;
    std::uint32_t y = x + 0x9e3779b9U;
    y ^= y >> 16U;
    y *= 0x7feb352dU;
    y ^= y >> 15U;
    y *= 0x846ca68bU;
    y ^= y >> 16U;
    std::uint32_t sum = (x & 0x00FF00FFU) + ((x >> 8U) & 0x00FF00FFU) + (y & 0x00FF00FFU) + ((y >> 8U) & 0x00FF00FFU);
    sum = (sum & 0xFFFFU) + (sum >> 16U);
    // Eight bytes: mean 1020, variance 8 (256^2 - 1) / 12.
    const float normal = (static_cast<float>(static_cast<std::int32_t>(sum)) - 1020.0F) * 0.00478416F;
    float e = mean + c.noise * normal * std::sqrt(mean + c.read_variance);
    e = e < c.full_well_e ? e : c.full_well_e;
    float level = e * c.per_electron + c.dark_level + 0.5F;
    level = level > 0.0F ? level : 0.0F;
    level = level < c.highest ? level : c.highest;
    levels[i] = static_cast<std::int32_t>(level);
  }
}

}  // namespace

Sensor::Sensor(const SensorSettings& settings, std::uint32_t width, std::uint32_t height, std::uint64_t seed)
    : settings_(settings), seed_(folded(seed)) {
  const std::uint32_t pixels = width * height;
  response_.resize(pixels);
  dark_e_s_.assign(pixels, static_cast<float>(settings.dark_current_e_s));
  const auto spread = static_cast<float>(settings.response_sd) * 1.7320508F;
  for (std::uint32_t i = 0; i < pixels; ++i) {
    float sum = -2.0F;
    for (std::uint32_t k = 0; k < 4; ++k) sum += unit_hash(i ^ seed_, 0xD00U + k);
    response_[i] = std::max(0.0F, 1.0F + spread * sum);
  }
  const auto drawn = [&](std::uint32_t i, std::uint32_t salt) { return hashed(hashed(i, salt), seed_) % pixels; };
  for (std::uint32_t i = 0; i < settings.hot_pixels; ++i) {
    const float fills_in_s = 0.02F * std::pow(50.0F, unit_hash(i ^ seed_, 0x407U));
    dark_e_s_[drawn(i, 0x408U)] += static_cast<float>(settings.full_well_e) / fills_in_s;
  }
  for (std::uint32_t i = 0; i < settings.dead_pixels; ++i) response_[drawn(i, 0xDEADU)] = 0.0F;
}

void Sensor::expose(const Plane& radiance, double exposure_s, double gain, std::uint32_t frame, WorkerPool& pool,
                    Image& out) const {
  const auto highest = static_cast<double>((1U << settings_.bits) - 1U);
  Conversion c{};
  c.electrons = static_cast<float>(settings_.electrons_per_s * exposure_s);
  c.exposure_s = static_cast<float>(exposure_s);
  c.full_well_e = static_cast<float>(settings_.full_well_e);
  c.read_variance = static_cast<float>(settings_.read_noise_e * settings_.read_noise_e);
  c.per_electron = static_cast<float>(gain * highest / settings_.full_well_e);
  c.dark_level = static_cast<float>(settings_.dark_level * highest);
  c.highest = static_cast<float>(highest) + 0.4F;
  c.noise = settings_.noise ? 1.0F : 0.0F;
  c.key = hashed(frame, seed_);
  out.width_px = radiance.width;
  out.height_px = radiance.height;
  out.bytes_per_pixel = settings_.bits > 8 ? 2 : 1;
  out.bytes.resize(static_cast<std::size_t>(radiance.width) * radiance.height * out.bytes_per_pixel);
  constexpr std::uint32_t band = 16;
  pool.run((radiance.height + band - 1) / band, [&](std::size_t which) {
    std::vector<std::int32_t> levels(radiance.width);
    const auto first = static_cast<std::uint32_t>(which) * band;
    for (std::uint32_t v = first; v < std::min(first + band, radiance.height); ++v) {
      const std::size_t at = static_cast<std::size_t>(v) * radiance.width;
      convert(radiance.row(v), response_.data() + at, dark_e_s_.data() + at, static_cast<std::uint32_t>(at),
              radiance.width, c, levels.data());
      if (out.bytes_per_pixel == 1) {
        std::uint8_t* to = out.bytes.data() + at;
        for (std::uint32_t u = 0; u < radiance.width; ++u) to[u] = static_cast<std::uint8_t>(levels[u]);
      } else {
        std::uint8_t* to = out.bytes.data() + 2 * at;
        for (std::uint32_t u = 0; u < radiance.width; ++u) {
          const auto value = static_cast<std::uint16_t>(levels[u] << (16U - settings_.bits));
          std::memcpy(to + 2 * u, &value, 2);
        }
      }
    }
  });
}

}  // namespace relnav::hil
