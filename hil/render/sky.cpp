#include "hil/render/sky.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fsw/base/generator.hpp"
#include "hil/render/hash.hpp"

namespace relnav::hil {
namespace {

constexpr float haze_height = 0.0013F;  // 8 km in Earth's radii: the air's scale height
constexpr std::uint32_t face_px = 256;

float lattice(std::int32_t x, std::int32_t y, std::int32_t z) {
  return unit_hash(hashed(static_cast<std::uint32_t>(x) * 73856093U ^ static_cast<std::uint32_t>(y) * 19349663U,
                          static_cast<std::uint32_t>(z) * 83492791U));
}
/// Value noise on a cubic lattice (Perlin, SIGGRAPH 1985, without gradients), 0 .. 1.
float noise_at(Vec3f p) {
  const auto floor_of = [](float x) { return static_cast<std::int32_t>(std::floor(x)); };
  const std::int32_t i = floor_of(p.x);
  const std::int32_t j = floor_of(p.y);
  const std::int32_t k = floor_of(p.z);
  const auto fade = [](float t) { return t * t * (3.0F - 2.0F * t); };
  const float x = fade(p.x - static_cast<float>(i));
  const float y = fade(p.y - static_cast<float>(j));
  const float z = fade(p.z - static_cast<float>(k));
  const auto along_x = [&](std::int32_t dj, std::int32_t dk) {
    const float a = lattice(i, j + dj, k + dk);
    return a + x * (lattice(i + 1, j + dj, k + dk) - a);
  };
  const float low = along_x(0, 0) + y * (along_x(1, 0) - along_x(0, 0));
  const float high = along_x(0, 1) + y * (along_x(1, 1) - along_x(0, 1));
  return low + z * (high - low);
}
float fractal_noise(Vec3f p, int octaves) {
  float sum = 0.0F;
  float weight = 0.5F;
  for (int i = 0; i < octaves; ++i) {
    sum += weight * noise_at(p);
    p = 2.03F * p;
    weight *= 0.5F;
  }
  return sum;
}

/// Reflectance relative to the mean: sea, land, and clouds over both.
float earth_albedo_at(Vec3f n) {
  const float land = std::clamp((fractal_noise(2.0F * n, 5) - 0.5F) * 12.0F, 0.0F, 1.0F);
  const Vec3f stretched{6.0F * n.x, 6.0F * n.y, 14.0F * n.z};  // weather runs along the parallels
  const float cloud = std::clamp((fractal_noise(stretched + Vec3f{9.0F, 5.0F, 1.0F}, 7) - 0.44F) * 5.0F, 0.0F, 1.0F);
  const float ground = 0.2F + 0.5F * land;
  return ground + cloud * (2.4F - ground);
}

/// The Earth as a cube map: a look-up without trigonometry.
class EarthMap {
 public:
  EarthMap() : albedo_(6 * face_px * face_px) {
    for (std::uint32_t face = 0; face < 6; ++face) {
      for (std::uint32_t j = 0; j < face_px; ++j) {
        for (std::uint32_t i = 0; i < face_px; ++i) {
          const float a = 2.0F * (static_cast<float>(i) + 0.5F) / face_px - 1.0F;
          const float b = 2.0F * (static_cast<float>(j) + 0.5F) / face_px - 1.0F;
          const float side = face % 2 == 0 ? 1.0F : -1.0F;
          const Vec3f p = face / 2 == 0 ? Vec3f{side, a, b} : face / 2 == 1 ? Vec3f{a, side, b} : Vec3f{a, b, side};
          albedo_[(face * face_px + j) * face_px + i] = earth_albedo_at(normalized(p));
        }
      }
    }
  }
  [[nodiscard]] float at(Vec3f n) const {
    const float x = std::fabs(n.x);
    const float y = std::fabs(n.y);
    const float z = std::fabs(n.z);
    if (x >= y && x >= z) return on_face(n.x > 0.0F ? 0 : 1, n.y / x, n.z / x);
    if (y >= z) return on_face(n.y > 0.0F ? 2 : 3, n.x / y, n.z / y);
    return on_face(n.z > 0.0F ? 4 : 5, n.x / z, n.y / z);
  }

 private:
  [[nodiscard]] float on_face(std::uint32_t face, float a, float b) const {
    constexpr float last = face_px - 1.001F;
    const float x = std::clamp((a + 1.0F) * (face_px / 2) - 0.5F, 0.0F, last);
    const float y = std::clamp((b + 1.0F) * (face_px / 2) - 0.5F, 0.0F, last);
    const auto i = static_cast<std::uint32_t>(x);
    const auto j = static_cast<std::uint32_t>(y);
    const float fx = x - static_cast<float>(i);
    const float fy = y - static_cast<float>(j);
    const float* row = albedo_.data() + (face * face_px + j) * face_px + i;
    const float low = row[0] + fx * (row[1] - row[0]);
    const float high = row[face_px] + fx * (row[face_px + 1] - row[face_px]);
    return low + fy * (high - low);
  }

