#include "hil/render/texture.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "hil/io/image.hpp"
#include "hil/render/hash.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

constexpr float unit = 2048.0F;  // of packed texels

using Whole [[gnu::vector_size(16)]] = std::int32_t;

/// Of column i, row j in a level of `px` texels across.
inline std::uint32_t place(std::uint32_t px, std::uint32_t i, std::uint32_t j) {
  if (px < 4) return j * px + i;
  return ((j >> 2U) * (px >> 2U) + (i >> 2U)) * 16U + (j & 3U) * 4U + (i & 3U);
}

Texel blend(const Texel& a, const Texel& b, float t) { return {a.values + t * (b.values - a.values)}; }

/// Four texels as one: slopes are averaged, and what they scatter is added to alpha^2 (both axes together: alpha^2 is twice
/// the variance along one).
Texel mean_of(const Texel& a, const Texel& b, const Texel& c, const Texel& d) {
  Texel m = blend(blend(a, b, 0.5F), blend(c, d, 0.5F), 0.5F);
  float square = 0.0F;
  for (const Texel* t : {&a, &b, &c, &d}) square += 0.25F * (t->tilt_u() * t->tilt_u() + t->tilt_v() * t->tilt_v());
  m.values[3] += std::max(0.0F, square - m.tilt_u() * m.tilt_u() - m.tilt_v() * m.tilt_v());
  return m;
}

float gaussian_like(std::uint32_t x) {  // four uniforms: sd 1
  float sum = -2.0F;
  for (std::uint32_t i = 0; i < 4; ++i) sum += unit_hash(x, 0x51U + i);
  return 1.7320508F * sum;
}

/// The nearest of a jittered grid's points that repeats every `cells` (Worley, SIGGRAPH 1996), and how far the second nearest
/// is behind, in cells: 0 on a ridge.
struct Facet {
  std::uint32_t id;
  float from_ridge;
};
Facet facet_at(float x, float y, std::int32_t cells, std::uint32_t salt) {
  const auto i0 = static_cast<std::int32_t>(std::floor(x));
  const auto j0 = static_cast<std::int32_t>(std::floor(y));
  float best = 1e9F;
  float second = 1e9F;
  std::uint32_t id = 0;
  for (std::int32_t j = j0 - 1; j <= j0 + 1; ++j) {
    for (std::int32_t i = i0 - 1; i <= i0 + 1; ++i) {
      const auto i_wrapped = static_cast<std::uint32_t>((i + cells) % cells);
      const auto j_wrapped = static_cast<std::uint32_t>((j + cells) % cells);
      const std::uint32_t cell = hashed(i_wrapped * 8191U + j_wrapped, salt);
      const float dx = static_cast<float>(i) + unit_hash(cell, 1U) - x;
      const float dy = static_cast<float>(j) + unit_hash(cell, 2U) - y;
      const float d = std::sqrt(dx * dx + dy * dy);
      if (d < best) {
        second = best;
        best = d;
        id = cell;
      } else {
        second = std::min(second, d);
      }
    }
  }
  return {id, second - best};
}

float ramp(float low, float high, float x) { return std::clamp((x - low) / (high - low), 0.0F, 1.0F); }
/// Within `half` of a multiple of `period`.
bool on_line(float x, float period, float half) { return std::fabs(x - period * std::round(x / period)) < half; }

template <typename Of>
Texture painted(std::uint32_t side_px, float side, Of&& of) {
  std::vector<Texel> texels(static_cast<std::size_t>(side_px) * side_px);
  const float step = side / static_cast<float>(side_px);
  for (std::uint32_t j = 0; j < side_px; ++j) {
    for (std::uint32_t i = 0; i < side_px; ++i) {
      texels[static_cast<std::size_t>(j) * side_px + i] =
          of((static_cast<float>(i) + 0.5F) * step, (static_cast<float>(j) + 0.5F) * step);
    }
  }
  return Texture(side_px, std::move(texels), side);
}

/// Large facets with small ones on them, tilted by 14 and 6 deg, and creases between.
Texel foil_texel(float u, float v) {
  const Facet large = facet_at(u / 0.05F, v / 0.05F, 24, 0xF01U);
  const Facet small = facet_at(u / 0.0171428F, v / 0.0171428F, 70, 0xF02U);
  Texel t;
  t.values[1] = 0.24F * gaussian_like(hashed(large.id, 3U)) + 0.11F * gaussian_like(hashed(small.id, 3U));
  t.values[2] = 0.24F * gaussian_like(hashed(large.id, 4U)) + 0.11F * gaussian_like(hashed(small.id, 4U));
  t.values[0] = 0.55F + 0.35F * unit_hash(large.id, 5U) + 0.10F * unit_hash(small.id, 5U);
  t.values[0] *= 0.6F + 0.4F * ramp(0.0F, 0.12F, large.from_ridge);
  // Every half metre a seam of tape.
  if (on_line(u, 0.6F, 0.012F) || on_line(v, 0.6F, 0.012F)) {
    t.values[0] = 0.8F;
    t.values[1] *= 0.3F;
    t.values[2] *= 0.3F;
  }
  return t;
}

