#pragma once
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace relnav::hil {

/// Text file written through to the system line by line, so that an interrupted run keeps everything.
class OutputFile {
 public:
  /// Throws InputError when it cannot be created.
  explicit OutputFile(std::string path);
  /// Throws InputError when it cannot be written (disk full).
  void write(std::string_view text);
  void line(std::string_view text) { write(std::string(text) + "\n"); }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
};

}  // namespace relnav::hil
