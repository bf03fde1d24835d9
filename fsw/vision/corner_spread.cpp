#include "fsw/vision/corner_spread.hpp"

#include <algorithm>
#include <array>

#include "fsw/vision/patch.hpp"
#include "fsw/vision/vector16.hpp"

namespace relnav::vision {
namespace {

constexpr int min_cell_px = 16;
constexpr int max_cells = 240;  // they live on the stack; 640 x 480 in cells of 40 are 192
constexpr std::size_t corners_per_cell = 6;

struct CellCorner {
  std::uint16_t u_px = 0;
  std::uint16_t v_px = 0;
  std::int32_t score = 0;
};

struct Cell {
  std::array<CellCorner, corners_per_cell> corners;  // best first
  std::uint8_t count = 0;
  std::uint8_t features = 0;
};

/// The columns of the matching window among 16.
constexpr std::array<std::uint8_t, 16> spread_columns = [] {
  std::array<std::uint8_t, 16> mask{};
  for (std::size_t i = 0; i < window_side_px; ++i) mask[i] = 0xFF;
  return mask;
}();
static_assert(corner_reach_px >= 16 - window_half_px && reference_half_px >= corner_reach_px);

/// Largest r with r * r <= x.
std::uint64_t root_floor(std::uint64_t x) {
  std::uint64_t root = 0;
  std::uint64_t bit = std::uint64_t{1} << 62U;
  while (bit > x) bit >>= 2U;  // bound: 31
  while (bit != 0) {           // bound: 32
    if (x >= root + bit) {
      x -= root + bit;
      root = (root >> 1U) + bit;
    } else {
      root >>= 1U;
    }
    bit >>= 2U;
  }
  return root;
}

int saturated_pixels(const ImageView& image, int u_px, int v_px) {
  U8x16 counts{};
  for (int v = v_px - window_half_px; v <= v_px + window_half_px; ++v) {
    const U8x16 levels = load<U8x16>(image.at(u_px - window_half_px, v));
    const U8x16 over = reinterpret_cast<U8x16>(levels >= splat(saturated_level)) & load<U8x16>(spread_columns.data());
    counts -= over;
  }
  int count = 0;
  for (int i = 0; i < 16; ++i) count += counts[i];
  return count;
}

/// Keeps the best of a cell, in order; the earlier stays ahead of an equal.
void insert(Cell& cell, const CellCorner& corner) {
  std::size_t k = cell.count;
  if (k == corners_per_cell) {
    if (corner.score <= cell.corners[k - 1].score) return;
    --k;
  } else {
    ++cell.count;
  }
  for (; k > 0 && corner.score > cell.corners[k - 1].score; --k) cell.corners[k] = cell.corners[k - 1];
  cell.corners[k] = corner;
}

int divide_up(int a, int b) { return (a + b - 1) / b; }

/// The side asked for, or the next larger one with which the cells suffice for the image.
int cell_side(const ImageView& image, int wanted_px) {
  const int largest = static_cast<int>(std::max(config::max_image_width, config::max_image_height));
  int side = std::min(wanted_px, largest);
  // bound: the largest side of an image
  while (side < largest && divide_up(image.width, side) * divide_up(image.height, side) > max_cells) ++side;
  return side;
}

class Selection {
 public:
  Selection(const ImageView& image, std::span<const Vec2> tracked_px, const SpreadOptions& options,
            CornerCandidates& candidates)
      : image_(image),
        tracked_px_(tracked_px),
        options_(options),
        candidates_(candidates),
        cell_px_(cell_side(image, options.cell_px)),
        columns_(divide_up(image.width, cell_px_)),
        cell_count_(static_cast<std::size_t>(columns_ * divide_up(image.height, cell_px_))) {
    for (const Vec2& uv : tracked_px) {
      if (uv(0) >= 0.0 && uv(1) >= 0.0 && uv(0) < static_cast<double>(image.width) &&
          uv(1) < static_cast<double>(image.height)) {
        add_feature(static_cast<int>(uv(0)), static_cast<int>(uv(1)));
      }
    }
  }

  /// The strongest few of each cell by FAST score, away from features.
  void sort_into_cells(std::span<const FastCorner> corners) {
    const int border = std::max(options_.border_px, reference_half_px);
    for (const FastCorner& corner : corners) {
      if (!image_.contains(corner.u_px, corner.v_px, border)) continue;
      Cell& cell = cell_of(corner.u_px, corner.v_px);
      if (cell.count == corners_per_cell && corner.score <= cell.corners[corners_per_cell - 1].score) continue;
      if (near_tracked(corner.u_px, corner.v_px)) continue;
      insert(cell, {corner.u_px, corner.v_px, corner.score});
    }
  }

  /// Replaces FAST scores by corner strengths, and drops what is no good to track.
  void rate() {
    for (std::size_t i = 0; i < cell_count_; ++i) {
      const Cell raw = cells_[i];
      cells_[i].count = 0;
      for (std::size_t k = 0; k < raw.count; ++k) {
        CellCorner corner = raw.corners[k];
        if (saturated_pixels(image_, corner.u_px, corner.v_px) > options_.max_saturated) continue;
        corner.score = corner_strength(image_, corner.u_px, corner.v_px);
        if (corner.score >= options_.min_score) insert(cells_[i], corner);
      }
    }
  }