/// Cells of 80 mm x 40 mm under glass, bus bars along them, each cell laid a little differently.
Texel cell_texel(float u, float v) {
  Texel t;
  const std::uint32_t cell = hashed(static_cast<std::uint32_t>(u / 0.08F), 77U + static_cast<std::uint32_t>(v / 0.04F));
  t.values[0] = 0.8F + 0.4F * unit_hash(cell, 1U);
  t.values[1] = 0.004F * gaussian_like(hashed(cell, 2U));
  t.values[2] = 0.004F * gaussian_like(hashed(cell, 3U));
  const float in_cell_u = u - 0.08F * std::floor(u / 0.08F);
  const bool is_gap = on_line(u, 0.08F, 0.0016F) || on_line(v, 0.04F, 0.0016F);
  const bool is_bar = std::fabs(in_cell_u - 0.02F) < 0.0009F || std::fabs(in_cell_u - 0.06F) < 0.0009F;
  if (is_gap) t.values[0] = 9.0F;  // the white substrate shows
  if (is_bar) t.values[0] = 14.0F;
  // Every 24 cm the strings end.
  if (on_line(v, 0.24F, 0.004F)) t.values[0] = 12.0F;
  if (on_line(u, 0.48F, 0.006F)) t.values[0] = 2.0F;
  return t;
}

/// Seams every 30 cm with rivets beside them, stains, scratches.
Texel panel_texel(float u, float v) {
  Texel t;
  const Facet stain = facet_at(u / 0.0375F, v / 0.0375F, 16, 0xBA1U);
  const Facet speck = facet_at(u / 0.01875F, v / 0.01875F, 32, 0xBA2U);
  t.values[0] = 0.90F + 0.10F * unit_hash(stain.id, 5U);
  if ((speck.id & 15U) == 0U && speck.from_ridge > 0.45F) t.values[0] *= 0.35F;
  const bool is_seam = on_line(u, 0.3F, 0.0025F) || on_line(v, 0.3F, 0.0025F);
  const float ru = u - 0.05F * std::round(u / 0.05F);
  const float rv = v - 0.05F * std::round(v / 0.05F);
  const bool is_rivet_row =
      std::fabs(std::fabs(u - 0.3F * std::round(u / 0.3F)) - 0.0F) < 0.004F + 0.021F && !on_line(u, 0.3F, 0.012F);
  const bool is_rivet = is_rivet_row && std::hypot(std::fabs(ru) - 0.02F, rv) < 0.006F;
  if (is_seam) t.values[0] *= 0.25F;
  if (is_rivet) t.values[0] *= 0.45F;
  return t;
}

/// Plates of 15 cm with a frame and rows of made-up letters (5 x 7 dots of 2.5 mm).
Texel label_texel(float u, float v) {
  Texel t;
  const float x = u - 0.15F * std::floor(u / 0.15F);
  const float y = v - 0.15F * std::floor(v / 0.15F);
  const std::uint32_t plate = hashed(static_cast<std::uint32_t>(u / 0.15F), 9U + static_cast<std::uint32_t>(v / 0.15F));
  const float margin = std::min(std::min(x, 0.15F - x), std::min(y, 0.15F - y));
  if (margin > 0.006F && margin < 0.010F) t.values[0] = 0.08F;
  if (margin > 0.018F) {
    const bool is_title = y < 0.07F;
    const float dot = is_title ? 0.006F : 0.0025F;
    const float top = is_title ? 0.020F : 0.075F;
    const auto i = static_cast<std::uint32_t>((x - 0.018F) / dot);
    const auto j = static_cast<std::uint32_t>(std::max(y - top, 0.0F) / dot);
    const std::uint32_t letter = hashed(plate, (i / 6U) * 64U + j / 9U + (is_title ? 7U : 0U));
    const bool is_ink = i % 6U < 5U && j % 9U < 7U && (hashed(letter, (i % 6U) * 8U + j % 9U) & 1U) != 0U;
    if (is_ink && y > top) t.values[0] = 0.06F;
  }
  return t;
}

}  // namespace

Texture::Texture(std::uint32_t side_px, std::vector<Texel> texels, float side)
    : side_px_(side_px), per_unit_(static_cast<float>(side_px) / side) {
  for (std::uint32_t px = side_px; px >= 1; px /= 2) {
    std::vector<Packed> packed(texels.size());
    for (std::uint32_t j = 0; j < px; ++j) {
      for (std::uint32_t i = 0; i < px; ++i) {
        const auto rounded = [&](int k) {
          const float value = std::clamp(texels[j * px + i].values[k], -15.9F, 15.9F) * unit;
          return static_cast<std::int16_t>(std::lround(value));
        };
        packed[place(px, i, j)] = Packed{rounded(0), rounded(1), rounded(2), rounded(3)};
      }
    }
    levels_.push_back(std::move(packed));
    const std::size_t half = px / 2;
    std::vector<Texel> coarse(half * half);
    for (std::size_t j = 0; j < half; ++j) {
      for (std::size_t i = 0; i < half; ++i) {
        const std::size_t k = 2 * j * px + 2 * i;
        coarse[j * half + i] = mean_of(texels[k], texels[k + 1], texels[k + px], texels[k + px + 1]);
      }
    }
    texels = std::move(coarse);
  }
}

