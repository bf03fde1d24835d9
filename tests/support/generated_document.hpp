#pragma once
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <CppUTest/TestHarness.h>

namespace relnav::test {

/// That `made` stands between the markers of a document (a path from the root of the sources). With the variable `update` in the
/// environment it is written there.
inline void check_generated(const std::string& document, const std::string& begin_marker, const std::string& end_marker,
                            const std::string& made, const char* update) {
  const std::string path = RELNAV_SOURCE_DIR "/" + document;
  std::ifstream file(path);
  CHECK_TRUE_TEXT(file.is_open(), path.c_str());
  std::stringstream content;
  content << file.rdbuf();
  const std::string text = content.str();
  const std::size_t begin_at = text.find(begin_marker);
  const std::size_t end_at = text.find(end_marker);
  CHECK_TRUE_TEXT(begin_at != std::string::npos && end_at != std::string::npos, "no markers in the document");
  const std::size_t start = begin_at + begin_marker.size();
  if (std::getenv(update) != nullptr) {
    std::ofstream(path) << text.substr(0, start) << made << text.substr(end_at);
    return;
  }
  STRCMP_EQUAL(made.c_str(), text.substr(start, end_at - start).c_str());
}

}  // namespace relnav::test
