#pragma once
#include <cstdint>
#include <string>

namespace relnav::hil {

/// What a surface's texture coordinates look up (texture.hpp).
enum class Pattern : std::uint8_t {
  plain,
  foil,         ///< crinkled: facets that are tilted at random
  solar_cells,  ///< dark cells with grid lines and gaps
  panel,        ///< painted metal: scratches, seams, rivets
  labels,       ///< printed plates
  image,        ///< of the user's mesh: Material::image
};

/// Grey, linear. A metal reflects `base` at right angles; anything else is matt in `base` under a clear surface of 4 %.
struct Material {
  std::string name;
  float base = 0.5F;       ///< reflectance, 0 .. 1
  float metallic = 0.0F;   ///< 0 .. 1
  float roughness = 0.5F;  ///< 0 .. 1; the GGX width is its square (Burley, Physically-based shading at Disney, 2012)
  float emission = 0.0F;   ///< radiance, in units of that of a white, matt surface that faces the sun
  Pattern pattern = Pattern::plain;
  std::string image;  ///< path of a PNG file
};

}  // namespace relnav::hil
