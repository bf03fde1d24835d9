#include "hil/montecarlo/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "hil/io/file_handle.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

[[noreturn]] void cannot_write(const std::string& path, const std::string& unfinished) {
  const std::string why = std::strerror(errno);
  if (!unfinished.empty()) ::unlink(unfinished.c_str());
  throw InputError(path, 0, "cannot be written: " + why, "room and permission to write");
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

void write_atomically(const std::string& path, std::string_view text) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  std::string unfinished = (folder.empty() ? "." : folder) + "/" + unfinished_prefix + "XXXXXX";
  const FileHandle file(::mkostemp(unfinished.data(), O_CLOEXEC));
  if (!file.is_open()) cannot_write(path, "");
  constexpr mode_t readable_by_all = 0644;
  if (!write_all(file.get(), text) || ::fchmod(file.get(), readable_by_all) != 0 || ::fsync(file.get()) != 0 ||
      std::rename(unfinished.c_str(), path.c_str()) != 0) {
    cannot_write(path, unfinished);
  }
  const FileHandle directory(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.is_open()) static_cast<void>(::fsync(directory.get()));
}

std::optional<std::string> text_if_there(const std::string& path) {
  const FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return std::nullopt;
  std::string text;
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && status.st_size > 0) text.reserve(static_cast<std::size_t>(status.st_size));
  char buffer[65536];
  while (true) {
    const ssize_t count = ::read(file.get(), buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return std::nullopt;
    if (count == 0) return text;
    text.append(buffer, static_cast<std::size_t>(count));
  }
}

}  // namespace relnav::hil