  std::vector<float> albedo_;
};

const EarthMap& earth_map() {
  static const EarthMap map;
  return map;
}

}  // namespace

const std::vector<Star>& star_catalogue() {
  static const std::vector<Star> stars = [] {
    std::vector<Star> made;
    Generator generator(0x57A125ULL);
    for (int i = 0; i < 6000; ++i) {
      const double z = 2.0 * generator.uniform() - 1.0;
      const double angle = 2.0 * std::numbers::pi * generator.uniform();
      const double magnitude = 6.5 + 2.0 * std::log10(generator.uniform() + 1e-4);
      const double across = std::sqrt(1.0 - z * z);
      // The sun's magnitude is -26.74.
      made.push_back(
          {Vec3(across * std::cos(angle), across * std::sin(angle), z), std::pow(10.0, -0.4 * (magnitude + 26.74))});
    }
    std::stable_sort(made.begin(), made.end(),
                     [](const Star& a, const Star& b) { return a.irradiance > b.irradiance; });
    return made;
  }();
  return stars;
}

Sky::Sky(const SceneState& state, double earth_albedo, bool has_earth)
    : R_IC_(to_float(Mat3(state.R_CI.transpose()))),
      sun_C_(to_float(state.sun_C)),
      sun_I_(R_IC_ * sun_C_),
      earth_C_(normalized(to_float(state.earth_C))),
      distance_(static_cast<float>(std::max(1.001, state.earth_C.norm() / earth_radius))),
      albedo_(static_cast<float>(earth_albedo)),
      has_earth_(has_earth && state.earth_C.norm() > 0.0) {}

bool Sky::may_show(Vec3f axis_C, float half_angle_rad) const {
  const auto angle = [&](Vec3f a) { return std::acos(std::clamp(dot(a, axis_C), -1.0F, 1.0F)); };
  if (angle(sun_C_) < half_angle_rad + 1.1F * static_cast<float>(sun_radius_rad)) return true;
  const float limb = std::asin(std::min(1.0F, (1.0F + 10.0F * haze_height) / distance_));
  return has_earth_ && angle(earth_C_) < half_angle_rad + limb;
}

bool Sky::hides_stars(Vec3f toward_C) const {
  const float along = dot(toward_C, earth_C_);
  return has_earth_ && along > 0.0F && distance_ * distance_ * (1.0F - along * along) < 1.0F;
}

float Sky::radiance(Vec3f toward_C) const {
  float out = 0.0F;
  const float along = has_earth_ ? dot(toward_C, earth_C_) : -1.0F;
  const Vec3f off = toward_C - along * earth_C_;  // its length is the sine, without cancellation
  const float impact = distance_ * norm(off);
  if (along > 0.0F && impact < 1.0F + 10.0F * haze_height) {
    const float half_chord = std::sqrt(std::max(0.0F, 1.0F - impact * impact));
    const float t = distance_ * along - half_chord;
    const Vec3f n_I = R_IC_ * normalized(t * toward_C - distance_ * earth_C_);
    const float day = dot(n_I, sun_I_);
    if (impact < 1.0F) {
      // Haze over the ground: bluish white toward the limb, as the way through the air gets longer.
      const float haze = 0.25F * haze_height / std::max(half_chord, 0.03F) * 30.0F;
      const float share = std::min(haze, 0.8F);
      out = albedo_ * std::max(day, 0.0F) * ((1.0F - share) * earth_map().at(n_I) + share * 1.6F);
    } else {
      out = albedo_ * 1.3F * std::clamp(day + 0.1F, 0.0F, 1.0F) * std::exp(-(impact - 1.0F) / haze_height);
    }
    if (impact < 1.0F) return out;
  }
  const Vec3f from_sun = toward_C - sun_C_;
  constexpr auto radius = static_cast<float>(sun_radius_rad);
  // A white surface has 1 / pi of the sun's irradiance, which comes from pi radius^2.
  if (dot(from_sun, from_sun) < radius * radius) out += 1.0F / (radius * radius);
  return out;
}

double mean_earth_radiance(const SceneState& state, double earth_albedo) {
  const double distance = std::max(1.001, state.earth_C.norm() / earth_radius);
  const Vec3 up = -state.earth_C.normalized();
  if (!up.allFinite()) return 0.0;
  Vec3f s;
  Vec3f t;
  base_around(to_float(up), s, t);
  double sum = 0.0;
  double weights = 0.0;
  // Over the cap that is in view, each point as the viewer sees it: rings of equal area.
  constexpr int rings = 6;
  constexpr int spokes = 12;
  for (int i = 0; i < rings; ++i) {
    const double cosine = 1.0 - (1.0 - 1.0 / distance) * (i + 0.5) / rings;
    const double sine = std::sqrt(1.0 - cosine * cosine);
    const double seen = cosine * distance - 1.0;  // cosine at the point, times its distance
    const double weight = seen / std::pow(distance * distance + 1.0 - 2.0 * distance * cosine, 1.5);
    for (int k = 0; k < spokes; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / spokes;
      const Vec3 n = cosine * up + sine * (std::cos(angle) * to_double(s) + std::sin(angle) * to_double(t));
      sum += weight * std::max(0.0, n.dot(state.sun_C));
      weights += weight;
    }
  }
  return earth_albedo * sum / weights;
}

}  // namespace relnav::hil
