#include "platform/mps2/trajectory_file.hpp"

#include <charconv>
#include <string_view>

namespace relnav::platform::mps2 {
namespace {

constexpr std::string_view header =
    "# t tx ty tz qx qy qz qw : pose of the target in the camera, p_C = R(q) p_T + t, s and m\n";
constexpr std::int64_t ns_per_s = 1'000'000'000;

/// A line of text under way; what does not fit makes it unusable.
class Line {
 public:
  void put(char c) {
    if (size_ < text_.size()) {
      text_[size_++] = c;
    } else {
      is_good_ = false;
    }
  }
  /// Correctly rounded, as printf does.
  void put(double value, int decimals) {
    took(std::to_chars(next(), end(), value, std::chars_format::fixed, decimals));
  }
  void put(std::int64_t value) { took(std::to_chars(next(), end(), value)); }
  [[nodiscard]] bool is_good() const { return is_good_; }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const {
    return {reinterpret_cast<const std::uint8_t*>(text_.data()), size_};
  }

 private:
  char* next() { return text_.data() + size_; }
  char* end() { return text_.data() + text_.size(); }
  void took(const std::to_chars_result& result) {
    if (result.ec != std::errc()) is_good_ = false;
    size_ = static_cast<std::size_t>(result.ptr - text_.data());
  }

  std::array<char, 512> text_{};
  std::size_t size_ = 0;
  bool is_good_ = true;
};

/// Seconds with nine decimals, exact. Flight frames have no negative stamps.
void put_seconds(Line& line, std::int64_t ns) {
  line.put(ns / ns_per_s);
  line.put('.');
  std::int64_t rest = ns % ns_per_s;
  for (std::int64_t unit = ns_per_s / 10; unit > 0; unit /= 10) {
    line.put(static_cast<char>('0' + rest / unit));
    rest %= unit;
  }
}

}  // namespace

Status TrajectoryFile::open(const char* path) {
  if (file_.open(path, HostFile::Access::write) != Status::ok) return Status::io_error;
  return file_.append({reinterpret_cast<const std::uint8_t*>(header.data()), header.size()});
}

Status TrajectoryFile::add(Time time, const std::array<double, 3>& t_CT, const std::array<double, 4>& q_CT) {
  Line line;
  put_seconds(line, time.ns);
  for (const double value : t_CT) {
    line.put(' ');
    line.put(value, 9);
  }
  for (const double value : q_CT) {
    line.put(' ');
    line.put(value, 12);
  }
  line.put('\n');
  return line.is_good() ? file_.append(line.bytes()) : Status::io_error;
}

}  // namespace relnav::platform::mps2
