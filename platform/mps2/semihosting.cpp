#include "platform/mps2/semihosting.hpp"

#include <array>
#include <cstring>

namespace relnav::platform::mps2 {
namespace {

enum class Operation : std::uint32_t {
  open = 0x01,
  write0 = 0x04,
  write = 0x05,
  read = 0x06,
  seek = 0x0A,
  length = 0x0C,
  command_line = 0x15,
  exit_extended = 0x20,
};
constexpr std::uint32_t application_exit = 0x20026;  // ADP_Stopped_ApplicationExit

std::int32_t call(Operation operation, const void* argument) {
  register std::uint32_t r0 asm("r0") = static_cast<std::uint32_t>(operation);
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<std::int32_t>(r0);
}

std::uint32_t word_of(const void* pointer) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(pointer));
}
std::uint32_t word_of(std::int32_t number) { return static_cast<std::uint32_t>(number); }

template <typename... Words>
std::int32_t call_with(Operation operation, Words... words) {
  const std::array<std::uint32_t, sizeof...(words)> block{words...};
  return call(operation, block.data());
}

}  // namespace

Status HostFile::open(const char* path, Access access) {
  handle_ = call_with(Operation::open, word_of(path), static_cast<std::uint32_t>(access),
                      static_cast<std::uint32_t>(std::strlen(path)));
  return is_open() ? Status::ok : Status::device_lost;
}

Status HostFile::read(std::uint32_t offset, std::span<std::uint8_t> bytes) {
  if (!is_open() || call_with(Operation::seek, word_of(handle_), offset) != 0) return Status::device_lost;
  const std::int32_t missing =
      call_with(Operation::read, word_of(handle_), word_of(bytes.data()), static_cast<std::uint32_t>(bytes.size()));
  if (missing == 0) return Status::ok;
  return missing < 0 ? Status::device_lost : Status::incomplete;
}

Status HostFile::append(std::span<const std::uint8_t> bytes) {
  if (!is_open()) return Status::io_error;
  const std::int32_t missing =
      call_with(Operation::write, word_of(handle_), word_of(bytes.data()), static_cast<std::uint32_t>(bytes.size()));
  return missing == 0 ? Status::ok : Status::io_error;
}

std::uint32_t HostFile::size() const {
  if (!is_open()) return 0;
  const std::int32_t bytes = call_with(Operation::length, word_of(handle_));
  return bytes < 0 ? 0U : static_cast<std::uint32_t>(bytes);
}

void write_console(const char* text) { static_cast<void>(call(Operation::write0, text)); }

void write_console(std::uint32_t number) {
  std::array<char, 11> text{};
  std::size_t first = text.size() - 1;  // the last one stays NUL
  do {
    text[--first] = static_cast<char>('0' + number % 10U);
    number /= 10U;
  } while (number > 0);
  write_console(&text[first]);
}

std::size_t read_command_line(std::span<char> buffer, std::span<const char*> words) {
  const std::array<std::uint32_t, 2> block{word_of(buffer.data()), static_cast<std::uint32_t>(buffer.size())};
  if (call(Operation::command_line, block.data()) != 0) return 0;
  std::size_t count = 0;
  bool in_word = false;
  for (char& c : buffer) {
    if (c == '\0') break;
    if (c == ' ') {
      c = '\0';
      in_word = false;
    } else if (!in_word) {
      if (count == words.size()) return 0;
      words[count++] = &c;
      in_word = true;
    }
  }
  return count;
}

void exit_to_host(int status) {
  static_cast<void>(call_with(Operation::exit_extended, application_exit, word_of(status)));
  while (true) {  // without a debugger: stop here
  }
}

}  // namespace relnav::platform::mps2
