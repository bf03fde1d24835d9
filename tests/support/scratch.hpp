#pragma once
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

// Last, after the standard headers: CppUTest redefines operators.
#include <CppUTest/TestHarness.h>

namespace relnav::test {

/// A folder of its own, removed at the end.
class Scratch {
 public:
  Scratch() {
    std::string name = (std::filesystem::temp_directory_path() / "relnav_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    folder_ = name;
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

/// what() of the exception that `action` throws; empty when it throws none.
template <typename Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

/// The text with the first `from`, which must be there, replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) std::abort();
  return text.replace(at, from.size(), to);
}

}  // namespace relnav::test

/// The one-line message holds every piece.
#define CHECK_MESSAGE_HOLDS(message, piece)                                                                 \
  do {                                                                                                      \
    const std::string message_text = (message);                                                             \
    CHECK_TEXT(message_text.find('\n') == std::string::npos, message_text.c_str());                         \
    CHECK_TEXT(message_text.find(piece) != std::string::npos, ("message: '" + message_text + "'").c_str()); \
  } while (false)
