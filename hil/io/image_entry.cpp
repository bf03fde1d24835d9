#include "hil/io/image_entry.hpp"

namespace relnav::hil {

Image load_image(const ImageEntry& entry) {
  if (entry.image) return *entry.image;
  return entry.container ? entry.container->image(entry.frame) : read_png(entry.path);
}

std::string place_text(const ImageEntry& entry) {
  return entry.container ? entry.container->place_text(entry.frame) : entry.path;
}

}  // namespace relnav::hil
