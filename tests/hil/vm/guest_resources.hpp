#pragma once
#include <dirent.h>
#include <malloc.h>

#include <cstddef>
#include <fstream>
#include <string>

namespace relnav::test {

/// What a process holds that a leak would show in.
struct Resources {
  int files = 0;
  int mappings = 0;
  std::size_t heap_bytes = 0;
};

inline Resources resources() {
  Resources held;
  if (DIR* folder = ::opendir("/proc/self/fd")) {
    while (::readdir(folder) != nullptr) ++held.files;
    ::closedir(folder);
  }
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) ++held.mappings;
  held.heap_bytes = ::mallinfo2().uordblks;
  return held;
}

}  // namespace relnav::test
