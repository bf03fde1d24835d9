#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "hil/io/raw_container_reader.hpp"

namespace relnav::hil {

struct ExportOutcome {
  std::size_t exported = 0;
  std::vector<std::string> skipped;  ///< one line each
};

/// Writes data.csv, frames.csv and data/<ns>.png into `camera_folder` (SEQ/mav0/camN), which exists. A second frame with the
/// same stamp becomes <ns>_<k>.png. Goes on until `go_on`, told how many frames are dealt with, says no; what was written is
/// a data set then, too. Throws InputError: a file cannot be written.
[[nodiscard]] ExportOutcome export_frames(const RawContainerReader& container, const std::string& camera_folder,
                                          const std::function<bool(std::size_t)>& go_on);

}  // namespace relnav::hil
