#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "platform/linux/system_calls.hpp"

namespace relnav::platform::linux {

/// An open V4L2 device node: its ioctls, repeated when interrupted, and its controls.
class V4l2Node {
 public:
  struct Range {
    std::int32_t least = 0;
    std::int32_t most = 0;
  };

  explicit V4l2Node(SystemCalls& calls) : calls_(calls) {}
  ~V4l2Node() { close(); }
  V4l2Node(const V4l2Node&) = delete;
  V4l2Node& operator=(const V4l2Node&) = delete;

  /// Closes what was open. All results: negative is -errno.
  int open(const char* path);
  void close();
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  [[nodiscard]] int fd() const { return fd_; }

  template <typename Argument>
  int ioctl(unsigned long request, Argument& argument) {
    return call(request, &argument);
  }

  /// Nothing: the device does not have this control, or not now.
  [[nodiscard]] std::optional<Range> control_range(std::uint32_t id);
  [[nodiscard]] std::optional<std::int32_t> control(std::uint32_t id);
  /// For controls of 64 bits.
  [[nodiscard]] std::optional<std::int64_t> wide_control(std::uint32_t id);
  int set_control(std::uint32_t id, std::int32_t value);
  /// `name` as v4l2-ctl writes it: small letters, all else one underscore. `names`: of all controls up to that, for people.
  [[nodiscard]] std::optional<std::uint32_t> control_named(const std::string& name, std::string& names);

 private:
  int call(unsigned long request, void* argument);

  SystemCalls& calls_;
  int fd_ = -1;
};

}  // namespace relnav::platform::linux
