#include "hil/render/point_spread.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hil/render/any_width.hpp"

namespace relnav::hil {
namespace {

constexpr std::uint32_t coarse = 4;  // pixels of the image along one of the halo's grid

/// From its centre outward, cut at four sigma; sums to `share` with its mirror image.
std::vector<float> half_kernel(double sigma, double share) {
  const int radius = sigma > 0.0 ? std::max(1, static_cast<int>(std::ceil(4.0 * sigma))) : 0;
  std::vector<double> weights;
  double sum = 0.0;
  for (int i = 0; i <= radius; ++i) {
    weights.push_back(i == 0 ? 1.0 : std::exp(-0.5 * i * i / (sigma * sigma)));
    sum += (i == 0 ? 1.0 : 2.0) * weights.back();
  }
  std::vector<float> kernel;
  for (const double w : weights) kernel.push_back(static_cast<float>(share * w / sum));
  return kernel;
}

RELNAV_ANY_WIDTH void scale_row(const float* in, float w, float* out, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) out[i] = w * in[i];
}
RELNAV_ANY_WIDTH void add_rows(const float* a, const float* b, float w, float* out, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) out[i] += w * (a[i] + b[i]);
}

void spread_along(const float* in, const std::vector<float>& kernel, float* out, std::size_t width,
                  std::vector<float>& padded) {
  const std::size_t radius = kernel.size() - 1;
  padded.assign(width + 2 * radius, 0.0F);
  std::copy_n(in, width, padded.begin() + static_cast<std::ptrdiff_t>(radius));
  const float* centre = padded.data() + radius;
  scale_row(centre, kernel[0], out, width);
  for (std::size_t k = 1; k <= radius; ++k) add_rows(centre - k, centre + k, kernel[k], out, width);
}

void spread_down(const Plane& in, const std::vector<float>& kernel, float* out, std::uint32_t v,
                 const std::vector<float>& zeros) {
  scale_row(in.row(v), kernel[0], out, in.width);
  for (std::uint32_t k = 1; k < kernel.size(); ++k) {
    const float* above = v >= k ? in.row(v - k) : zeros.data();
    const float* below = v + k < in.height ? in.row(v + k) : zeros.data();
    add_rows(above, below, kernel[k], out, in.width);
  }
}

}  // namespace

PointSpreadFilter::PointSpreadFilter(const PointSpread& spread, std::uint32_t width, std::uint32_t height)
    : spread_(spread), core_(half_kernel(spread.sigma_px, 1.0)) {
  // Averaging over 4 px and going linearly between their centres spreads already.
  const double grid = coarse;
  const double already = (grid * grid - 1.0) / 12.0 + grid * grid / 6.0;
  halo_ = half_kernel(std::sqrt(std::max(0.1, spread.halo_sigma_px * spread.halo_sigma_px - already)) / grid, 1.0);
  across_.resize(width, height);
  coarse_.resize((width + coarse - 1) / coarse, (height + coarse - 1) / coarse);
  coarse_across_.resize(coarse_.width, coarse_.height);
  coarse_halo_.resize(coarse_.width, coarse_.height);
}

