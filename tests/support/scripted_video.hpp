#pragma once
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "platform/host/scripted_clock.hpp"
#include "platform/linux/system_calls.hpp"

namespace relnav::test {

/// One V4L2 device at /dev/video0, played at its system calls: a camera that keeps the rules of the kernel's interface and
/// counts what its user leaves open, mapped or streaming. Waiting uses up the clock's time.
class ScriptedVideo final : public platform::linux::SystemCalls {
 public:
  struct Size {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
  };
  struct Control {
    std::int32_t value = 0;
    std::int32_t least = 0;
    std::int32_t most = 0;
    const char* name = "Nameless";
    std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
  };
  struct Image {
    std::uint8_t fill = 0;
    std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    std::uint32_t bytes_used = 0;
    std::uint32_t sequence = 0;
    std::int64_t stamp_us = 0;
  };

  explicit ScriptedVideo(platform::host::ScriptedClock& clock) : clock_(clock) {}

  // The device.
  bool present = true;  ///< false: its node is gone, and every call answers ENODEV
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_YUYV};
  std::vector<Size> sizes{{8, 4}, {16, 8}};
  std::uint32_t padding = 0;  ///< bytes after each row
  bool tells_stride = true;
  std::uint32_t field = V4L2_FIELD_NONE;
  std::vector<std::uint32_t> rates_hz{15, 30};
  std::map<std::uint32_t, Control> controls;
  std::int64_t pixel_rate_hz = 0;  ///< V4L2_CID_PIXEL_RATE; 0: does not have it
  std::uint32_t most_buffers = 32;
  std::map<unsigned long, int> answers;           ///< of an ioctl instead of doing it: -errno
  std::map<std::uint32_t, int> control_refusals;  ///< so many times a control is not set: EIO
  int open_answer = 0;                            ///< -errno
  int map_answer = 0;                             ///< -errno, from the second buffer on
  bool interrupts = false;                        ///< every second call gives EINTR
  bool has_events = true;
  bool changed = false;  ///< a source change waits
  short poll_extra = 0;  ///< revents

  // What is sent.
  std::deque<Image> waiting;
  Image image() {
    Image next;
    next.fill = static_cast<std::uint8_t>(++sent_);
    next.bytes_used = format_.fmt.pix.sizeimage;
    next.sequence = sequence_++;
    next.stamp_us = clock_.peek().ns / 1000;
    return next;
  }
  void send() { waiting.push_back(image()); }
  void skip_sequence(std::uint32_t images) { sequence_ += images; }
  void change_format(std::uint32_t width, std::uint32_t height) {
    format_.fmt.pix.width = width;
    format_.fmt.pix.height = height;
  }

  // What is left.
  [[nodiscard]] std::size_t files() const { return files_.size(); }
  [[nodiscard]] std::size_t mappings() const { return mappings_.size(); }
  [[nodiscard]] bool streaming() const { return streaming_; }
  [[nodiscard]] std::size_t queued() const { return queue_.size(); }
  [[nodiscard]] const v4l2_format& format() const { return format_; }
  [[nodiscard]] std::uint32_t rate_hz() const { return rate_hz_; }
  std::size_t mistakes = 0;  ///< what the kernel would refuse or a leak
  std::size_t opens = 0;
  std::size_t calls = 0;  ///< of ioctl()
  std::size_t polls = 0;
  std::set<unsigned long> seen;  ///< ioctls

