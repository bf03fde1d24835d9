#include "fsw/vision/fast_corners.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "fsw/vision/vector16.hpp"

namespace relnav::vision {
namespace {

constexpr int radius = 3;
constexpr int lanes = 16;
constexpr std::size_t max_blocks = config::max_image_width / lanes + 1;
constexpr std::size_t row_pad = lanes;

/// Circle of radius 3, consecutive.
constexpr std::array<std::array<int, 2>, 16> circle{{{0, 3},
                                                     {1, 3},
                                                     {2, 2},
                                                     {3, 1},
                                                     {3, 0},
                                                     {3, -1},
                                                     {2, -2},
                                                     {1, -3},
                                                     {0, -3},
                                                     {-1, -3},
                                                     {-2, -2},
                                                     {-3, -1},
                                                     {-3, 0},
                                                     {-3, 1},
                                                     {-2, 2},
                                                     {-1, 3}}};

using Ring = std::array<U8x16, 16>;

/// max over the 16 arcs of 9 of the least level in the arc. An arc is 8 from an odd start plus one more at either end:
/// max(min(m8, x_k), min(m8, x_k+9)) = min(m8, max(x_k, x_k+9)).
[[gnu::always_inline]] inline U8x16 brightest_arc(const Ring& x) {
  std::array<U8x16, 8> pair;
  std::array<U8x16, 8> four;
  for (std::size_t i = 0; i < 8; ++i) pair[i] = min(x[2 * i + 1], x[(2 * i + 2) % 16]);
  for (std::size_t i = 0; i < 8; ++i) four[i] = min(pair[i], pair[(i + 1) % 8]);
  U8x16 best{};
  for (std::size_t i = 0; i < 8; ++i) {
    best = max(best, min(min(four[i], four[(i + 2) % 8]), max(x[2 * i], x[(2 * i + 9) % 16])));
  }
  return best;
}

/// min over the 16 arcs of 9 of the greatest level in the arc.
[[gnu::always_inline]] inline U8x16 darkest_arc(const Ring& x) {
  std::array<U8x16, 8> pair;
  std::array<U8x16, 8> four;
  for (std::size_t i = 0; i < 8; ++i) pair[i] = max(x[2 * i + 1], x[(2 * i + 2) % 16]);
  for (std::size_t i = 0; i < 8; ++i) four[i] = max(pair[i], pair[(i + 1) % 8]);
  U8x16 best = splat(255);
  for (std::size_t i = 0; i < 8; ++i) {
    best = min(best, max(max(four[i], four[(i + 2) % 8]), min(x[2 * i], x[(2 * i + 9) % 16])));
  }
  return best;
}

/// Collects corners; when told to, only those above a score, and so many of that score.
class Sink {
 public:
  explicit Sink(std::span<FastCorner> corners) : corners_(corners) {}

  void put(int u_px, int v_px, std::uint8_t score) {
    ++found_;
    ++histogram_[score];
    if (score < cut_) return;
    if (score == cut_) {
      if (ties_ == 0) return;
      --ties_;
    }
    if (count_ < corners_.size()) {
      corners_[count_++] = {static_cast<std::uint16_t>(u_px), static_cast<std::uint16_t>(v_px), score};
    }
  }
  /// Starts over, now keeping only as many as there is room for.
  void restart_with_strongest() {
    std::size_t above = 0;
    int cut = 255;
    // bound: 255 scores
    while (cut > 0 && above + histogram_[static_cast<std::size_t>(cut)] <= corners_.size()) {
      above += histogram_[static_cast<std::size_t>(cut)];
      --cut;
    }
    cut_ = static_cast<std::uint8_t>(cut);
    ties_ = corners_.size() - above;
    count_ = 0;
    found_ = 0;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t found() const { return found_; }
  [[nodiscard]] bool overflowed() const { return found_ > corners_.size(); }

 private:
  std::span<FastCorner> corners_;
  std::size_t count_ = 0;
  std::size_t found_ = 0;
  std::size_t ties_ = config::max_image_width * config::max_image_height;
  std::uint8_t cut_ = 0;
  std::array<std::uint32_t, 256> histogram_{};
};

/// Scores of one row of pixels, zero where there is no corner, and which blocks have any.
struct ScoreRow {
  std::array<std::uint8_t, config::max_image_width + 2 * row_pad> scores{};
  std::array<std::uint16_t, max_blocks> blocks{};
  std::size_t block_count = 0;

  [[nodiscard]] std::uint8_t* at(int u_px) { return scores.data() + row_pad + u_px; }
  void clear() {
    for (std::size_t i = 0; i < block_count; ++i) store(at(blocks[i]), U8x16{});
    block_count = 0;
  }
};

/// One scan of the image. `Whole`: every block has 16 pixels to read (else the single block of a narrow region has fewer).
template <bool Whole>
class RowScan {
 public:
  RowScan(const ImageView& image, const FastOptions& options, const PixelRegion& region, Sink& sink)
      : image_(image),
        region_(region),
        threshold_(splat(options.threshold)),
        suppress_(options.suppress_non_maxima),
        sink_(sink) {
    for (std::size_t i = 0; i < circle.size(); ++i) {
      offsets_[i] = static_cast<std::ptrdiff_t>(circle[i][1]) * image.stride + circle[i][0];
    }
  }

  void run() {
    for (int v = region_.v0_px; v < region_.v1_px; ++v) {
      ScoreRow& row = row_of(v);
      row.clear();
      score_row(v, row);
      if (suppress_ && v > region_.v0_px) emit_maxima(v - 1);
    }
    if (suppress_) {
      row_of(region_.v1_px).clear();
      emit_maxima(region_.v1_px - 1);
    }
  }

