#include "hil/io/euroc.hpp"

#include <filesystem>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {

std::vector<ImageEntry> read_image_list(const std::string& camera_folder) {
  const std::filesystem::path folder(camera_folder);
  const std::string list = (folder / "data.csv").string();
  std::vector<ImageEntry> entries;
  int number = 0;
  for (const std::string& line : read_lines(list)) {
    ++number;
    const std::string_view text = trimmed(line);
    if (text.empty() || text.front() == '#') continue;
    const auto parts = split(text, ',');
    if (parts.size() != 2) {
      throw InputError(list, number, std::to_string(parts.size()) + (parts.size() == 1 ? " column" : " columns"),
                       "2: timestamp in ns and file name");
    }
    const auto ns = parse_int64(parts[0]);
    if (!ns || *ns < 0)
      throw InputError(list, number, "timestamp " + in_quotes(parts[0]), "non-negative integer nanoseconds");
    if (parts[1].empty()) throw InputError(list, number, "empty file name", "the name of an image in data/");
    entries.push_back({Time{*ns}, (folder / "data" / std::string(parts[1])).string(), number});
  }
  if (entries.empty()) throw InputError(list, 0, "lists no image", "at least one row 'timestamp [ns],filename'");
  return entries;
}

}  // namespace relnav::hil
