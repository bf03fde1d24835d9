#pragma once
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstring>

namespace relnav::test {

/// Vivid's own controls, with which it does what cameras do wrong; by the name that `v4l2-ctl -L` shows. False: no such control.
inline bool set_vivid(const char* device, const char* name, int value) {
  const int fd = ::open(device, O_RDWR | O_CLOEXEC);
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  bool set = false;
  while (fd >= 0 && ::ioctl(fd, VIDIOC_QUERYCTRL, &query) == 0) {
    if (std::strcmp(reinterpret_cast<const char*>(query.name), name) == 0) {
      v4l2_control control{};
      control.id = query.id;
      control.value = value;
      set = ::ioctl(fd, VIDIOC_S_CTRL, &control) == 0;
      break;
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  if (fd >= 0) ::close(fd);
  return set;
}

}  // namespace relnav::test