  void pick(std::size_t wanted) {
    const std::size_t limit = std::min(wanted, CornerCandidates::capacity());
    const std::size_t rounds = cell_count_ * corners_per_cell;
    for (std::size_t round = 0; round < rounds && candidates_.size() < limit; ++round) {
      const std::size_t best = best_cell();
      if (best == cell_count_) return;
      Cell& cell = cells_[best];
      const CellCorner corner = cell.corners[0];
      for (std::size_t k = 1; k < cell.count; ++k) cell.corners[k - 1] = cell.corners[k];
      --cell.count;
      if (near_candidate(corner)) continue;
      static_cast<void>(candidates_.push_back({corner.u_px, corner.v_px, corner.score}));
      add_feature(corner.u_px, corner.v_px);
    }
  }

 private:
  [[nodiscard]] Cell& cell_of(int u_px, int v_px) {
    return cells_[static_cast<std::size_t>(v_px / cell_px_ * columns_ + u_px / cell_px_)];
  }
  void add_feature(int u_px, int v_px) {
    Cell& cell = cell_of(u_px, v_px);
    if (cell.features < 255) ++cell.features;
  }

  [[nodiscard]] bool near_tracked(int u_px, int v_px) const {
    const double limit = options_.min_distance_px * options_.min_distance_px;
    for (const Vec2& uv : tracked_px_) {
      const double du = uv(0) - static_cast<double>(u_px);
      const double dv = uv(1) - static_cast<double>(v_px);
      if (du * du + dv * dv < limit) return true;
    }
    return false;
  }
  [[nodiscard]] bool near_candidate(const CellCorner& corner) const {
    const double limit = options_.min_distance_px * options_.min_distance_px;
    for (const CornerCandidate& other : candidates_) {
      const int du = other.u_px - corner.u_px;
      const int dv = other.v_px - corner.v_px;
      if (static_cast<double>(du * du + dv * dv) < limit) return true;
    }
    return false;
  }

  /// Cell with the corner of most worth: strength, no more than good_score, over (1 + features in the cell)^2.
  [[nodiscard]] std::size_t best_cell() const {
    std::size_t best = cell_count_;
    std::int32_t best_worth = -1;
    std::int32_t best_score = -1;
    for (std::size_t i = 0; i < cell_count_; ++i) {
      const Cell& cell = cells_[i];
      if (cell.count == 0) continue;
      const std::int32_t score = cell.corners[0].score;
      const std::int32_t share = (1 + cell.features) * (1 + cell.features);
      const std::int32_t worth = std::min(score, options_.good_score) / share;
      if (worth > best_worth || (worth == best_worth && score > best_score)) {
        best = i;
        best_worth = worth;
        best_score = score;
      }
    }
    return best;
  }

  const ImageView& image_;
  std::span<const Vec2> tracked_px_;
  const SpreadOptions& options_;
  CornerCandidates& candidates_;
  int cell_px_;
  int columns_;
  std::size_t cell_count_;
  std::array<Cell, static_cast<std::size_t>(max_cells)> cells_{};
};

}  // namespace

std::int32_t corner_strength(const ImageView& image, int u_px, int v_px) {
  I32x4 sum_uu{};
  I32x4 sum_vv{};
  I32x4 sum_uv{};
  for (int v = v_px - window_half_px; v <= v_px + window_half_px; ++v) {
    const std::uint8_t* row = image.at(u_px - window_half_px, v);
    const U8x16 left = load<U8x16>(row - 1);
    const U8x16 right = load<U8x16>(row + 1);
    const U8x16 above = load<U8x16>(row - image.stride);
    const U8x16 below = load<U8x16>(row + image.stride);
    const U8x16 usable = reinterpret_cast<U8x16>(max(max(left, right), max(above, below)) < splat(saturated_level)) &
                         load<U8x16>(spread_columns.data());
    const U8x16 masked_left = left & usable;
    const U8x16 masked_right = right & usable;
    const U8x16 masked_above = above & usable;
    const U8x16 masked_below = below & usable;
    for (int half = 0; half < 2; ++half) {
      const I16x8 gu = widen(masked_right, half) - widen(masked_left, half);
      const I16x8 gv = widen(masked_below, half) - widen(masked_above, half);
      sum_uu += multiply_add_pairs(gu, gu);
      sum_vv += multiply_add_pairs(gv, gv);
      sum_uv += multiply_add_pairs(gu, gv);
    }
  }
  const std::int32_t uu = sum_of_lanes(sum_uu);
  const std::int32_t vv = sum_of_lanes(sum_vv);
  const std::int32_t uv = sum_of_lanes(sum_uv);
  // 2 lambda_min = uu + vv - sqrt((uu - vv)^2 + (2 uv)^2); the gradients are twice the half differences.
  const std::int64_t difference = static_cast<std::int64_t>(uu) - vv;
  const std::int64_t twice = 2 * static_cast<std::int64_t>(uv);
  const auto square = static_cast<std::uint64_t>(difference * difference + twice * twice);
  const std::int64_t two_lambda = static_cast<std::int64_t>(uu) + vv - static_cast<std::int64_t>(root_floor(square));
  return static_cast<std::int32_t>(std::max<std::int64_t>(two_lambda, 0) * 100 / (8 * window_pixels));
}

Status select_corners(const ImageView& image, std::span<const FastCorner> corners, std::span<const Vec2> tracked_px,
                      std::size_t wanted, const SpreadOptions& options, CornerCandidates& candidates) {
  candidates.clear();
  if (!image.is_valid() || options.cell_px < min_cell_px) return Status::invalid_argument;
  Selection selection(image, tracked_px, options, candidates);
  selection.sort_into_cells(corners);
  selection.rate();
  selection.pick(wanted);
  return Status::ok;
}

}  // namespace relnav::vision
