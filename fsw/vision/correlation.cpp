#include "fsw/vision/correlation.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/vector16.hpp"

namespace relnav::vision {
namespace {

constexpr std::int16_t not_evaluated = -32768;
constexpr double score_scale = 16384.0;
constexpr int distinct_px = 3;
constexpr std::size_t lattice_candidates = 8;

/// 1 for the columns of the window, 0 for the padding.
constexpr std::array<std::int16_t, window_stride> window_columns = [] {
  std::array<std::int16_t, window_stride> columns{};
  for (std::size_t i = 0; i < window_side_px; ++i) columns[i] = 1;
  return columns;
}();
static_assert(window_side_px >= 8 && window_stride == 16);

/// Correlation with the window whose first pixel is `image`; reads window_stride columns of window_side_px rows.
double correlate(const WarpedPatch& patch, const std::int16_t* image, int stride) {
  const I16x8 ones_low = load<I16x8>(window_columns.data());
  const I16x8 ones_high = load<I16x8>(window_columns.data() + 8);
  I32x4 product{};
  I32x4 sum{};
  I32x4 square{};
  for (int row = 0; row < window_side_px; ++row) {
    const std::int16_t* t = patch.level_q3.data() + row * window_stride;
    const I16x8 low = load<I16x8>(image);
    const I16x8 high = load<I16x8>(image + 8) & -ones_high;
    product += multiply_add_pairs(low, load<I16x8>(t)) + multiply_add_pairs(high, load<I16x8>(t + 8));
    sum += multiply_add_pairs(low, ones_low) + multiply_add_pairs(high, ones_high);
    square += multiply_add_pairs(low, low) + multiply_add_pairs(high, high);
    image += stride;
  }
  const std::int64_t image_sum = sum_of_lanes(sum);
  const std::int64_t variance = static_cast<std::int64_t>(window_pixels) * sum_of_lanes(square) - image_sum * image_sum;
  const std::int64_t covariance =
      static_cast<std::int64_t>(window_pixels) * sum_of_lanes(product) - image_sum * patch.sum_q3;
  if (variance <= 0 || patch.variance_q6 <= 0) return 0.0;
  return static_cast<double>(covariance) /
         std::sqrt(static_cast<double>(variance) * static_cast<double>(patch.variance_q6));
}

std::int16_t to_q14(double score) {
  return static_cast<std::int16_t>(score * score_scale + (score < 0.0 ? -0.5 : 0.5));
}

/// Largest integer <= x, for |x| < 2^30.
int floor_to_int(double x) {
  const int truncated = static_cast<int>(x);
  return static_cast<double>(truncated) > x ? truncated - 1 : truncated;
}

/// The pixels to visit, as a rectangle and an ellipse in it.
struct Region {
  int u0, v0, u1, v1;  // inclusive
  int centre_u, centre_v;
  double uv0, uv1;
  double i00, i01, i11;
  double gate;

  [[nodiscard]] bool contains(int u, int v) const {
    const int du = u - centre_u;
    const int dv = v - centre_v;
    if (du >= -1 && du <= 1 && dv >= -1 && dv <= 1) return true;
    const double x = static_cast<double>(u) - uv0;
    const double y = static_cast<double>(v) - uv1;
    return (i00 * x * x + 2.0 * i01 * x * y) + i11 * y * y <= gate;
  }
};

/// Scan in progress.
class Scan {
 public:
  Scan(const WarpedPatch& patch, const ImageView& image, const Region& region, SearchScratch& scratch,
       SearchResult& result)
      : patch_(patch),
        region_(region),
        columns_(region.u1 - region.u0 + 1),
        rows_(region.v1 - region.v0 + 1),
        scratch_(scratch),
        result_(result) {
    const int region_columns = columns_ + window_side_px - 1;
    for (int row = 0; row < rows_ + window_side_px - 1; ++row) {
      const std::uint8_t* from = image.at(region.u0 - window_half_px, region.v0 - window_half_px + row);
      std::int16_t* to = scratch.region.data() + row * SearchScratch::region_stride;
      for (int column = 0; column < region_columns; ++column) to[column] = from[column];
    }
    std::fill_n(scratch.scores_q14.data(), columns_ * rows_, not_evaluated);
  }

  void every(int step) {
    for (int v = region_.v0; v <= region_.v1; v += step) {
      for (int u = region_.u0; u <= region_.u1; u += step) {
        if (region_.contains(u, v)) visit(u, v);
      }
    }
  }

  /// The pixels between, around the best points of the lattice.
  void around_best() {
    std::array<int, lattice_candidates> best{};
    std::size_t count = 0;
    for (int i = 0; i < columns_ * rows_; ++i) {
      const std::int16_t score = scratch_.scores_q14[static_cast<std::size_t>(i)];
      if (score == not_evaluated) continue;
      if (count == best.size() && score <= score_at(best[count - 1])) continue;
      if (count < best.size()) ++count;
      std::size_t k = count - 1;
      for (; k > 0 && score > score_at(best[k - 1]); --k) best[k] = best[k - 1];
      best[k] = i;
    }
    for (std::size_t k = 0; k < count; ++k) {
      const int u = region_.u0 + best[k] % columns_;
      const int v = region_.v0 + best[k] / columns_;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          const bool inside =
              u + du >= region_.u0 && u + du <= region_.u1 && v + dv >= region_.v0 && v + dv <= region_.v1;
          if (inside && region_.contains(u + du, v + dv)) visit(u + du, v + dv);
        }
      }
    }
  }