Texel Texture::bilinear(std::size_t level, float u, float v) const {
  const std::uint32_t px = side_px_ >> level;
  const float scale = per_unit_ / static_cast<float>(1U << level);
  const float x = u * scale - 0.5F;
  const float y = v * scale - 0.5F;
  const auto floor_of = [](float value) {
    const auto cut = static_cast<std::int32_t>(value);
    return cut - (static_cast<float>(cut) > value ? 1 : 0);
  };
  const std::int32_t i = floor_of(x);
  const std::int32_t j = floor_of(y);
  const std::uint32_t mask = px - 1;
  const std::uint32_t i0 = static_cast<std::uint32_t>(i) & mask;
  const std::uint32_t j0 = static_cast<std::uint32_t>(j) & mask;
  const std::uint32_t i1 = (i0 + 1) & mask;
  const std::uint32_t j1 = (j0 + 1) & mask;
  const Packed* texels = levels_[level].data();
  const auto unpacked = [&](std::uint32_t row, std::uint32_t column) {
    const Packed p = texels[place(px, column, row)];
    // Twice each, and shifted with its sign: without it compilers convert one number after the other.
    const auto twice = __builtin_shufflevector(p, p, 0, 0, 1, 1, 2, 2, 3, 3);
    return __builtin_convertvector(std::bit_cast<Whole>(twice) >> 16, Texel::Values);
  };
  const float fx = x - static_cast<float>(i);
  const float fy = y - static_cast<float>(j);
  const Texel::Values low = unpacked(j0, i0) + fx * (unpacked(j0, i1) - unpacked(j0, i0));
  const Texel::Values high = unpacked(j1, i0) + fx * (unpacked(j1, i1) - unpacked(j1, i0));
  return {(1.0F / unit) * (low + fy * (high - low))};
}

Texel Texture::at(float u, float v, float footprint) const {
  const float coarsest = static_cast<float>(levels_.size() - 1);
  // Within a level's octave the logarithm is replaced by a straight line: who looks on does not see it.
  const float texels = std::clamp(footprint * per_unit_, 1.0F, static_cast<float>(side_px_));
  const auto bits = std::bit_cast<std::uint32_t>(texels);
  const float level =
      std::min(coarsest, static_cast<float>(bits >> 23U) - 127.0F + static_cast<float>(bits & 0x7FFFFFU) * 0x1p-23F);
  const auto low = static_cast<std::size_t>(level);
  const float t = level - static_cast<float>(low);
  const Texel fine = bilinear(low, u, v);
  return t > 0.0F && low + 1 < levels_.size() ? blend(fine, bilinear(low + 1, u, v), t) : fine;
}

Texture make_texture(Pattern pattern) {
  switch (pattern) {
    case Pattern::foil: return painted(512, 1.2F, foil_texel);
    case Pattern::solar_cells: return painted(1024, 0.96F, cell_texel);
    case Pattern::panel: return painted(512, 0.6F, panel_texel);
    case Pattern::labels: return painted(512, 0.6F, label_texel);
    case Pattern::plain:
    case Pattern::image: break;
  }
  return painted(1, 1.0F, [](float, float) { return Texel{}; });
}

Texture load_texture(const std::string& path) {
  Image image = read_png(path);
  keep_upper_bytes(image);
  if (image.width_px == 0 || image.height_px == 0) throw InputError(path, 0, "is empty", "a PNG image");
  const std::uint32_t side_px = std::min(2048U, std::bit_ceil(std::max(image.width_px, image.height_px)));
  std::vector<Texel> texels(static_cast<std::size_t>(side_px) * side_px);
  for (std::uint32_t j = 0; j < side_px; ++j) {
    for (std::uint32_t i = 0; i < side_px; ++i) {
      const std::size_t row = static_cast<std::size_t>(j) * image.height_px / side_px;
      const std::size_t column = static_cast<std::size_t>(i) * image.width_px / side_px;
      const float level = static_cast<float>(image.bytes[row * image.width_px + column]) / 255.0F;
      // sRGB, IEC 61966-2-1
      texels[static_cast<std::size_t>(j) * side_px + i].values[0] =
          level <= 0.04045F ? level / 12.92F : std::pow((level + 0.055F) / 1.055F, 2.4F);
    }
  }
  return Texture(side_px, std::move(texels), 1.0F);
}

}  // namespace relnav::hil
