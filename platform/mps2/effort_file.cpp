#include "platform/mps2/effort_file.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

namespace relnav::platform::mps2 {
namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

Status EffortFile::open(const char* path) {
  if (file_.open(path, HostFile::Access::write) != Status::ok) return Status::io_error;
  return file_.append(bytes_of("work,transfer\n"));
}

void EffortFile::add(std::int64_t work, std::int64_t transfer) {
  std::array<char, 48> line{};
  char* const end = line.data() + line.size();
  char* next = std::to_chars(line.data(), end, work).ptr;
  *next++ = ',';
  next = std::to_chars(next, end, transfer).ptr;
  *next++ = '\n';
  static_cast<void>(file_.append(bytes_of({line.data(), static_cast<std::size_t>(next - line.data())})));
  if (count_ == works_.size()) return;
  constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
  works_[count_++] = static_cast<std::uint32_t>(std::min(work, most));
}

Effort EffortFile::summary() {
  if (count_ == 0) return {};
  const auto begin = works_.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(count_);
  const auto middle = begin + static_cast<std::ptrdiff_t>(count_ / 2);
  std::nth_element(begin, middle, end);
  return {static_cast<std::uint32_t>(count_), *middle, *std::max_element(middle, end)};
}

}  // namespace relnav::platform::mps2
