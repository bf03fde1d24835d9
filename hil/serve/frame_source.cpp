#include "hil/serve/frame_source.hpp"

#include "hil/io/dataset.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {

CapturedSource::CapturedSource(const std::string& images)
    : entries_(read_images(images, notes_)), kept_(entries_.size()) {
  const Image first = load_image(entries_.front());
  shape_ = {first.width_px, first.height_px, first.bytes_per_pixel};
}

std::shared_ptr<const Image> CapturedSource::image(std::size_t index) {
  constexpr std::size_t most_kept_bytes = std::size_t{1} << 30U;
  if (kept_[index]) return kept_[index];
  auto image = std::make_shared<const Image>(load_image(entries_[index]));
  if (image->width_px != shape_.width_px || image->height_px != shape_.height_px ||
      image->bytes_per_pixel != shape_.bytes_per_pixel) {
    throw InputError(
        place_text(entries_[index]), 0,
        format_text("%u x %u pixels of %u bytes", image->width_px, image->height_px, image->bytes_per_pixel),
        format_text("%u x %u of %u as the first image", shape_.width_px, shape_.height_px, shape_.bytes_per_pixel));
  }
  if (kept_bytes_ + image->bytes.size() <= most_kept_bytes) {
    kept_bytes_ += image->bytes.size();
    kept_[index] = image;
  }
  return image;
}

}  // namespace relnav::hil
