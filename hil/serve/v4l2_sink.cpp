#include "hil/serve/v4l2_sink.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

constexpr const char* a_loopback = "a device of v4l2loopback that nobody else writes to";
constexpr std::uint32_t wanted_buffers = 8;

int control(int fd, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ::ioctl(fd, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

std::string because(const std::string& what) { return what + ": " + std::strerror(errno); }

}  // namespace

V4l2Sink::V4l2Sink(std::string device, std::string trigger)
    : device_(std::move(device)), trigger_(std::move(trigger)) {}

void V4l2Sink::fail(const std::string& problem, const std::string& expected) {
  unplug();
  throw InputError(device_, 0, problem, expected);
}

void V4l2Sink::plug(const FrameShape& shape) {
  fd_ = ::open(device_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) fail(because("cannot be opened"), a_loopback);
  v4l2_capability capability{};
  if (control(fd_, VIDIOC_QUERYCAP, &capability) < 0) fail(because("is no video device"), a_loopback);
  const std::uint32_t can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_OUTPUT) == 0) fail("takes no frames", a_loopback);
  set_format(shape);
  map_buffers();
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  if (control(fd_, VIDIOC_STREAMON, &type) < 0) fail(because("does not stream"), a_loopback);
  trigger_.open();
}

void V4l2Sink::set_format(const FrameShape& shape) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  v4l2_pix_format& pixels = format.fmt.pix;
  pixels.width = shape.width_px;
  pixels.height = shape.height_px;
  pixels.pixelformat = shape.bytes_per_pixel == 2 ? V4L2_PIX_FMT_Y16 : V4L2_PIX_FMT_GREY;
  pixels.field = V4L2_FIELD_NONE;
  pixels.colorspace = V4L2_COLORSPACE_RAW;
  const v4l2_pix_format wanted = pixels;
  const std::string name = std::to_string(shape.width_px) + " x " + std::to_string(shape.height_px) +
                           (shape.bytes_per_pixel == 2 ? " Y16" : " GREY");
  frame_bytes_ = std::size_t{shape.width_px} * shape.height_px * shape.bytes_per_pixel;
  if (control(fd_, VIDIOC_S_FMT, &format) < 0) fail(because("does not take " + name), a_loopback);
  if (pixels.width != wanted.width || pixels.height != wanted.height || pixels.pixelformat != wanted.pixelformat ||
      pixels.sizeimage < frame_bytes_)
    fail("does not take " + name, "a device of v4l2loopback of this size, whose format no reader holds");
}

void V4l2Sink::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = wanted_buffers;
  request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  request.memory = V4L2_MEMORY_MMAP;
  if (control(fd_, VIDIOC_REQBUFS, &request) < 0 || request.count == 0) fail(because("gives no buffers"), a_loopback);
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer{};
    buffer.index = i;
    buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (control(fd_, VIDIOC_QUERYBUF, &buffer) < 0) fail(because("gives no buffers"), a_loopback);
    if (buffer.length < frame_bytes_) fail("gives buffers too small for a frame", a_loopback);
    void* start =
        ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, static_cast<off_t>(buffer.m.offset));
    if (start == MAP_FAILED) fail(because("gives no buffers"), a_loopback);
    mappings_.push_back({start, buffer.length, buffer.m.offset});
  }
  next_ = 0;
}

void V4l2Sink::unplug() {
  if (fd_ < 0) return;
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  (void)control(fd_, VIDIOC_STREAMOFF, &type);  // closing does as well
  for (const Mapping& mapping : mappings_) ::munmap(mapping.start, mapping.bytes);
  mappings_.clear();
  ::close(fd_);
  fd_ = -1;
  trigger_.close();
}

bool V4l2Sink::write(const ServedFrame& frame, Duration wait) {
  if (!trigger_.wait(wait)) return false;
  if (!frame.lost) send(frame);
  return true;
}

void V4l2Sink::send(const ServedFrame& frame) {
  constexpr std::int64_t us_ns = 1'000;
  constexpr std::int64_t s_us = 1'000'000;
  const std::int64_t stamp_us = frame.stamp.ns / us_ns;
  if (stamp_us <= 0) throw std::runtime_error(device_ + ": a frame's stamp is 0 or before, which V4L2 takes for none");
  if (fd_ < 0 || frame.image->bytes.size() != frame_bytes_)
    throw std::runtime_error(device_ + ": a frame of another size than said before");
  v4l2_buffer buffer{};
  buffer.index = next_;
  buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  buffer.memory = V4L2_MEMORY_MMAP;
  // A reader that wants fewer buffers takes them from both sides: which one an index means is asked each time.
  if (control(fd_, VIDIOC_QUERYBUF, &buffer) < 0) throw std::runtime_error(because(device_ + ": cannot be written to"));
  const auto mapping =
      std::find_if(mappings_.begin(), mappings_.end(), [&](const Mapping& m) { return m.offset == buffer.m.offset; });
  if (mapping == mappings_.end()) throw std::runtime_error(device_ + ": its buffers were exchanged");
  std::memcpy(mapping->start, frame.image->bytes.data(), frame_bytes_);
  buffer.bytesused = static_cast<std::uint32_t>(frame_bytes_);
  buffer.field = V4L2_FIELD_NONE;
  buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_COPY;
  buffer.timestamp.tv_sec = static_cast<decltype(buffer.timestamp.tv_sec)>(stamp_us / s_us);
  buffer.timestamp.tv_usec = static_cast<decltype(buffer.timestamp.tv_usec)>(stamp_us % s_us);
  if (control(fd_, VIDIOC_QBUF, &buffer) < 0) throw std::runtime_error(because(device_ + ": cannot be written to"));
  next_ = (next_ + 1) % static_cast<std::uint32_t>(mappings_.size());
}

}  // namespace relnav::hil
