#include "hil/serve/frame_source.hpp"

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {

EurocSource::EurocSource(const std::string& camera_folder)
    : entries_(read_image_list(camera_folder)), kept_(entries_.size()) {
  const Image first = read_png(entries_.front().path);
  shape_ = {first.width_px, first.height_px, first.bytes_per_pixel};
}

std::shared_ptr<const Image> EurocSource::image(std::size_t index) {
  constexpr std::size_t most_kept_bytes = std::size_t{1} << 30U;
  if (kept_[index]) return kept_[index];
  auto image = std::make_shared<const Image>(read_png(entries_[index].path));
  if (image->width_px != shape_.width_px || image->height_px != shape_.height_px ||
      image->bytes_per_pixel != shape_.bytes_per_pixel) {
    throw InputError(
        entries_[index].path, 0,
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
