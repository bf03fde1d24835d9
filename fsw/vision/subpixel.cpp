#include "fsw/vision/subpixel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/vision/correlation.hpp"
#include "fsw/vision/cubic.hpp"
#include "fsw/vision/vector16.hpp"

namespace relnav::vision {
namespace {

constexpr int margin_px = 3;  // reach of the interpolation about the window moved by up to a pixel
constexpr int around_side = window_side_px + 2 * margin_px;
constexpr int around_stride = 24;
constexpr int fraction_bits = cubic_fraction_bits;
constexpr int one = 1 << fraction_bits;

using Around = std::array<std::int16_t, static_cast<std::size_t>(around_side* around_stride)>;  // rest of a row: zeros
using Vec4 = std::array<double, 4>;

/// Sum of the products of two windows.
std::int32_t dot(const WindowArray& a, const WindowArray& b) {
  I32x4 sum{};
  for (std::size_t i = 0; i < a.size(); i += 8) sum += multiply_add_pairs(load<I16x8>(&a[i]), load<I16x8>(&b[i]));
  return sum_of_lanes(sum);
}

/// Copy of the image about (u, v), edge pixels repeated outward.
void copy_around(const ImageView& image, int u_px, int v_px, Around& around) {
  for (int row = 0; row < around_side; ++row) {
    const int v = std::clamp(v_px - window_half_px - margin_px + row, 0, image.height - 1);
    for (int column = 0; column < around_side; ++column) {
      const int u = std::clamp(u_px - window_half_px - margin_px + column, 0, image.width - 1);
      around[static_cast<std::size_t>(row * around_stride + column)] = *image.at(u, v);
    }
  }
}

/// Window moved by (du, dv) in 1/256 px, |.| < 2 px; cubic, times mask (0 or -1).
void interpolate(const Around& around, int du_q8, int dv_q8, const WindowArray& mask, WindowArray& window_q3) {
  const std::array<std::int32_t, 4> wu = cubic_weights(du_q8 & (one - 1));
  const std::array<std::int32_t, 4> wv = cubic_weights(dv_q8 & (one - 1));
  const auto u0 = static_cast<std::size_t>(margin_px - 1 + (du_q8 >> fraction_bits));
  const auto v0 = static_cast<std::size_t>(margin_px - 1 + (dv_q8 >> fraction_bits));
  std::array<std::int16_t, around_stride> line_q3;
  for (std::size_t row = 0; row < window_side_px; ++row) {
    const std::int16_t* from = &around[(v0 + row) * around_stride];
    for (std::size_t i = 0; i < around_stride; ++i) {
      const std::int32_t sum = (from[i] * wv[0] + from[i + around_stride] * wv[1]) +
                               (from[i + 2 * around_stride] * wv[2] + from[i + 3 * around_stride] * wv[3]);
      line_q3[i] = static_cast<std::int16_t>((sum + 64) >> 7);
    }
    const std::int16_t* line = line_q3.data() + u0;
    for (std::size_t i = 0; i < window_stride; ++i) {
      const std::int32_t sum = (line[i] * wu[0] + line[i + 1] * wu[1]) + (line[i + 2] * wu[2] + line[i + 3] * wu[3]);
      window_q3[row * window_stride + i] =
          static_cast<std::int16_t>(((sum + 512) >> 10) & mask[row * window_stride + i]);
    }
  }
}

/// Linear least squares of a window on [gradient_u gradient_v level 1], over the pixels of a mask.
class BrightnessModel {
 public:
  BrightnessModel(const WarpedPatch& patch, const WindowArray& mask) {
    const std::array<const WindowArray*, 3> sources{&patch.gradient_u_q3, &patch.gradient_v_q3, &patch.level_q3};
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < mask.size(); ++i)
        columns_[k][i] = static_cast<std::int16_t>((*sources[k])[i] & mask[i]);
    }
    for (std::size_t i = 0; i < mask.size(); ++i) columns_[3][i] = static_cast<std::int16_t>(-mask[i]);
    for (std::size_t r = 0; r < 4; ++r) {
      for (std::size_t c = 0; c <= r; ++c) factor_[r][c] = static_cast<double>(dot(columns_[r], columns_[c]));
    }
    pixels_ = factor_[3][3];
  }

