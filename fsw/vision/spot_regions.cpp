#include "fsw/vision/spot_regions.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "fsw/vision/vector16.hpp"

namespace relnav::vision {
namespace {

constexpr int max_levels = 7;
constexpr int max_raises = 3;
constexpr double level_step = 0.35;  // of the way to the peak
constexpr double prominence = 0.25;  // of the height above the first threshold
constexpr double final_level = 0.3;  // of the peak: a region above less is looked at again, though it pass the gate
constexpr std::uint16_t no_region = std::numeric_limits<std::uint16_t>::max();

using U16x8 = std::uint16_t __attribute__((vector_size(16)));

/// Bit i: pixel i of 16 is above the level.
inline std::uint32_t bright_bits(const std::uint8_t* pixels, std::uint16_t level) {
  return lane_bits(static_cast<U8x16>(load<U8x16>(pixels) > splat(static_cast<std::uint8_t>(level))));
}
inline std::uint32_t bright_bits(const std::uint16_t* pixels, std::uint16_t level) {
  const U16x8 limit = U16x8{} + level;
  const auto low = load<U16x8>(pixels) > limit;
  const auto high = load<U16x8>(pixels + 8) > limit;
  U8x16 bytes{};
  const auto a = reinterpret_cast<U8x16>(low);
  const auto b = reinterpret_cast<U8x16>(high);
  bytes = __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  return lane_bits(bytes);
}
template <typename Pixel>
std::uint32_t bright_bits(const Pixel* pixels, std::uint16_t level, int count) {
  if (count >= 16) return bright_bits(pixels, level);
  std::uint32_t bits = 0;
  for (int i = 0; i < count; ++i) bits |= static_cast<std::uint32_t>(pixels[i] > level) << i;
  return bits;
}

/// Elongation, fill and path of a region from its second moments.
struct Shape {
  double elongation = 1.0;
  double fill = 1.0;
  Vec2 half_streak_px = Vec2::Zero();
};
Shape shape_of(double area, double uu, double uv, double vv) {
  const double mean = 0.5 * (uu + vv);
  const double half = 0.5 * (uu - vv);
  const double root = std::sqrt(half * half + uv * uv);
  const double determinant = std::max(uu * vv - uv * uv, 1e-3);
  // A quarter of a square pixel on both axes: whether a tiny spot covers one pixel more is chance.
  constexpr double softening = 0.25;
  Shape shape;
  shape.elongation = std::sqrt((mean + root + softening) / (std::max(mean - root, 0.0) + softening));
  shape.fill = area / (4.0 * pi * std::sqrt(determinant));
  if (root > 0.0) {
    // A uniform path of half length L adds L^2 / 3 to the variance along it.
    const Vec2 axis = uu >= vv ? Vec2(half + root, uv) : Vec2(uv, root - half);
    shape.half_streak_px = axis * (std::sqrt(6.0 * root) / axis.norm());
  }
  return shape;
}

}  // namespace

void SpotCandidates::put(const SpotCandidate& candidate) {
  ++found_;
  if (kept_.full()) {
    if (!(candidate.flux_dn > kept_[kept_.size() - 1].flux_dn)) return;
    kept_.pop_back();
  }
  if (kept_.push_back(candidate) != Status::ok) return;
  for (std::size_t i = kept_.size() - 1; i > 0 && kept_[i].flux_dn > kept_[i - 1].flux_dn; --i) {
    std::swap(kept_[i], kept_[i - 1]);
  }
}

template <typename Pixel>
std::int32_t SpotRegions::scan(const GreyImageView<Pixel>& image, const PixelRegion& region,
                               const SpotThreshold& threshold) {
  Runs& runs = tables_[current_];
  runs.clear();
  std::int32_t dropped = 0;
  constexpr int lanes = 16;
  for (int v = region.v0_px; v < region.v1_px; ++v) {
    const Pixel* line = image.at(0, v);
    const int row = (v - region.v0_px) / SpotThreshold::block_px;
    Run run;
    bool open = false;
    const auto close = [&](int u) {
      run.u1_px = static_cast<std::uint16_t>(u);
      if (runs.push_back(run) != Status::ok) ++dropped;
      open = false;
    };
    for (int u = region.u0_px; u < region.u1_px; u += lanes) {
      const std::uint16_t level = threshold.level((u - region.u0_px) / SpotThreshold::block_px, row);
      std::uint32_t bits = bright_bits(line + u, level, region.u1_px - u);
      // Every turn takes one edge of a run off: bits below the edge are made equal to what is open.
      if (open) bits = ~bits & 0xFFFFU;
      int from = 0;
      while (bits != 0 && from < lanes) {  // bound: 16 lanes, an edge each
        from = std::countr_zero(bits);
        if (open) {
          close(u + from);
        } else {
          run.u0_px = static_cast<std::uint16_t>(u + from);
          run.v_px = static_cast<std::uint16_t>(v);
          run.level_dn = level;
          run.first_level_dn = level;
          open = true;
        }
        bits = ~bits & 0xFFFFU & (0xFFFFU << static_cast<unsigned>(from));
      }
    }
    if (open) close(region.u1_px);
  }
  return dropped;
}

std::uint16_t SpotRegions::root_of(std::uint16_t run) {
  Runs& runs = tables_[current_];
  while (runs[run].parent != run) {  // bound: the runs; a parent never comes after its run
    runs[run].parent = runs[runs[run].parent].parent;
    run = runs[run].parent;
  }
  return run;
}

void SpotRegions::join(std::uint16_t a, std::uint16_t b) {
  const std::uint16_t root_a = root_of(a);
  const std::uint16_t root_b = root_of(b);
  tables_[current_][std::max(root_a, root_b)].parent = std::min(root_a, root_b);
}

void SpotRegions::connect() {
  Runs& runs = tables_[current_];
  std::size_t above = 0;      // run of the row above that may still touch
  std::size_t row_start = 0;  // first run of this row
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Run& run = runs[i];
    run.parent = static_cast<std::uint16_t>(i);
    if (i > 0 && run.v_px != runs[i - 1].v_px) {
      above = run.v_px == runs[i - 1].v_px + 1 ? row_start : i;
      row_start = i;
    }
    // bound: the runs of the row above, over all runs of a row
    while (above < row_start && runs[above].u1_px < run.u0_px) ++above;
    // The last run that touches may touch the next of this row as well.
    for (std::size_t j = above; j < row_start && runs[j].u0_px <= run.u1_px; ++j) {
      join(static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j));
      above = j;
    }
  }
}

