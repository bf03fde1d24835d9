#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "fsw/base/time.hpp"
#include "hil/io/image.hpp"
#include "hil/io/raw_container_reader.hpp"

namespace relnav::hil {

/// One image: when, and where it lies.
struct ImageEntry {
  Time time;
  std::string path;                                               ///< of the image file or of the raw container
  int line = 0;                                                   ///< in data.csv
  std::shared_ptr<const RawContainerReader> container = nullptr;  ///< null: an image file
  std::size_t frame = 0;                                          ///< in `container`
  std::shared_ptr<const Image> image = nullptr;  ///< one that lies nowhere else, such as a rendered one
};

/// Throws InputError: missing or damaged.
[[nodiscard]] Image load_image(const ImageEntry& entry);
/// For messages: the file and, in a container, the frame.
[[nodiscard]] std::string place_text(const ImageEntry& entry);

}  // namespace relnav::hil