  void find_second() {
    std::int16_t second = not_evaluated;
    for (int row = 0; row < rows_; ++row) {
      const bool row_near = std::abs(region_.v0 + row - result_.v_px) <= distinct_px;
      for (int column = 0; column < columns_; ++column) {
        if (row_near && std::abs(region_.u0 + column - result_.u_px) <= distinct_px) continue;
        second = std::max(second, scratch_.scores_q14[static_cast<std::size_t>(row * columns_ + column)]);
      }
    }
    result_.second_score = second == not_evaluated ? -1.0 : static_cast<double>(second) / score_scale;
  }

 private:
  [[nodiscard]] std::int16_t score_at(int i) const { return scratch_.scores_q14[static_cast<std::size_t>(i)]; }

  void visit(int u, int v) {
    const int row = v - region_.v0;
    const int column = u - region_.u0;
    std::int16_t& stored = scratch_.scores_q14[static_cast<std::size_t>(row * columns_ + column)];
    if (stored != not_evaluated) return;
    const double score = correlate(patch_, scratch_.region.data() + row * SearchScratch::region_stride + column,
                                   SearchScratch::region_stride);
    stored = to_q14(score);
    ++result_.positions;
    if (result_.positions == 1 || score > result_.score) {
      result_.score = score;
      result_.u_px = u;
      result_.v_px = v;
    }
  }

  const WarpedPatch& patch_;
  const Region& region_;
  int columns_;
  int rows_;
  SearchScratch& scratch_;
  SearchResult& result_;
};

}  // namespace

double correlation_at(const WarpedPatch& patch, const ImageView& image, int u_px, int v_px) {
  alignas(16) WindowArray window{};
  for (int row = 0; row < window_side_px; ++row) {
    const std::uint8_t* from = image.at(u_px - window_half_px, v_px - window_half_px + row);
    for (int column = 0; column < window_side_px; ++column) {
      window[static_cast<std::size_t>(row * window_stride + column)] = from[column];
    }
  }
  return correlate(patch, window.data(), window_stride);
}

Status search(const WarpedPatch& patch, const ImageView& image, const Vec2& uv_px, const Mat2& S_px2,
              const SearchOptions& options, SearchScratch& scratch, SearchResult& result) {
  result = SearchResult{};
  const double s00 = S_px2(0, 0);
  const double s01 = 0.5 * (S_px2(0, 1) + S_px2(1, 0));
  const double s11 = S_px2(1, 1);
  if (!std::isfinite(uv_px(0)) || !std::isfinite(uv_px(1))) return Status::not_finite;
  if (!std::isfinite(s00) || !std::isfinite(s01) || !std::isfinite(s11)) return Status::not_finite;
  const double determinant = s00 * s11 - s01 * s01;
  if (!(s00 > 0.0 && s11 > 0.0 && determinant > 0.0)) return Status::not_positive_definite;
  if (!(std::fabs(uv_px(0)) < 1e6 && std::fabs(uv_px(1)) < 1e6)) return Status::outside_domain;

  const double half_u = std::sqrt(options.chi_square * s00);
  const double half_v = std::sqrt(options.chi_square * s11);
  constexpr double cap = static_cast<double>(max_search_half_px);
  result.capped = half_u > cap || half_v > cap;
  const double reach_u = std::min(half_u, cap);
  const double reach_v = std::min(half_v, cap);
  Region region{};
  region.centre_u = floor_to_int(uv_px(0) + 0.5);
  region.centre_v = floor_to_int(uv_px(1) + 0.5);
  const auto first = [](double x, double reach, int centre) {
    return std::clamp(-floor_to_int(reach - x), centre - max_search_half_px, centre - 1);
  };
  const auto last = [](double x, double reach, int centre) {
    return std::clamp(floor_to_int(x + reach), centre + 1, centre + max_search_half_px);
  };
  region.u0 = std::max(first(uv_px(0), reach_u, region.centre_u), window_half_px);
  region.v0 = std::max(first(uv_px(1), reach_v, region.centre_v), window_half_px);
  region.u1 = std::min(last(uv_px(0), reach_u, region.centre_u), image.width - 1 - window_half_px);
  region.v1 = std::min(last(uv_px(1), reach_v, region.centre_v), image.height - 1 - window_half_px);
  if (region.u0 > region.u1 || region.v0 > region.v1) return Status::outside_domain;
  region.uv0 = uv_px(0);
  region.uv1 = uv_px(1);
  region.i00 = s11 / determinant;
  region.i01 = -s01 / determinant;
  region.i11 = s00 / determinant;
  region.gate = options.chi_square;

  result.on_lattice = pi * options.chi_square * std::sqrt(determinant) > static_cast<double>(options.full_scan_limit);
  Scan scan(patch, image, region, scratch, result);
  if (result.on_lattice) {
    scan.every(2);
    scan.around_best();
  } else {
    scan.every(1);
  }
  if (result.positions == 0) return Status::outside_domain;
  scan.find_second();
  return Status::ok;
}

}  // namespace relnav::vision