template <typename Pixel>
void SpotRegions::measure(const GreyImageView<Pixel>& image, const SpotSettings& settings, RegionCounts& counts) {
  Runs& runs = tables_[current_];
  regions_.clear();
  const auto full_scale = static_cast<std::uint16_t>(settings.full_scale_dn);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Run& run = runs[i];
    if (run.parent == i) {
      run.parent = static_cast<std::uint16_t>(regions_.size());
      Region region;
      region.u0_px = run.u0_px;
      region.v0_px = run.v_px;
      if (regions_.push_back(region) != Status::ok) {
        run.parent = no_region;
        ++counts.dropped_regions;
      }
    } else {
      run.parent = runs[run.parent].parent;  // the runs before already hold their region
    }
    if (run.parent == no_region) continue;
    Region& region = regions_[run.parent];
    region.level_dn = std::max(region.level_dn, run.level_dn);
    region.first_level_dn = std::max(region.first_level_dn, run.first_level_dn);
    const Pixel* line = image.at(0, run.v_px);
    std::int64_t flux = 0;
    std::int64_t flux_u = 0;
    for (int u = run.u0_px; u < run.u1_px; ++u) {
      const auto level = static_cast<std::uint16_t>(line[u]);
      const std::int64_t above = level - run.level_dn;
      flux += above;
      flux_u += above * (u - region.u0_px);
      region.peak_dn = std::max(region.peak_dn, level);
      region.saturated += level >= full_scale ? 1 : 0;
    }
    const double n = run.u1_px - run.u0_px;
    const double middle = 0.5 * (run.u0_px + run.u1_px - 1) - region.u0_px;
    const double v = run.v_px - region.v0_px;
    region.area += run.u1_px - run.u0_px;
    region.flux += static_cast<double>(flux);
    region.flux_u += static_cast<double>(flux_u);
    region.total += static_cast<double>(flux) + n * (run.level_dn - run.first_level_dn);
    region.flux_v += static_cast<double>(flux) * v;
    region.u += n * middle;
    region.v += n * v;
    region.uu += n * (middle * middle + n * n / 12.0);  // each pixel a square: its own variance is 1/12
    region.uv += n * middle * v;
    region.vv += n * (v * v + 1.0 / 12.0);
  }
}

