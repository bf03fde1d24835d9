#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

/// Files of the machine that debugs or emulates this one (Arm, "Semihosting for AArch32 and AArch64", 2.0): the stand-in for
/// camera link, radio and test console.
namespace relnav::platform::mps2 {

/// A file of the host's. Not closed by itself: every one lives until the program ends.
class HostFile {
 public:
  enum class Access : std::uint8_t { read = 1, write = 5 };  ///< "rb", "wb"

  /// device_lost: there is no such file, or it cannot be made.
  Status open(const char* path, Access access);
  [[nodiscard]] bool is_open() const { return handle_ >= 0; }
  /// All of `bytes` from `offset`. incomplete: the file ends before; device_lost: not open, or it cannot be read.
  Status read(std::uint32_t offset, std::span<std::uint8_t> bytes);
  /// At its end. io_error: not open, or only a part was taken.
  Status append(std::span<const std::uint8_t> bytes);
  /// 0 when it is not open.
  [[nodiscard]] std::uint32_t size() const;

 private:
  std::int32_t handle_ = -1;
};

/// To the host's console, unbuffered. Usable at any time, in handlers as well.
void write_console(const char* text);
void write_console(std::uint32_t number);

/// The words of the command line, NUL-terminated, in `buffer`; as many as `words` holds. 0: there is none, or it is too long.
[[nodiscard]] std::size_t read_command_line(std::span<char> buffer, std::span<const char*> words);

/// Ends the program with this status on the host.
[[noreturn]] void exit_to_host(int status);

}  // namespace relnav::platform::mps2