void PointSpreadFilter::apply(const Plane& sharp, const Plane& points, WorkerPool& pool, Plane& out) {
  const std::uint32_t bands = (sharp.height + 4 * coarse - 1) / (4 * coarse);
  const bool has_halo = spread_.halo_share > 0.0;
  const auto core_share = static_cast<float>(1.0 - spread_.halo_share);
  const std::vector<float> zeros(sharp.width, 0.0F);
  const auto rows_of = [&](std::size_t band, std::uint32_t height, std::uint32_t rows, auto&& work) {
    const auto first = static_cast<std::uint32_t>(band) * rows;
    for (std::uint32_t v = first; v < std::min(first + rows, height); ++v) work(v);
  };
  pool.run(bands, [&](std::size_t band) {
    std::vector<float> padded;
    rows_of(band, sharp.height, 4 * coarse, [&](std::uint32_t v) {
      spread_along(sharp.row(v), core_, across_.row(v), sharp.width, padded);
      if (!has_halo) return;
      float* into = coarse_.row(v / coarse);
      if (v % coarse == 0) std::fill_n(into, coarse_.width, 0.0F);
      constexpr float share = 1.0F / (coarse * coarse);
      const float* a = sharp.row(v);
      const float* b = points.row(v);
      for (std::uint32_t u = 0; u < sharp.width; ++u) into[u / coarse] += share * (a[u] + b[u]);
    });
    if (!has_halo) return;
    rows_of(band, coarse_.height, 4, [&](std::uint32_t v) {
      spread_along(coarse_.row(v), halo_, coarse_across_.row(v), coarse_.width, padded);
    });
  });
  if (has_halo) {
    pool.run(coarse_.height, [&](std::size_t v) {
      const auto row = static_cast<std::uint32_t>(v);
      spread_down(coarse_across_, halo_, coarse_halo_.row(row), row, zeros);
    });
  }
  out.resize(sharp.width, sharp.height);
  pool.run(bands, [&](std::size_t band) {
    std::vector<float> line(coarse_.width + 2);
    rows_of(band, sharp.height, 4 * coarse, [&](std::uint32_t v) {
      float* to = out.row(v);
      spread_down(across_, core_, to, v, zeros);
      scale_row(to, core_share, to, sharp.width);
      add_rows(points.row(v), zeros.data(), core_share, to, sharp.width);
      if (!has_halo) return;
      // Between the centres of the coarse grid, linearly.
      const float y = (static_cast<float>(v) + 0.5F) / coarse - 0.5F;
      const auto y0 = static_cast<std::uint32_t>(std::max(y, 0.0F));
      const std::uint32_t y1 = std::min(y0 + 1, coarse_.height - 1);
      const float fy = std::max(y - static_cast<float>(y0), 0.0F);
      const auto halo_share = static_cast<float>(spread_.halo_share);
      for (std::uint32_t u = 0; u < coarse_.width; ++u) {
        const float a = coarse_halo_.row(y0)[u];
        line[u + 1] = halo_share * (a + fy * (coarse_halo_.row(y1)[u] - a));
      }
      line.front() = line[1];
      line.back() = line[coarse_.width];
      constexpr std::array<float, coarse> between{0.625F, 0.875F, 0.125F, 0.375F};
      for (std::uint32_t u = 0; u < sharp.width; ++u) {
        const std::uint32_t k = u % coarse;
        const float* at = line.data() + u / coarse + (k < 2 ? 0 : 1);
        to[u] += at[0] + between[k] * (at[1] - at[0]);
      }
    });
  });
}

void draw_point(Plane& plane, double u, double v, double energy, double sigma_px) {
  constexpr int most = 24;
  const int radius = std::min(most - 1, static_cast<int>(std::ceil(4.5 * sigma_px + 0.5)));
  const auto u0 = static_cast<int>(std::lround(u));
  const auto v0 = static_cast<int>(std::lround(v));
  std::array<double, 2 * most> across{};
  std::array<double, 2 * most> down{};
  const double scale = 1.0 / (std::sqrt(2.0) * std::max(sigma_px, 1e-3));
  const auto integrate = [&](double at, int centre, std::array<double, 2 * most>& weights) {
    double before = std::erf((centre - radius - 0.5 - at) * scale);
    for (int i = -radius; i <= radius; ++i) {
      const double here = std::erf((centre + i + 0.5 - at) * scale);
      weights[static_cast<std::size_t>(i + radius)] = 0.5 * (here - before);
      before = here;
    }
  };
  integrate(u, u0, across);
  integrate(v, v0, down);
  for (int j = -radius; j <= radius; ++j) {
    if (v0 + j < 0 || v0 + j >= static_cast<int>(plane.height)) continue;
    float* row = plane.row(static_cast<std::uint32_t>(v0 + j));
    const double weight = energy * down[static_cast<std::size_t>(j + radius)];
    for (int i = -radius; i <= radius; ++i) {
      if (u0 + i < 0 || u0 + i >= static_cast<int>(plane.width)) continue;
      row[u0 + i] += static_cast<float>(weight * across[static_cast<std::size_t>(i + radius)]);
    }
  }
}

}  // namespace relnav::hil