  /// Cholesky factor of the normal matrix; false when it is not well determined.
  [[nodiscard]] bool factorise() {
    for (std::size_t c = 0; c < 4; ++c) {
      const double diagonal = factor_[c][c];
      double pivot = diagonal;
      for (std::size_t k = 0; k < c; ++k) pivot -= factor_[c][k] * factor_[c][k];
      if (!(pivot > 1e-6 * diagonal && pivot > 0.0)) return false;
      const double root = std::sqrt(pivot);
      factor_[c][c] = root;
      for (std::size_t r = c + 1; r < 4; ++r) {
        double sum = factor_[r][c];
        for (std::size_t k = 0; k < c; ++k) sum -= factor_[r][k] * factor_[c][k];
        factor_[r][c] = sum / root;
      }
    }
    return true;
  }

  [[nodiscard]] Vec4 project(const WindowArray& window) const {
    Vec4 rhs;
    for (std::size_t k = 0; k < 4; ++k) rhs[k] = static_cast<double>(dot(columns_[k], window));
    return rhs;
  }

  [[nodiscard]] Vec4 solve(Vec4 x) const {
    for (std::size_t r = 0; r < 4; ++r) {
      for (std::size_t k = 0; k < r; ++k) x[r] -= factor_[r][k] * x[k];
      x[r] /= factor_[r][r];
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t r = 3 - i;
      for (std::size_t k = r + 1; k < 4; ++k) x[r] -= factor_[k][r] * x[k];
      x[r] /= factor_[r][r];
    }
    return x;
  }

  [[nodiscard]] double pixels() const { return pixels_; }

 private:
  alignas(16) std::array<WindowArray, 4> columns_;
  std::array<Vec4, 4> factor_{};
  double pixels_ = 0.0;
};

/// Pixels that neither the patch nor the image over-exposes; the image also not next to them.
int usable_pixels(const WarpedPatch& patch, const Around& around, WindowArray& mask) {
  int count = 0;
  for (int row = 0; row < window_side_px; ++row) {
    for (int column = 0; column < window_side_px; ++column) {
      const auto i = static_cast<std::size_t>(row * window_stride + column);
      std::int16_t brightest = 0;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          const int at = (row + margin_px + dv) * around_stride + column + margin_px + du;
          brightest = std::max(brightest, around[static_cast<std::size_t>(at)]);
        }
      }
      mask[i] = brightest < saturated_level ? patch.unsaturated[i] : std::int16_t{0};
      count -= mask[i];
    }
  }
  return count;
}

double squared(double x) { return x * x; }

int to_q8(double x) { return static_cast<int>(x * one + (x < 0.0 ? -0.5 : 0.5)); }

/// Offset of a parabola's maximum through three values one apart.
bool vertex(double before, double centre, double after, double& offset) {
  const double curvature = (before - 2.0 * centre) + after;
  if (!(curvature < -1e-6)) return false;
  offset = 0.5 * (before - after) / curvature;
  return std::fabs(offset) <= 1.0;
}

Status fit_quadratic(const WarpedPatch& patch, const ImageView& image, int u_px, int v_px, double score,
                     const SubpixelOptions& options, SubpixelResult& result) {
  if (!options.quadratic_fallback || !image.contains(u_px, v_px, window_half_px + 1)) return Status::rank_deficient;
  double du = 0.0;
  double dv = 0.0;
  if (!vertex(correlation_at(patch, image, u_px - 1, v_px), score, correlation_at(patch, image, u_px + 1, v_px), du) ||
      !vertex(correlation_at(patch, image, u_px, v_px - 1), score, correlation_at(patch, image, u_px, v_px + 1), dv)) {
    return Status::rank_deficient;
  }
  result.uv_px = Vec2(static_cast<double>(u_px) + du, static_cast<double>(v_px) + dv);
  result.sigma_px = options.quadratic_sigma_px;
  result.score = score;
  result.quadratic = true;
  return Status::ok;
}

}  // namespace