bool SpotRegions::judge(const PixelRegion& core, const SpotSettings& settings, bool last, SpotCandidates& candidates,
                        RegionCounts& counts) {
  bool again = false;
  for (Region& region : regions_) {
    const double n = region.area;
    const double u = region.u / n;
    const double v = region.v / n;
    const Shape shape = shape_of(n, region.uu / n - u * u, region.uv / n - u * v, region.vv / n - v * v);
    const bool small = region.area < settings.min_area_px;
    const bool good = !small && region.area <= settings.max_area_px && shape.elongation <= settings.max_elongation &&
                      shape.fill >= settings.min_fill;
    // What stands out of its surroundings by less is their texture. How far a saturated one does is not known.
    const bool stands_out = region.saturated > 0 ||
                            region.peak_dn - region.level_dn >= prominence * (region.peak_dn - region.first_level_dn);
    const double next = region.level_dn + level_step * (region.peak_dn - region.level_dn);
    const bool room = stands_out && next >= region.level_dn + 1.0 && !small && !last;
    if (good && stands_out && (region.level_dn >= final_level * region.peak_dn || !room)) {
      SpotCandidate candidate;
      candidate.uv_px = Vec2(region.u0_px + region.flux_u / region.flux, region.v0_px + region.flux_v / region.flux);
      candidate.half_streak_px = shape.half_streak_px;
      candidate.flux_dn = region.total;
      candidate.peak_dn = region.peak_dn;
      candidate.area_px = region.area;
      candidate.saturated_px = region.saturated;
      if (core.holds(candidate.uv_px(0), candidate.uv_px(1))) candidates.put(candidate);
    } else if (room) {
      region.next_level_dn = static_cast<std::uint16_t>(next);
      again = true;
    } else {
      ++counts.rejected;
    }
  }
  return again;
}

template <typename Pixel>
void SpotRegions::split(const GreyImageView<Pixel>& image, RegionCounts& counts) {
  const Runs& from = tables_[current_];
  Runs& to = tables_[1 - current_];
  to.clear();
  for (const Run& run : from) {
    const std::uint16_t level = run.parent == no_region ? std::uint16_t{0} : regions_[run.parent].next_level_dn;
    if (level == 0) continue;
    const Pixel* line = image.at(0, run.v_px);
    Run part{0, 0, run.v_px, level, run.first_level_dn, 0};
    bool open = false;
    for (int u = run.u0_px; u <= run.u1_px; ++u) {
      const bool bright = u < run.u1_px && line[u] > level;
      if (bright && !open) part.u0_px = static_cast<std::uint16_t>(u);
      if (!bright && open) {
        part.u1_px = static_cast<std::uint16_t>(u);
        if (to.push_back(part) != Status::ok) ++counts.dropped_runs;
      }
      open = bright;
    }
  }
  current_ = 1 - current_;
}

template <typename Pixel>
void SpotRegions::search(const GreyImageView<Pixel>& image, const PixelRegion& region, const PixelRegion& core,
                         const SpotSettings& settings, SpotThreshold& threshold, SpotCandidates& candidates,
                         RegionCounts& counts) {
  std::int32_t dropped = scan(image, region, threshold);
  for (int i = 0; i < max_raises && dropped > 0; ++i) {
    threshold.raise(settings);
    ++counts.raised;
    dropped = scan(image, region, threshold);
  }
  counts.dropped_runs += dropped;
  for (int level = 0; level < max_levels; ++level) {
    connect();
    measure(image, settings, counts);
    if (!judge(core, settings, level + 1 == max_levels, candidates, counts)) return;
    split(image, counts);
  }
}

void SpotRegions::find(const ImageView& image, const PixelRegion& region, const PixelRegion& core,
                       const SpotSettings& settings, SpotThreshold& threshold, SpotCandidates& candidates,
                       RegionCounts& counts) {
  search(image, region, core, settings, threshold, candidates, counts);
}
void SpotRegions::find(const ImageView16& image, const PixelRegion& region, const PixelRegion& core,
                       const SpotSettings& settings, SpotThreshold& threshold, SpotCandidates& candidates,
                       RegionCounts& counts) {
  search(image, region, core, settings, threshold, candidates, counts);
}

}  // namespace relnav::vision
