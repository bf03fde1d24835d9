#include "platform/linux/v4l2_driver.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "platform/linux/pixel_conversion.hpp"

namespace relnav::platform::linux {
namespace {

constexpr std::uint32_t capture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
constexpr std::uint32_t most_formats = 256;  // of a driver that never stops listing them
constexpr std::uint32_t kept_by_device = 2;  // buffers that a camera needs to go on while the others are on loan
constexpr int most_wakeups = 16;             // for nothing, in one take()
constexpr double rate_tolerance = 0.01;

Status status_of(int error) {
  switch (-error) {
    case ENOENT:
    case ENODEV:
    case ENXIO: return Status::no_data;
    case EBUSY:
    case ENOMEM:
    case ENOSPC:
    case EMFILE:
    case ENFILE: return Status::no_capacity;
    case ENOTTY:
    case EINVAL:
    case EISDIR:
    case ENOTDIR: return Status::unsupported;
    default: return Status::io_error;
  }
}

std::string meaning_of(int error) {
  switch (-error) {
    case ENOENT: return "does not exist";
    case ENODEV:
    case ENXIO: return "there is no device behind it";
    case EACCES:
    case EPERM: return "no permission; the group of the device node (video) has it";
    case EBUSY: return "busy: another program uses it (a loopback device: nobody writes to it yet)";
    case ENOTTY: return "not a V4L2 device";
    default: return std::strerror(-error);
  }
}

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (std::uint32_t shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>((fourcc >> shift) & 0x7FU);
    text += c >= ' ' && c < 0x7F ? c : '?';
  }
  return text;
}

std::string size_text(std::uint32_t width_px, std::uint32_t height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px);
}

