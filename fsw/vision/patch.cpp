#include "fsw/vision/patch.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/vision/cubic.hpp"

namespace relnav::vision {
namespace {

constexpr int margin_half = window_half_px + 1;  // one more on each side for the gradient
constexpr int margin_side = 2 * margin_half + 1;
constexpr int fraction_bits = cubic_fraction_bits;
constexpr std::int32_t one = 1 << fraction_bits;
constexpr int position_bits = 16;

struct Sample {
  std::int16_t level_q3;
  bool saturated;
};

/// Position in Q16 pixels from the patch's first pixel; inside the patch.
Sample sample(const ReferencePatch& reference, std::int32_t u_q16, std::int32_t v_q16) {
  constexpr std::int32_t half_step = 1 << (position_bits - fraction_bits - 1);
  const std::int32_t u = (u_q16 + half_step) >> (position_bits - fraction_bits);
  const std::int32_t v = (v_q16 + half_step) >> (position_bits - fraction_bits);
  const std::int32_t fu = u & (one - 1);
  const std::int32_t fv = v & (one - 1);
  const std::int32_t u0 = u >> fraction_bits;
  const std::int32_t v0 = v >> fraction_bits;
  const std::uint8_t* pixel = &reference.levels[static_cast<std::size_t>(v0 * reference_side_px + u0)];
  if (fu == 0 && fv == 0) return {static_cast<std::int16_t>(*pixel * level_scale), *pixel >= saturated_level};
  const std::array<std::int32_t, 4> wu = cubic_weights(fu);
  const std::array<std::int32_t, 4> wv = cubic_weights(fv);
  pixel -= reference_side_px + 1;
  std::int32_t sum = 0;
  for (std::size_t row = 0; row < 4; ++row) {
    sum += ((pixel[0] * wu[0] + pixel[1] * wu[1]) + (pixel[2] * wu[2] + pixel[3] * wu[3])) * wv[row];
    pixel += reference_side_px;
  }
  pixel -= 3 * reference_side_px;
  const std::uint8_t brightest =
      std::max(std::max(pixel[1], pixel[2]), std::max(pixel[reference_side_px + 1], pixel[reference_side_px + 2]));
  constexpr int shift = 2 * cubic_weight_bits - 3;
  return {static_cast<std::int16_t>((sum + (1 << (shift - 1))) >> shift), brightest >= saturated_level};
}

std::int32_t to_q16(double x) {
  const double scaled = x * 65536.0;
  return static_cast<std::int32_t>(scaled < 0.0 ? scaled - 0.5 : scaled + 0.5);
}

}  // namespace

Status capture_patch(const ImageView& image, int u_px, int v_px, ReferencePatch& patch) {
  if (!image.is_valid()) return Status::invalid_argument;
  if (!image.contains(u_px, v_px, reference_half_px)) return Status::outside_domain;
  for (int row = 0; row < reference_side_px; ++row) {
    std::memcpy(&patch.levels[static_cast<std::size_t>(row * reference_side_px)],
                image.at(u_px - reference_half_px, v_px - reference_half_px + row), reference_side_px);
  }
  return Status::ok;
}

Status warp_patch(const ReferencePatch& reference, const Mat2& warp, const WarpLimits& limits, WarpedPatch& patch) {
  const double a = warp(0, 0);
  const double b = warp(0, 1);
  const double c = warp(1, 0);
  const double d = warp(1, 1);
  if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(c) || !std::isfinite(d)) return Status::not_finite;
  const double determinant = a * d - b * c;
  if (!(determinant >= 1.0 / limits.max_area_change && determinant <= limits.max_area_change)) {
    return Status::outside_domain;
  }
  if (!((a * a + b * b) + (c * c + d * d) <= 2.0 * limits.max_stretch * limits.max_stretch)) {
    return Status::outside_domain;
  }
  const double ia = d / determinant;
  const double ib = -b / determinant;
  const double ic = -c / determinant;
  const double id = a / determinant;
  constexpr double reach = static_cast<double>(reference_half_px) - 2.01;
  if (!((std::fabs(ia) + std::fabs(ib)) * margin_half <= reach &&
        (std::fabs(ic) + std::fabs(id)) * margin_half <= reach)) {
    return Status::outside_domain;
  }

  const std::int32_t ia_q16 = to_q16(ia);
  const std::int32_t ib_q16 = to_q16(ib);
  const std::int32_t ic_q16 = to_q16(ic);
  const std::int32_t id_q16 = to_q16(id);
  constexpr std::int32_t centre_q16 = reference_half_px << position_bits;
  std::array<std::array<Sample, margin_side>, margin_side> samples;
  for (int row = 0; row < margin_side; ++row) {
    const std::int32_t y = row - margin_half;
    for (int column = 0; column < margin_side; ++column) {
      const std::int32_t x = column - margin_half;
      samples[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          sample(reference, centre_q16 + ia_q16 * x + ib_q16 * y, centre_q16 + ic_q16 * x + id_q16 * y);
    }
  }

  std::int64_t squares = 0;
  patch.sum_q3 = 0;
  for (std::size_t row = 0; row < window_side_px; ++row) {
    for (std::size_t column = 0; column < window_side_px; ++column) {
      const std::size_t i = row * window_stride + column;
      const Sample& centre = samples[row + 1][column + 1];
      const Sample& left = samples[row + 1][column];
      const Sample& right = samples[row + 1][column + 2];
      const Sample& above = samples[row][column + 1];
      const Sample& below = samples[row + 2][column + 1];
      patch.level_q3[i] = centre.level_q3;
      patch.gradient_u_q3[i] = static_cast<std::int16_t>(right.level_q3 - left.level_q3);
      patch.gradient_v_q3[i] = static_cast<std::int16_t>(below.level_q3 - above.level_q3);
      const bool saturated =
          centre.saturated || left.saturated || right.saturated || above.saturated || below.saturated;
      patch.unsaturated[i] = saturated ? std::int16_t{0} : std::int16_t{-1};
      patch.sum_q3 += centre.level_q3;
      squares += static_cast<std::int64_t>(centre.level_q3) * centre.level_q3;
    }
  }
  patch.variance_q6 = window_pixels * squares - static_cast<std::int64_t>(patch.sum_q3) * patch.sum_q3;
  return Status::ok;
}

}  // namespace relnav::vision
