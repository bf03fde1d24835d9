#include "fsw/vision/spot_threshold.hpp"

#include <algorithm>
#include <cmath>

namespace relnav::vision {
namespace {

constexpr int bins = 256;
constexpr int whole_step_px = 4;
// A spot may cover a good part of a small window, but hardly a tenth of a block of the whole image.
constexpr double window_quantile = 0.75;
constexpr double whole_quantile = 0.9;

using Histogram = std::array<std::uint16_t, bins>;

int quantile(const Histogram& histogram, int count, double fraction) {
  const int wanted = static_cast<int>(fraction * count);
  int below = 0;
  for (int bin = 0; bin < bins; ++bin) {
    below += histogram[static_cast<std::size_t>(bin)];
    if (below > wanted) return bin;
  }
  return bins - 1;
}

std::uint16_t threshold(const Histogram& histogram, int count, double upper, const SpotSettings& settings) {
  const double bin_dn = (settings.full_scale_dn + 1.0) / bins;
  const double median = quantile(histogram, count, 0.5) * bin_dn;
  const double spread = quantile(histogram, count, upper) * bin_dn - median;
  const double noise = std::sqrt(settings.read_noise_dn * settings.read_noise_dn + median / settings.gain_electrons_dn);
  const double contrast = std::max({settings.min_contrast * settings.full_scale_dn, settings.noise_factor * noise,
                                    settings.clutter_factor * spread});
  const double level = std::min(median + contrast, 0.5 * (median + settings.full_scale_dn));
  // A saturated pixel is always above.
  return static_cast<std::uint16_t>(std::clamp(level, 0.0, settings.full_scale_dn - 1.0));
}

}  // namespace

template <typename Pixel>
void SpotThreshold::measure_blocks(const GreyImageView<Pixel>& image, const PixelRegion& region,
                                   const SpotSettings& settings) {
  const int width = region.u1_px - region.u0_px;
  const int height = region.v1_px - region.v0_px;
  const bool window = width <= block_px && height <= block_px;
  const int step = window ? 1 : whole_step_px;
  const auto scale_q16 = static_cast<std::uint64_t>(bins * 65536.0 / (settings.full_scale_dn + 1.0));
  columns_ = (width + block_px - 1) / block_px;
  rows_ = (height + block_px - 1) / block_px;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      // The last block of a row or column is moved back to be a full one.
      const int u0 = region.u0_px + std::max(0, std::min(column * block_px, width - block_px));
      const int v0 = region.v0_px + std::max(0, std::min(row * block_px, height - block_px));
      const int u1 = std::min(u0 + block_px, region.u1_px);
      const int v1 = std::min(v0 + block_px, region.v1_px);
      Histogram histogram{};
      int count = 0;
      for (int v = v0; v < v1; v += step) {
        const Pixel* line = image.at(0, v);
        for (int u = u0; u < u1; u += step) {
          const std::uint64_t bin = std::min<std::uint64_t>((line[u] * scale_q16) >> 16U, bins - 1);
          ++histogram[static_cast<std::size_t>(bin)];
          ++count;
        }
      }
      levels_[static_cast<std::size_t>(row * columns_ + column)] =
          threshold(histogram, count, window ? window_quantile : whole_quantile, settings);
    }
  }
}

void SpotThreshold::raise(const SpotSettings& settings) {
  for (int i = 0; i < rows_ * columns_; ++i) {
    std::uint16_t& level = levels_[static_cast<std::size_t>(i)];
    level = static_cast<std::uint16_t>(
        std::min(0.5 * (static_cast<double>(level) + settings.full_scale_dn), settings.full_scale_dn - 1.0));
  }
}

void SpotThreshold::measure(const ImageView& image, const PixelRegion& region, const SpotSettings& settings) {
  measure_blocks(image, region, settings);
}
void SpotThreshold::measure(const ImageView16& image, const PixelRegion& region, const SpotSettings& settings) {
  measure_blocks(image, region, settings);
}

}  // namespace relnav::vision
