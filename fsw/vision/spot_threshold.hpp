#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/config.hpp"
#include "fsw/vision/image_view.hpp"
#include "fsw/vision/spot_settings.hpp"

namespace relnav::vision {

/// Levels above which a pixel may belong to a light spot, one a block of 64 x 64 pixels. From the block's own histogram
/// (256 bins over the full scale, subsampled): median + the largest of the minimum contrast, so many sigmas of noise, so
/// many spreads between the median and a higher quantile; at most half way from the median to full scale.
class SpotThreshold {
 public:
  static constexpr int block_px = 64;

  /// The region lies inside the image. A region of at most one block is sampled in full.
  void measure(const ImageView& image, const PixelRegion& region, const SpotSettings& settings);
  void measure(const ImageView16& image, const PixelRegion& region, const SpotSettings& settings);

  /// Moves every level half way to full scale.
  void raise(const SpotSettings& settings);

  /// Level of block (column, row), DN, counted from the region's corner. A pixel is bright when above it.
  [[nodiscard]] std::uint16_t level(int column, int row) const {
    return levels_[static_cast<std::size_t>(row * columns_ + column)];
  }
  [[nodiscard]] int columns() const { return columns_; }

 private:
  template <typename Pixel>
  void measure_blocks(const GreyImageView<Pixel>& image, const PixelRegion& region, const SpotSettings& settings);

  static constexpr std::size_t max_blocks =
      ((config::max_image_width + block_px - 1) / block_px) * ((config::max_image_height + block_px - 1) / block_px);
  std::array<std::uint16_t, max_blocks> levels_{};
  int columns_ = 0;
  int rows_ = 0;
};

}  // namespace relnav::vision