  int open(const char* path, int flags) override {
    if (interrupted()) return -EINTR;
    if (open_answer != 0) return open_answer;
    if (std::strcmp(path, "/dev/video0") != 0 || !present) return -ENOENT;
    constexpr int expected = O_RDWR | O_NONBLOCK | O_CLOEXEC;
    if (flags != expected) ++mistakes;
    ++opens;
    files_.insert(next_file_);
    return next_file_++;
  }
  int close(int fd) override {
    if (files_.erase(fd) == 0) ++mistakes;
    if (!mappings_.empty() || (present && streaming_)) ++mistakes;
    reset_stream();
    return 0;
  }
  int poll(pollfd& file, Duration wait) override {
    ++polls;
    if (interrupted()) return -EINTR;
    if (files_.count(file.fd) == 0) ++mistakes;
    file.revents = poll_extra;
    if (!present) file.revents |= POLLERR | POLLHUP;
    if (changed) file.revents |= POLLPRI;
    if (!waiting.empty() && !queue_.empty()) file.revents |= POLLIN;
    if (file.revents != 0) return 1;
    clock_.advance(wait);
    return 0;
  }
  void* map(std::size_t bytes, int fd, std::int64_t offset, int& error) override {
    const auto index = static_cast<std::size_t>(offset / page);
    error = files_.count(fd) == 0 || index >= memory_.size() ? -EINVAL : (index > 0 ? map_answer : 0);
    if (error != 0) return nullptr;
    if (bytes != format_.fmt.pix.sizeimage) ++mistakes;
    void* const address = memory_[index].get();
    mappings_.insert(address);
    return address;
  }
  int unmap(void* address, std::size_t bytes) override {
    if (mappings_.erase(address) == 0 || bytes == 0) ++mistakes;
    return 0;
  }
  int ioctl(int fd, unsigned long request, void* argument) override {
    ++calls;
    if (interrupted()) return -EINTR;
    if (files_.count(fd) == 0) {
      ++mistakes;
      return -EBADF;
    }
    if (!present) return -ENODEV;
    seen.insert(request);
    if (const auto answer = answers.find(request); answer != answers.end()) return answer->second;
    switch (request) {
      case VIDIOC_QUERYCAP: return query_capabilities(*static_cast<v4l2_capability*>(argument));
      case VIDIOC_ENUM_FMT: return enumerate(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_G_FMT: *static_cast<v4l2_format*>(argument) = format_; return 0;
      case VIDIOC_S_FMT: return set_format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_G_PARM: return get_rate(*static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_S_PARM: return set_rate(*static_cast<v4l2_streamparm*>(argument));
      case VIDIOC_QUERYCTRL: return query_control(*static_cast<v4l2_queryctrl*>(argument));
      case VIDIOC_G_CTRL: return control(*static_cast<v4l2_control*>(argument), false);
      case VIDIOC_S_CTRL: return control(*static_cast<v4l2_control*>(argument), true);
      case VIDIOC_G_EXT_CTRLS: return wide_control(*static_cast<v4l2_ext_controls*>(argument));
      case VIDIOC_REQBUFS: return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
      case VIDIOC_QUERYBUF: return query_buffer(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_QBUF: return enqueue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_DQBUF: return dequeue(*static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON: return start();
      case VIDIOC_STREAMOFF: streaming_ = false; return 0;
      case VIDIOC_SUBSCRIBE_EVENT: return has_events ? 0 : -ENOTTY;
      case VIDIOC_DQEVENT: return take_event(*static_cast<v4l2_event*>(argument));
      default: ++mistakes; return -ENOTTY;
    }
  }

 private:
  static constexpr std::int64_t page = 4096;

  bool interrupted() {
    interrupt_next_ = !interrupt_next_;
    return interrupts && interrupt_next_;
  }
  void reset_stream() {
    streaming_ = false;
    queue_.clear();
    memory_.clear();
    waiting.clear();
    sequence_ = 0;
  }
  int query_capabilities(v4l2_capability& about) const {
    about.capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;  // of all nodes together
    about.device_caps = capabilities;
    return 0;
  }
  int enumerate(v4l2_fmtdesc& description) const {
    if (description.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || description.index >= formats.size()) return -EINVAL;
    description.pixelformat = formats[description.index];
    return 0;
  }
  int set_format(v4l2_format& wanted) {
    if (!memory_.empty()) return -EBUSY;
    v4l2_pix_format& pixels = wanted.fmt.pix;
    if (std::find(formats.begin(), formats.end(), pixels.pixelformat) == formats.end()) pixels.pixelformat = formats[0];
    const bool has_size = std::any_of(sizes.begin(), sizes.end(), [&](const Size& size) {
      return size.width == pixels.width && size.height == pixels.height;
    });
    if (!has_size) {
      pixels.width = sizes[0].width;
      pixels.height = sizes[0].height;
    }
    const bool wide = pixels.pixelformat != V4L2_PIX_FMT_GREY && pixels.pixelformat != V4L2_PIX_FMT_SRGGB8;
    const std::uint32_t stride = pixels.width * (wide ? 2 : 1) + padding;
    pixels.bytesperline = tells_stride ? stride : 0;
    pixels.sizeimage = stride * pixels.height;
    pixels.field = field;
    format_ = wanted;
    return 0;
  }
  int get_rate(v4l2_streamparm& parameters) const {
    parameters.parm.capture.capability = rates_hz.empty() ? 0 : V4L2_CAP_TIMEPERFRAME;
    parameters.parm.capture.timeperframe = {.numerator = 1, .denominator = rate_hz_};
    return 0;
  }
  int set_rate(v4l2_streamparm& parameters) {
    v4l2_fract& period = parameters.parm.capture.timeperframe;
    const std::uint32_t wanted = period.denominator / period.numerator;
    rate_hz_ = std::find(rates_hz.begin(), rates_hz.end(), wanted) == rates_hz.end() ? rates_hz.back() : wanted;
    period = {.numerator = 1, .denominator = rate_hz_};
    return 0;
  }
  int query_control(v4l2_queryctrl& query) const {
    const bool next = (query.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
    const auto found = next ? controls.upper_bound(query.id & ~static_cast<std::uint32_t>(V4L2_CTRL_FLAG_NEXT_CTRL))
                            : controls.find(query.id);
    if (found == controls.end()) return -EINVAL;
    query.id = found->first;
    query.type = found->second.type;
    std::memcpy(query.name, found->second.name, std::min(std::strlen(found->second.name) + 1, sizeof query.name));
    query.minimum = found->second.least;
    query.maximum = found->second.most;
    return 0;
  }
  int control(v4l2_control& request, bool set) {
    const auto found = controls.find(request.id);
    if (found == controls.end()) return -EINVAL;
    if (set) {
      if (int& refusals = control_refusals[request.id]; refusals > 0) {
        --refusals;
        return -EIO;
      }
      if (request.value < found->second.least || request.value > found->second.most) return -ERANGE;
      found->second.value = request.value;
    }
    request.value = found->second.value;
    return 0;
  }
  int wide_control(v4l2_ext_controls& request) const {
    if (request.count != 1 || request.controls[0].id != V4L2_CID_PIXEL_RATE || pixel_rate_hz == 0) return -EINVAL;
    request.controls[0].value64 = pixel_rate_hz;
    return 0;
  }
  int request_buffers(v4l2_requestbuffers& request) {
    if (streaming_) return -EBUSY;
    if (request.count == 0) {
      memory_.clear();
      queue_.clear();
      return 0;
    }
    request.count = std::min(request.count, most_buffers);
    memory_.clear();
    for (std::uint32_t index = 0; index < request.count; ++index) {
      memory_.push_back(std::make_unique<std::uint8_t[]>(format_.fmt.pix.sizeimage));
    }
    return 0;
  }
  int query_buffer(v4l2_buffer& buffer) const {
    if (buffer.index >= memory_.size()) return -EINVAL;
    buffer.length = format_.fmt.pix.sizeimage;
    buffer.m.offset = static_cast<std::uint32_t>(buffer.index * page);
    return 0;
  }
  int enqueue(v4l2_buffer& buffer) {
    if (buffer.index >= memory_.size()) return -EINVAL;
    if (std::find(queue_.begin(), queue_.end(), buffer.index) != queue_.end()) {
      ++mistakes;
      return -EINVAL;
    }
    queue_.push_back(buffer.index);
    return 0;
  }
  int dequeue(v4l2_buffer& buffer) {
    if (!streaming_) return -EINVAL;
    if (waiting.empty() || queue_.empty()) return -EAGAIN;
    const Image next = waiting.front();
    waiting.pop_front();
    buffer.index = queue_.front();
    queue_.pop_front();
    std::memset(memory_[buffer.index].get(), next.fill, format_.fmt.pix.sizeimage);
    buffer.flags = next.flags;
    buffer.bytesused = next.bytes_used;
    buffer.sequence = next.sequence;
    buffer.timestamp.tv_sec = static_cast<decltype(buffer.timestamp.tv_sec)>(next.stamp_us / 1'000'000);
    buffer.timestamp.tv_usec = static_cast<decltype(buffer.timestamp.tv_usec)>(next.stamp_us % 1'000'000);
    return 0;
  }
  int start() {
    if (queue_.empty()) return -EINVAL;
    streaming_ = true;
    sequence_ = 0;
    return 0;
  }
  int take_event(v4l2_event& event) {
    if (!changed) return -ENOENT;
    changed = false;
    event.type = V4L2_EVENT_SOURCE_CHANGE;
    return 0;
  }

  platform::host::ScriptedClock& clock_;
  std::set<int> files_;
  int next_file_ = 100;
  std::set<void*> mappings_;
  v4l2_format format_{};
  std::uint32_t rate_hz_ = 30;
  std::vector<std::unique_ptr<std::uint8_t[]>> memory_;
  std::deque<std::uint32_t> queue_;
  bool streaming_ = false;
  bool interrupt_next_ = false;
  std::uint32_t sequence_ = 0;
  std::uint32_t sent_ = 0;
};

}  // namespace relnav::test
