#pragma once
#include "hil/io/image.hpp"

namespace relnav::hil {

/// Every byte the same: black (0x00) and white (0xFF) frames.
void fill(Image& image, std::uint8_t value);

/// The lower half becomes that of an image of the same size and depth.
void tear(Image& image, const Image& lower);

}  // namespace relnav::hil
