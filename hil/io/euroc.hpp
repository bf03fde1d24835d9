#pragma once
#include <string>
#include <vector>

#include "hil/io/image_entry.hpp"

namespace relnav::hil {

/// `#timestamp [ns],filename` of SEQ/mav0/camN, in file order. Stamps may repeat or go back: judging that is the flight
/// loop's business. Throws InputError when there is no such file, no row, or a row that cannot be read.
[[nodiscard]] std::vector<ImageEntry> read_image_list(const std::string& camera_folder);

}  // namespace relnav::hil