std::string number_text(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

v4l2_buffer described(std::uint32_t index = 0) {
  v4l2_buffer buffer{};
  buffer.type = capture;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

Status V4l2Driver::fail(Status status, const std::string& what) {
  problem_ = settings_.device + ": " + what;
  return status;
}

Status V4l2Driver::fail_call(const std::string& what, int error) {
  return fail(status_of(error), what.empty() ? meaning_of(error) : what + ": " + meaning_of(error));
}

Status V4l2Driver::lose(const std::string& what, int error) {
  return fail(Status::device_lost, error == 0 ? what : what + ": " + meaning_of(error));
}

Status V4l2Driver::open(const CameraSettings& settings) {
  close();
  settings_ = settings;
  problem_.clear();
  using Step = Status (V4l2Driver::*)();
  for (const Step step :
       {&V4l2Driver::check_settings, &V4l2Driver::open_node, &V4l2Driver::check_capabilities,
        &V4l2Driver::choose_format, &V4l2Driver::set_rate, &V4l2Driver::set_exposure, &V4l2Driver::set_gain,
        &V4l2Driver::set_controls, &V4l2Driver::map_buffers, &V4l2Driver::start_streaming}) {
    const Status status = (this->*step)();
    if (status == Status::ok) continue;
    close();
    return status;
  }
  return Status::ok;
}

void V4l2Driver::close() {
  if (!node_.is_open()) return;
  // A device that is gone refuses all this; what matters is that nothing stays mapped or open.
  int type = static_cast<int>(capture);
  if (streaming_) static_cast<void>(node_.ioctl(VIDIOC_STREAMOFF, type));
  streaming_ = false;
  for (const Buffer& buffer : buffers_) static_cast<void>(calls_.unmap(buffer.address, buffer.bytes));
  v4l2_requestbuffers none{};
  none.type = capture;
  none.memory = V4L2_MEMORY_MMAP;
  if (!buffers_.empty()) static_cast<void>(node_.ioctl(VIDIOC_REQBUFS, none));
  buffers_.clear();
  node_.close();
}

Status V4l2Driver::check_settings() {
  if (settings_.width_px == 0 || settings_.height_px == 0) {
    return fail(Status::invalid_argument, "the size of the images is needed");
  }
  if (settings_.trigger == Trigger::software) {
    return fail(Status::unsupported, "V4L2 has no software trigger: free_running or line was expected");
  }
  if (settings_.rate_hz > 0.0 && settings_.exposure_us * settings_.rate_hz > 1e6) {
    return fail(Status::invalid_argument, "an exposure of " + number_text(settings_.exposure_us) +
                                              " us does not fit into a period at " + number_text(settings_.rate_hz) +
                                              " Hz");
  }
  if (settings_.format.empty()) return Status::ok;
  const auto named = format_named(settings_.format);
  if (!named) return fail(Status::invalid_argument, "there is no pixel format \"" + settings_.format + "\"");
  if (fourcc_of(*named) == 0) return fail(Status::unsupported, "V4L2 has no pixel format " + settings_.format);
  return Status::ok;
}

Status V4l2Driver::open_node() {
  const int result = node_.open(settings_.device.c_str());
  return result < 0 ? fail_call("", result) : Status::ok;
}

Status V4l2Driver::check_capabilities() {
  v4l2_capability about{};
  const int result = node_.ioctl(VIDIOC_QUERYCAP, about);
  if (result == -EINVAL || result == -ENOSYS) return fail_call("", -ENOTTY);  // the latter from an emulator
  if (result < 0) return fail_call("", result);
  const std::uint32_t able = (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps : about.capabilities;
  if ((able & V4L2_CAP_VIDEO_CAPTURE) == 0) {
    const bool planes = (able & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0;
    return fail(Status::unsupported,
                planes ? "captures in several planes, one was expected"
                       : "is not a camera (a loopback device becomes one when somebody writes to it)");
  }
  if ((able & V4L2_CAP_STREAMING) == 0) return fail(Status::unsupported, "cannot stream, only be read");
  return Status::ok;
}

Status V4l2Driver::choose_format() {
  std::vector<RawFormat> offered;
  std::string list;
  for (std::uint32_t index = 0; index < most_formats; ++index) {
    v4l2_fmtdesc description{};
    description.type = capture;
    description.index = index;
    const int result = node_.ioctl(VIDIOC_ENUM_FMT, description);
    if (result == -EINVAL) break;
    if (result < 0) return fail_call("its pixel formats", result);
    const auto format = format_of_fourcc(description.pixelformat);
    list += (list.empty() ? "" : ", ") + (format ? name_of(*format) : fourcc_text(description.pixelformat));
    if (format) offered.push_back(*format);
  }
  std::string reason;
  for (const RawFormat format : all_formats) {
    if (std::find(offered.begin(), offered.end(), format) == offered.end()) continue;
    const bool fits =
        settings_.format.empty() ? significant_bits(format) <= settings_.max_bits : settings_.format == name_of(format);
    if (!fits) continue;
    const Status status = try_format(format, reason);
    if (status != Status::unsupported) return status;
  }
  if (!reason.empty()) return fail(Status::unsupported, reason);
  return fail(Status::unsupported,
              "offers " + (list.empty() ? "no pixel format" : list) + "; expected " +
                  (settings_.format.empty() ? "one of grey8, y10, y12, y16, yuyv, bayer_*" : settings_.format));
}

Status V4l2Driver::try_format(RawFormat format, std::string& reason) {
  v4l2_format wanted{};
  wanted.type = capture;
  wanted.fmt.pix.width = settings_.width_px;
  wanted.fmt.pix.height = settings_.height_px;
  wanted.fmt.pix.pixelformat = fourcc_of(format);
  wanted.fmt.pix.field = V4L2_FIELD_NONE;
  const int result = node_.ioctl(VIDIOC_S_FMT, wanted);
  if (result == -EINVAL) {
    reason = std::string("refuses ") + name_of(format);
    return Status::unsupported;
  }
  if (result < 0) return fail_call("", result);
  const v4l2_pix_format& got = wanted.fmt.pix;
  if (got.pixelformat != fourcc_of(format) || got.width != settings_.width_px || got.height != settings_.height_px) {
    reason = "gives " + size_text(got.width, got.height) + " " + fourcc_text(got.pixelformat) + ", " +
             size_text(settings_.width_px, settings_.height_px) + " " + name_of(format) + " was asked for";
    return Status::unsupported;
  }
  if (got.field != V4L2_FIELD_NONE && got.field != V4L2_FIELD_ANY) {
    reason = "gives half-images, whole ones were asked for";
    return Status::unsupported;
  }
  const std::uint64_t row = row_bytes(format, got.width);
  const std::uint64_t stride = got.bytesperline == 0 ? row : got.bytesperline;
  if (stride < row) {
    reason = "says that a row takes " + std::to_string(stride) + " bytes; " + name_of(format) + " needs " +
             std::to_string(row);
    return Status::unsupported;
  }
  format_ = format;
  stride_bytes_ = static_cast<std::uint32_t>(stride);
  image_bytes_ = got.sizeimage;
  needed_bytes_ = stride * (got.height - 1) + row;
  return Status::ok;
}

Status V4l2Driver::set_rate() {
  if (settings_.rate_hz <= 0.0) return Status::ok;
  const std::string wanted = "rate of " + number_text(settings_.rate_hz) + " Hz";
  v4l2_streamparm parameters{};
  parameters.type = capture;
  const int told = node_.ioctl(VIDIOC_G_PARM, parameters);
  if (told == -ENOTTY || told == -EINVAL ||
      (told >= 0 && (parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) == 0)) {
    return fail(Status::unsupported, wanted + ": its rate cannot be set");
  }
  if (told < 0) return fail_call(wanted, told);
  v4l2_fract& period = parameters.parm.capture.timeperframe;
  period.numerator = 1000;
  period.denominator = static_cast<std::uint32_t>(std::clamp(std::round(settings_.rate_hz * 1000.0), 1.0, 4e9));
  const int result = node_.ioctl(VIDIOC_S_PARM, parameters);
  if (result < 0) return fail_call(wanted, result);
  const double got_hz = period.numerator == 0 ? 0.0 : static_cast<double>(period.denominator) / period.numerator;
  if (std::abs(got_hz - settings_.rate_hz) > rate_tolerance * settings_.rate_hz) {
    return fail(Status::unsupported, wanted + ": gives " + number_text(got_hz) + " Hz");
  }
  return Status::ok;
}

Status V4l2Driver::set_to(std::uint32_t id, double value, const char* what, const char* unit) {
  const auto range = node_.control_range(id);
  const auto wanted = [&] { return std::string(what) + " of " + number_text(value) + unit; };  // no text without need
  if (!range) return fail(Status::unsupported, wanted() + ": it has no such control");
  if (value < range->least || value > range->most) {
    return fail(Status::unsupported,
                wanted() + ": takes " + std::to_string(range->least) + " to " + std::to_string(range->most) + unit);
  }
  const int result = node_.set_control(id, static_cast<std::int32_t>(value));
  return result < 0 ? fail_call(wanted(), result) : Status::ok;
}

std::optional<V4l2Driver::ExposureUnit> V4l2Driver::exposure_unit() {
  if (node_.control_range(V4L2_CID_EXPOSURE_ABSOLUTE))
    return ExposureUnit{V4L2_CID_EXPOSURE_ABSOLUTE, 100.0, " x 100 us"};
  const auto line_px = node_.control(V4L2_CID_HBLANK);
  const auto pixel_rate_hz = node_.wide_control(V4L2_CID_PIXEL_RATE);
  const bool tells_line = line_px && pixel_rate_hz.value_or(0) > 0;
  if (!tells_line || !node_.control_range(V4L2_CID_EXPOSURE)) return std::nullopt;
  return ExposureUnit{V4L2_CID_EXPOSURE,
                      1e6 * (static_cast<double>(settings_.width_px) + *line_px) / static_cast<double>(*pixel_rate_hz),
                      " lines"};
}

std::uint32_t V4l2Driver::gain_id() {
  return node_.control_range(V4L2_CID_GAIN) ? V4L2_CID_GAIN : V4L2_CID_ANALOGUE_GAIN;
}

Status V4l2Driver::set_exposure() {
  exposure_.exposure = {};
  exposure_us_ = 0.0;
  const bool manual = settings_.exposure_us > 0.0;
  if (node_.control_range(V4L2_CID_EXPOSURE_AUTO)) {
    if (manual) {
      const Status status = set_to(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "manual exposure, mode", "");
      if (status != Status::ok) return status;
    } else if (node_.control(V4L2_CID_EXPOSURE_AUTO) != V4L2_EXPOSURE_MANUAL) {
      return Status::ok;  // nobody knows how long
    }
  }
  const auto unit = exposure_unit();
  if (!unit) {
    if (!manual) return Status::ok;
    return fail(Status::unsupported, "exposure of " + number_text(settings_.exposure_us) +
                                         " us: it has no control for that, or none of a known unit");
  }
  if (manual) {
    const Status status = set_to(unit->id, std::round(settings_.exposure_us / unit->unit_us), "exposure", unit->name);
    if (status != Status::ok) return status;
  }
  exposure_us_ = node_.control(unit->id).value_or(0) * unit->unit_us;
  exposure_.exposure = {static_cast<std::int64_t>(exposure_us_ * 1000.0)};
  return Status::ok;
}

Status V4l2Driver::set_gain() {
  exposure_.gain = 0.0;
  const bool manual = settings_.gain >= 0.0;
  if (node_.control_range(V4L2_CID_AUTOGAIN)) {
    if (manual) {
      const Status status = set_to(V4L2_CID_AUTOGAIN, 0.0, "manual gain, automatism", "");
      if (status != Status::ok) return status;
    } else if (node_.control(V4L2_CID_AUTOGAIN) != 0) {
      return Status::ok;
    }
  }
  const std::uint32_t id = gain_id();
  if (manual) {
    const Status status = set_to(id, std::round(settings_.gain), "gain", "");
    if (status != Status::ok) return status;
  }
  exposure_.gain = node_.control(id).value_or(0);
  return Status::ok;
}

Status V4l2Driver::exposure_range(ExposureRange& range) {
  if (!node_.is_open()) return Status::not_configured;
  const auto unit = exposure_unit();
  const auto steps = unit ? node_.control_range(unit->id) : std::nullopt;
  if (!steps) return fail(Status::unsupported, "exposure: it has no control for that, or none of a known unit");
  range = {};
  range.least_us = std::max(steps->least, 1) * unit->unit_us;
  range.most_us = steps->most * unit->unit_us;
  if (settings_.rate_hz > 0.0) {  // in whole steps, or the nearest one would be longer than a period
    range.most_us = std::min(range.most_us, std::floor(1e6 / (settings_.rate_hz * unit->unit_us)) * unit->unit_us);
  }
  if (const auto gains = node_.control_range(gain_id())) {
    range.has_gain = true;
    range.gain_least = std::max(gains->least, 0);
    range.gain_most = gains->most;
  }
  return Status::ok;
}

Status V4l2Driver::push_exposure(const ExposureValues& values) {
  settings_.exposure_us = values.exposure_us;
  settings_.gain = values.gain;
  const Status status = set_exposure();
  return status == Status::ok ? set_gain() : status;
}

Status V4l2Driver::adjust(ExposureValues& values) {
  if (!node_.is_open()) return Status::not_configured;
  const ExposureInForce::Values before = exposure_;
  const ExposureValues former{exposure_us_, settings_.gain};
  if (const Status status = push_exposure(values); status != Status::ok) {
    const std::string reason = problem_;
    static_cast<void>(push_exposure(former));
    problem_ = reason;
    exposure_ = before;
    return status == Status::device_lost || status == Status::no_data ? Status::device_lost : Status::io_error;
  }
  in_force_.change(clock_.now(), exposure_);
  values.exposure_us = exposure_us_;
  if (values.gain >= 0.0) values.gain = exposure_.gain;
  return Status::ok;
}

Status V4l2Driver::set_controls() {
  for (const DeviceControl& control : settings_.controls) {
    std::string names;
    const auto id = node_.control_named(control.name, names);
    if (!id) {
      return fail(Status::unsupported,
                  "has no control " + control.name + "; it has " + (names.empty() ? "none" : names));
    }
    const Status status = set_to(*id, control.value, control.name.c_str(), "");
    if (status != Status::ok) return status;
  }
  return Status::ok;
}

Status V4l2Driver::map_buffers() {
  v4l2_requestbuffers request{};
  request.type = capture;
  request.memory = V4L2_MEMORY_MMAP;
  request.count = buffers_wanted_;
  const int requested = node_.ioctl(VIDIOC_REQBUFS, request);
  if (requested < 0) return fail_call("buffers", requested);
  buffers_.reserve(request.count);
  for (std::uint32_t index = 0; index < request.count; ++index) {
    v4l2_buffer buffer = described(index);
    const int told = node_.ioctl(VIDIOC_QUERYBUF, buffer);
    if (told < 0) return fail_call("buffer " + std::to_string(index), told);
    if (buffer.length < needed_bytes_) {
      return fail(Status::unsupported, "its buffers have " + std::to_string(buffer.length) + " bytes, an image needs " +
                                           std::to_string(needed_bytes_));
    }
    int error = 0;
    void* const address = calls_.map(buffer.length, node_.fd(), buffer.m.offset, error);
    if (address == nullptr) return fail_call("mapping of buffer " + std::to_string(index), error);
    buffers_.push_back({.address = address, .bytes = buffer.length, .on_loan = false});
  }
  if (buffers_.size() < 2) {
    return fail(Status::no_capacity, "gives " + std::to_string(buffers_.size()) + " buffers, 2 are needed at least");
  }
  return Status::ok;
}

Status V4l2Driver::start_streaming() {
  for (std::uint32_t index = 0; index < buffers_.size(); ++index) {
    const int result = enqueue(index);
    if (result < 0) return fail_call("buffer " + std::to_string(index), result);
  }
  // Not every device has events; a changed size then shows in the images.
  v4l2_event_subscription changes{};
  changes.type = V4L2_EVENT_SOURCE_CHANGE;
  static_cast<void>(node_.ioctl(VIDIOC_SUBSCRIBE_EVENT, changes));
  int type = static_cast<int>(capture);
  const int result = node_.ioctl(VIDIOC_STREAMON, type);
  if (result == -ENOSPC) return fail(Status::no_capacity, "the bus has no bandwidth left for it");
  if (result < 0) return fail_call("start of streaming", result);
  streaming_ = true;
  in_force_.restart(exposure_);
  has_frames_ = false;
  counts_ = true;
  usual_bytes_ = image_bytes_;
  return Status::ok;
}

int V4l2Driver::enqueue(std::uint32_t index) {
  v4l2_buffer buffer = described(index);
  return node_.ioctl(VIDIOC_QBUF, buffer);
}

std::uint32_t V4l2Driver::max_loans() const {
  const auto count = static_cast<std::uint32_t>(buffers_.size());
  return count > kept_by_device ? count - kept_by_device : 1;
}

Status V4l2Driver::trigger() { return fail(Status::unsupported, "V4L2 has no software trigger"); }

Status V4l2Driver::give_back(std::uint32_t buffer) {
  if (buffer >= buffers_.size() || !buffers_[buffer].on_loan) return Status::stale_handle;
  buffers_[buffer].on_loan = false;
  const int result = enqueue(buffer);
  return result < 0 ? lose("a buffer was not taken back", result) : Status::ok;
}

Status V4l2Driver::take(Duration wait, RawImage& image) {
  if (!streaming_) return fail(Status::not_configured, "is not open");
  const Time end = clock_.now() + wait;
  for (int wakeups = 0; wakeups < most_wakeups; ++wakeups) {
    const Status status = dequeue(image);
    if (status != Status::no_data) return status;
    const Duration left = end - clock_.now();
    if (left.ns <= 0) break;
    pollfd file{.fd = node_.fd(), .events = POLLIN | POLLPRI, .revents = 0};
    const int ready = calls_.poll(file, left);
    if (ready == 0) break;
    if (ready == -EINTR) continue;
    if (ready < 0) return lose("waiting for an image", ready);
    if ((file.revents & POLLPRI) != 0 && source_has_changed()) return lose("its source has changed");
    if ((file.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 && (file.revents & POLLIN) == 0) {
      return lose("gave up streaming");
    }
  }
  return wait.ns > 0 ? Status::timeout : Status::no_data;
}

bool V4l2Driver::source_has_changed() {
  v4l2_event event{};
  return node_.ioctl(VIDIOC_DQEVENT, event) >= 0 && event.type == V4L2_EVENT_SOURCE_CHANGE;
}

Status V4l2Driver::dequeue(RawImage& image) {
  v4l2_buffer buffer = described();
  const int result = node_.ioctl(VIDIOC_DQBUF, buffer);
  if (result == -EAGAIN) return Status::no_data;
  if (result < 0) return lose("waiting for an image", result);
  if (buffer.index >= buffers_.size() || buffers_[buffer.index].on_loan) {
    return lose("gave buffer " + std::to_string(buffer.index) + ", which it did not have");
  }
  buffers_[buffer.index].on_loan = true;
  const bool damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
  if (!damaged && buffer.bytesused != usual_bytes_) {
    if (format_has_changed()) return Status::device_lost;
    usual_bytes_ = buffer.bytesused;
  }
  fill_in(buffer, image);
  image.complete = !damaged && buffer.bytesused >= needed_bytes_;
  return Status::ok;
}

bool V4l2Driver::format_has_changed() {
  v4l2_format now{};
  now.type = capture;
  if (node_.ioctl(VIDIOC_G_FMT, now) < 0) return false;  // a short image, then
  const v4l2_pix_format& pixels = now.fmt.pix;
  if (pixels.pixelformat == fourcc_of(format_) && pixels.width == settings_.width_px &&
      pixels.height == settings_.height_px) {
    return false;
  }
  static_cast<void>(lose("changed to " + size_text(pixels.width, pixels.height) + " " +
                         fourcc_text(pixels.pixelformat) + " while streaming " +
                         size_text(settings_.width_px, settings_.height_px) + " " + name_of(format_)));
  return true;
}

void V4l2Driver::fill_in(const v4l2_buffer& buffer, RawImage& image) {
  const Buffer& memory = buffers_[buffer.index];
  image = RawImage();
  image.bytes = {static_cast<const std::uint8_t*>(memory.address),
                 std::min<std::size_t>(buffer.bytesused, memory.bytes)};
  image.width_px = settings_.width_px;
  image.height_px = settings_.height_px;
  image.stride_bytes = stride_bytes_;
  image.format = format_;
  image.buffer = buffer.index;

  image.dequeued = image.first_data = clock_.now();
  image.stamp =
      Time{std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + std::int64_t{buffer.timestamp.tv_usec} * 1000};
  const bool start_of_exposure = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  image.stamp_meaning = start_of_exposure ? StampMeaning::start_of_exposure : settings_.stamp_meaning;
  const std::uint32_t kind = buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK;
  // Drivers that do not say stamp by the monotonic clock or by that of the wall; the latter is no use but as a device's own.
  const std::int64_t age_ns = (image.dequeued - image.stamp).ns;
  const bool looks_monotonic = age_ns >= 0 && age_ns < 10'000'000'000;
  if (image.stamp.ns == 0) {
    image.stamp = image.dequeued;
    image.stamp_meaning = StampMeaning::end_of_exposure;
  } else if (kind == V4L2_BUF_FLAG_TIMESTAMP_COPY || (kind == V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN && !looks_monotonic)) {
    image.clock = hal::ClockId::device;
  }
  const bool ours = image.clock == hal::ClockId::monotonic;
  const ExposureInForce::Values& exposure =
      in_force_.at(ours ? image.stamp : image.dequeued, ours ? image.stamp_meaning : StampMeaning::end_of_exposure);
  image.exposure = exposure.exposure;
  image.gain = exposure.gain;

  if (!has_frames_) {
    first_sequence_ = buffer.sequence;  // of a loopback device: whatever its writer has come to
  } else if (buffer.sequence == last_sequence_) {
    counts_ = false;
  }
  has_frames_ = true;
  last_sequence_ = buffer.sequence;
  image.has_sequence = counts_;
  image.sequence = buffer.sequence - first_sequence_;
}

}  // namespace relnav::platform::linux