Status refine(const WarpedPatch& patch, const ImageView& image, int u_px, int v_px, double score,
              const SubpixelOptions& options, SubpixelResult& result) {
  result = SubpixelResult{};
  if (!image.contains(u_px, v_px, window_half_px)) return Status::outside_domain;
  alignas(16) Around around{};
  alignas(16) WindowArray mask{};
  copy_around(image, u_px, v_px, around);
  if (usable_pixels(patch, around, mask) < options.min_pixels) {
    return fit_quadratic(patch, image, u_px, v_px, score, options, result);
  }
  BrightnessModel model(patch, mask);
  if (!model.factorise()) return fit_quadratic(patch, image, u_px, v_px, score, options, result);

  alignas(16) WindowArray window{};
  int du_q8 = 0;
  int dv_q8 = 0;
  Vec4 rhs{};
  Vec4 fit{};
  bool converged = false;
  const int max_move_q8 = to_q8(std::min(options.max_move_px, 1.5));
  for (int iteration = 0; iteration < options.max_iterations && !converged; ++iteration) {
    interpolate(around, du_q8, dv_q8, mask, window);
    rhs = model.project(window);
    fit = model.solve(rhs);
    const double gain = fit[2];
    if (!(gain > 0.02)) return Status::no_convergence;
    // The image at this offset shows the patch moved by 2 fit / gain (the gradients are differences over two pixels).
    const int step_u = to_q8(std::clamp(-2.0 * fit[0] / gain, -1.0, 1.0));
    const int step_v = to_q8(std::clamp(-2.0 * fit[1] / gain, -1.0, 1.0));
    converged = std::abs(step_u) <= 1 && std::abs(step_v) <= 1;
    du_q8 += step_u;
    dv_q8 += step_v;
    result.iterations = iteration + 1;
    if (std::abs(du_q8) > max_move_q8 || std::abs(dv_q8) > max_move_q8) return Status::no_convergence;
  }
  if (!converged) return fit_quadratic(patch, image, u_px, v_px, score, options, result);

  const double squares = static_cast<double>(dot(window, window));
  const double explained = (rhs[0] * fit[0] + rhs[1] * fit[1]) + (rhs[2] * fit[2] + rhs[3] * fit[3]);
  const double total = squares - rhs[3] * rhs[3] / model.pixels();
  const double residual = std::max(squares - explained, 0.0);
  if (!(total > 0.0)) return Status::rank_deficient;
  result.score = std::sqrt(std::max(1.0 - residual / total, 0.0));
  if (result.score < score - options.max_score_loss) return Status::no_convergence;

  // Covariance of the shift: residual variance * (2 / gain)^2 * the inverse normal matrix's first block.
  const Vec4 first = model.solve({1.0, 0.0, 0.0, 0.0});
  const Vec4 second = model.solve({0.0, 1.0, 0.0, 0.0});
  const double mean = 0.5 * (first[0] + second[1]);
  const double larger = mean + std::sqrt(squared(0.5 * (first[0] - second[1])) + squared(first[1]));
  const double variance = residual / (model.pixels() - 4.0) * (4.0 / squared(fit[2])) * larger;
  result.sigma_px = std::clamp(options.sigma_scale * std::sqrt(variance), options.min_sigma_px, options.max_sigma_px);
  result.uv_px = Vec2(static_cast<double>(u_px) + static_cast<double>(du_q8) / one,
                      static_cast<double>(v_px) + static_cast<double>(dv_q8) / one);
  return Status::ok;
}

}  // namespace relnav::vision
