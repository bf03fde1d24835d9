#include "platform/linux/v4l2_node.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>

#include <cctype>
#include <cerrno>
#include <cstddef>

namespace relnav::platform::linux {
namespace {

constexpr int most_controls = 1024;  // of a driver that never stops listing them

template <std::size_t size>
std::string as_written(const __u8 (&name)[size]) {
  std::string text;
  bool gap = false;
  for (std::size_t i = 0; i < size && name[i] != 0; ++i) {
    if (std::isalnum(name[i]) == 0) {
      gap = true;
      continue;
    }
    if (gap && !text.empty()) text += '_';
    gap = false;
    text += static_cast<char>(std::tolower(name[i]));
  }
  return text;
}

}  // namespace

int V4l2Node::open(const char* path) {
  close();
  int result = 0;
  do {
    result = calls_.open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  } while (result == -EINTR);
  if (result >= 0) fd_ = result;
  return result;
}

void V4l2Node::close() {
  if (fd_ < 0) return;
  static_cast<void>(calls_.close(fd_));  // even when interrupted the descriptor is gone
  fd_ = -1;
}

int V4l2Node::call(unsigned long request, void* argument) {
  int result = 0;
  do {
    result = calls_.ioctl(fd_, request, argument);
  } while (result == -EINTR);
  return result;
}

std::optional<V4l2Node::Range> V4l2Node::control_range(std::uint32_t id) {
  v4l2_queryctrl query{};
  query.id = id;
  if (ioctl(VIDIOC_QUERYCTRL, query) < 0 || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) return std::nullopt;
  return Range{.least = query.minimum, .most = query.maximum};
}

std::optional<std::int32_t> V4l2Node::control(std::uint32_t id) {
  v4l2_control control{.id = id, .value = 0};
  if (ioctl(VIDIOC_G_CTRL, control) < 0) return std::nullopt;
  return control.value;
}

std::optional<std::int64_t> V4l2Node::wide_control(std::uint32_t id) {
  v4l2_ext_control control{};
  control.id = id;
  v4l2_ext_controls controls{};
  controls.which = V4L2_CTRL_WHICH_CUR_VAL;
  controls.count = 1;
  controls.controls = &control;
  if (ioctl(VIDIOC_G_EXT_CTRLS, controls) < 0) return std::nullopt;
  return std::int64_t{control.value64};  // a copy: the struct is packed
}

int V4l2Node::set_control(std::uint32_t id, std::int32_t value) {
  v4l2_control control{.id = id, .value = value};
  return ioctl(VIDIOC_S_CTRL, control);
}

std::optional<std::uint32_t> V4l2Node::control_named(const std::string& name, std::string& names) {
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (int k = 0; k < most_controls && ioctl(VIDIOC_QUERYCTRL, query) >= 0; ++k) {
    const bool is_title = query.type == V4L2_CTRL_TYPE_CTRL_CLASS || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0;
    const std::string found = as_written(query.name);
    if (!is_title && found == name) return query.id;
    if (!is_title) names += (names.empty() ? "" : ", ") + found;
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return std::nullopt;
}

}  // namespace relnav::platform::linux
