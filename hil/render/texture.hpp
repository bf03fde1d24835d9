#pragma once
#include <cstdint>
#include <vector>

#include "hil/render/material.hpp"

namespace relnav::hil {

/// What a texture says of a point; a vector for the processor.
struct Texel {
  using Values [[gnu::vector_size(16)]] = float;
  Values values{1.0F, 0.0F, 0.0F, 0.0F};

  [[nodiscard]] float base() const { return values[0]; }    ///< factor of the material's
  [[nodiscard]] float tilt_u() const { return values[1]; }  ///< slopes of the normal: n ~ (tilt_u, tilt_v, 1)
  [[nodiscard]] float tilt_v() const { return values[2]; }
  /// Spread of the slopes within the texel, added to the square of the GGX width.
  [[nodiscard]] float alpha2() const { return values[3]; }
};

/// A square that repeats, with coarser and coarser levels of it. Slopes that a coarser level averages away come back as
/// roughness (Toksvig, JGT 10(3), 2005; Olano, Baker, LEAN mapping, I3D 2010), so that foil glitters the same at any distance.
class Texture {
 public:
  /// `side_px`: a power of 2; `texels`: rows; `side`: its length in texture coordinates.
  Texture(std::uint32_t side_px, std::vector<Texel> texels, float side);

  /// `footprint`: of a pixel, in texture coordinates.
  [[nodiscard]] Texel at(float u, float v, float footprint) const;

 private:
  [[nodiscard]] Texel bilinear(std::size_t level, float u, float v) const;

  std::uint32_t side_px_;
  float per_unit_;                                      // levels' finest texels a unit of the coordinates
  using Packed [[gnu::vector_size(8)]] = std::int16_t;  // in 1/2048: half the memory is most of the time
  std::vector<std::vector<Packed>> levels_;  // in blocks of 4 x 4 texels, so that neighbours share a cache line
};

/// Made in code, the same for every seed. Not for `plain` and `image`.
[[nodiscard]] Texture make_texture(Pattern pattern);
/// The base from a PNG file. Throws InputError.
[[nodiscard]] Texture load_texture(const std::string& path);

}  // namespace relnav::hil