 private:
  [[nodiscard]] ScoreRow& row_of(int v) { return rows_[static_cast<std::size_t>(v + 3) % 3]; }

  /// Where the block that begins at u is read: the last one is moved left to end with the region.
  [[nodiscard]] int block_start(int u) const { return Whole ? std::min(u, region_.u1_px - lanes) : u; }

  [[nodiscard, gnu::always_inline]] inline U8x16 pixels(const std::uint8_t* from) const {
    if constexpr (Whole) {
      return load<U8x16>(from);
    } else {
      U8x16 v{};
      std::memcpy(&v, from, static_cast<std::size_t>(region_.u1_px - region_.u0_px));
      return v;
    }
  }

  void score_row(int v, ScoreRow& row) {
    for (int u = region_.u0_px; u < region_.u1_px; u += lanes) {
      const int start = block_start(u);
      const std::uint8_t* centre = image_.at(start, v);
      const U8x16 p = pixels(centre);
      // An arc of 9 covers two neighbouring points of the four at 0, 90, 180, 270 degrees: one of each opposite pair.
      const U8x16 x0 = pixels(centre + offsets_[0]);
      const U8x16 x8 = pixels(centre + offsets_[8]);
      const U8x16 x4 = pixels(centre + radius);
      const U8x16 x12 = pixels(centre - radius);
      const U8x16 high = min(max(x0, x8), max(x4, x12));
      const U8x16 low = max(min(x0, x8), min(x4, x12));
      const U8x16 contrast = max(subtract_saturated(high, p), subtract_saturated(p, low));
      if (any(contrast > threshold_)) score_block(u, start, v, p, row);
    }
  }

  void score_block(int u, int start, int v, U8x16 p, ScoreRow& row) {
    const std::uint8_t* centre = image_.at(start, v);
    Ring ring;
    for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = pixels(centre + offsets_[i]);
    const U8x16 level = max(subtract_saturated(brightest_arc(ring), p), subtract_saturated(p, darkest_arc(ring)));
    const U8x16 corner = reinterpret_cast<U8x16>(level > threshold_);
    std::uint32_t bits = lane_bits(corner);
    if constexpr (!Whole) bits &= (1U << static_cast<unsigned>(region_.u1_px - region_.u0_px)) - 1U;
    if (bits == 0) return;
    U8x16 score = (level - 1) & corner;
    if constexpr (!Whole) {
      for (unsigned i = static_cast<unsigned>(region_.u1_px - region_.u0_px); i < lanes; ++i) score[i] = 0;
    }
    store(row.at(start), score);
    row.blocks[row.block_count++] = static_cast<std::uint16_t>(start);
    if (!suppress_) emit(bits, u, start, v, row);
  }

  void emit_maxima(int v) {
    ScoreRow& row = row_of(v);
    ScoreRow& above = row_of(v - 1);
    ScoreRow& below = row_of(v + 1);
    for (std::size_t i = 0; i < row.block_count; ++i) {
      const int start = row.blocks[i];
      const U8x16 score = load<U8x16>(row.at(start));
      U8x16 rival = max(load<U8x16>(row.at(start - 1)), load<U8x16>(row.at(start + 1)));
      for (int d = -1; d <= 1; ++d) {
        rival = max(rival, max(load<U8x16>(above.at(start + d)), load<U8x16>(below.at(start + d))));
      }
      const std::uint32_t bits = lane_bits(reinterpret_cast<U8x16>(score > rival));
      // The last block repeats pixels of the one before it.
      const int nominal = region_.u0_px + (start - region_.u0_px + lanes - 1) / lanes * lanes;
      emit(bits, nominal, start, v, row);
    }
  }

  void emit(std::uint32_t bits, int u, int start, int v, ScoreRow& row) {
    bits &= ~0U << static_cast<unsigned>(u - start);
    while (bits != 0) {  // bound: 16 lanes, a bit each
      const int at = start + std::countr_zero(bits);
      sink_.put(at, v, *row.at(at));
      bits &= bits - 1;
    }
  }

  const ImageView& image_;
  PixelRegion region_;
  U8x16 threshold_;
  bool suppress_;
  Sink& sink_;
  std::array<std::ptrdiff_t, 16> offsets_{};
  std::array<ScoreRow, 3> rows_{};
};

void scan(const ImageView& image, const FastOptions& options, const PixelRegion& region, Sink& sink) {
  if (region.u1_px - region.u0_px >= lanes) {
    RowScan<true>(image, options, region, sink).run();
  } else {
    RowScan<false>(image, options, region, sink).run();
  }
}

}  // namespace

FastResult detect_fast(const ImageView& image, const FastOptions& options, std::span<FastCorner> corners) {
  if (!image.is_valid()) return {Status::invalid_argument, 0, 0};
  const PixelRegion region{std::max(options.region.u0_px, radius), std::max(options.region.v0_px, radius),
                           std::min(options.region.u1_px, image.width - radius),
                           std::min(options.region.v1_px, image.height - radius)};
  if (region.u0_px >= region.u1_px || region.v0_px >= region.v1_px) return {};
  Sink sink(corners);
  scan(image, options, region, sink);
  if (!sink.overflowed()) return {Status::ok, sink.count(), sink.found()};
  sink.restart_with_strongest();
  scan(image, options, region, sink);
  return {Status::no_capacity, sink.count(), sink.found()};
}

}  // namespace relnav::vision
