/// What newlib asks of the system below it, by semihosting: for the unit tests, whose framework uses the C library.
/// The flight image uses none of it but _exit().
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/types.h>
#include <unistd.h>

#include <fcntl.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>

#include "platform/mps2/semihosting.hpp"

namespace {

using relnav::Status;
using relnav::platform::mps2::HostFile;

struct OpenFile {
  HostFile file;
  std::uint32_t position = 0;
};

constexpr int first_file = 3;  // below: the console
std::array<OpenFile, 8> files;

OpenFile* file_of(int descriptor) {
  const int index = descriptor - first_file;
  if (index < 0 || static_cast<std::size_t>(index) >= files.size()) return nullptr;
  OpenFile& file = files[static_cast<std::size_t>(index)];
  return file.file.is_open() ? &file : nullptr;
}

int failed(int error) {
  errno = error;
  return -1;
}

void print(const char* text, std::size_t length) {
  std::array<char, 128> part{};
  while (length > 0) {
    const std::size_t taken = std::min(length, part.size() - 1);
    *std::copy_n(text, taken, part.begin()) = '\0';
    relnav::platform::mps2::write_console(part.data());
    text += taken;
    length -= taken;
  }
}

}  // namespace

extern "C" {

extern char __heap_start[];
extern char __heap_end[];

int _open(const char* path, int flags, int) {
  for (OpenFile& slot : files) {
    if (slot.file.is_open()) continue;
    const auto access = (flags & O_ACCMODE) == O_RDONLY ? HostFile::Access::read : HostFile::Access::write;
    if (slot.file.open(path, access) != Status::ok) return failed(ENOENT);
    slot.position = 0;
    return static_cast<int>(&slot - files.data()) + first_file;
  }
  return failed(EMFILE);
}

int _close(int descriptor) {
  OpenFile* const file = file_of(descriptor);
  if (file == nullptr) return failed(EBADF);
  *file = OpenFile();
  return 0;
}

int _read(int descriptor, char* buffer, int length) {
  OpenFile* const file = file_of(descriptor);
  if (file == nullptr) return failed(EBADF);
  const std::uint32_t left = file->file.size() - file->position;
  const std::uint32_t count = std::min(static_cast<std::uint32_t>(length), left);
  if (count == 0) return 0;
  if (file->file.read(file->position, {reinterpret_cast<std::uint8_t*>(buffer), count}) != Status::ok)
    return failed(EIO);
  file->position += count;
  return static_cast<int>(count);
}

int _write(int descriptor, const char* buffer, int length) {
  if (descriptor < first_file) {
    print(buffer, static_cast<std::size_t>(length));
    return length;
  }
  OpenFile* const file = file_of(descriptor);
  if (file == nullptr) return failed(EBADF);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(buffer), static_cast<std::size_t>(length));
  return file->file.append(bytes) == Status::ok ? length : failed(EIO);
}

off_t _lseek(int descriptor, off_t offset, int from) {
  OpenFile* const file = file_of(descriptor);
  if (file == nullptr) return failed(EBADF);
  std::uint32_t base = 0;
  if (from == SEEK_CUR) base = file->position;
  if (from == SEEK_END) base = file->file.size();
  file->position = base + static_cast<std::uint32_t>(offset);
  return static_cast<off_t>(file->position);
}

int _fstat(int descriptor, struct stat* out) {
  *out = {};
  const OpenFile* const file = file_of(descriptor);
  out->st_mode = file == nullptr ? S_IFCHR : S_IFREG;
  if (file != nullptr) out->st_size = static_cast<off_t>(file->file.size());
  return 0;
}

int _isatty(int descriptor) { return descriptor < first_file ? 1 : 0; }

void* _sbrk(std::ptrdiff_t increment) {
  static char* top = __heap_start;
  if (increment > __heap_end - top) {
    errno = ENOMEM;
    return reinterpret_cast<void*>(-1);
  }
  char* const block = top;
  top += increment;
  return block;
}

int _gettimeofday(struct timeval* now, void*) {
  *now = {};  // tests know no time
  return 0;
}

int _getpid() { return 1; }
int _kill(int, int) { return failed(EINVAL); }

[[noreturn]] void _exit(int status) { relnav::platform::mps2::exit_to_host(status); }
}
