#include "hil/tool/notes.hpp"

#include <algorithm>
#include <cstdio>

namespace relnav::hil {

void print_notes(const std::vector<std::string>& notes) {
  constexpr std::size_t most_lines = 20;
  const std::size_t shown = std::min(notes.size(), most_lines);
  for (std::size_t k = 0; k < shown; ++k) std::fprintf(stderr, "relnav: %s\n", notes[k].c_str());
  if (shown < notes.size()) std::fprintf(stderr, "relnav: ... and %zu more like these\n", notes.size() - shown);
}

}  // namespace relnav::hil
