#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace relnav::hil {

/// Names of files that are being written begin with this.
inline constexpr const char* unfinished_prefix = ".relnav-";

/// Replaces `path` as a whole: written under another name in the same folder, flushed to the disk, renamed. Whoever is killed
/// or loses power in between leaves the old file. Throws InputError.
void write_atomically(const std::string& path, std::string_view text);

/// The whole file, or nothing when it cannot be read.
[[nodiscard]] std::optional<std::string> text_if_there(const std::string& path);

}  // namespace relnav::hil
