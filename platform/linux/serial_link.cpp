#include "platform/linux/serial_link.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/types.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace relnav::platform::linux {
namespace {

struct Rate {
  std::uint32_t baud;
  speed_t code;
};
constexpr Rate rates[] = {{1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},
                          {19200, B19200},     {38400, B38400},     {57600, B57600},     {115200, B115200},
                          {230400, B230400},   {460800, B460800},   {500000, B500000},   {576000, B576000},
                          {921600, B921600},   {1000000, B1000000}, {1152000, B1152000}, {1500000, B1500000},
                          {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000},
                          {4000000, B4000000}};

Status open_status(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV: return Status::no_data;
    case EBUSY: return Status::no_capacity;
    default: return Status::io_error;
  }
}

/// Raw bytes at this rate; false, with errno, when the device does not do it.
bool make_raw(int file, speed_t code) {
  termios settings{};
  if (::tcgetattr(file, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag |= static_cast<tcflag_t>(CLOCAL | CREAD);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  if (::cfsetspeed(&settings, code) != 0 || ::tcsetattr(file, TCSANOW, &settings) != 0) return false;
  // tcsetattr() is content when a part of it was done.
  termios done{};
  if (::tcgetattr(file, &done) != 0) return false;
  errno = EINVAL;
  return ::cfgetospeed(&done) == code && (done.c_lflag & static_cast<tcflag_t>(ICANON | ECHO)) == 0;
}

}  // namespace

Status SerialLink::open(const std::string& path, std::uint32_t baud) {
  close();
  const auto* const rate =
      std::find_if(std::begin(rates), std::end(rates), [baud](const Rate& r) { return r.baud == baud; });
  if (rate == std::end(rates)) {
    problem_ = path + ": " + std::to_string(baud) + " baud is no standard rate; expected one such as 115200";
    return Status::invalid_argument;
  }
  // Not blocking: open() would wait for a modem's carrier, write() for room.
  const int file = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) {
    const int error = errno;
    problem_ = path + ": cannot be opened: " + std::strerror(error) + "; expected a serial line";
    return open_status(error);
  }
  if (::isatty(file) != 1) {
    problem_ = path + ": is not a serial line";
    ::close(file);
    return Status::unsupported;
  }
  const bool raw = make_raw(file, rate->code);
  if (!raw || ::ioctl(file, TIOCEXCL) != 0) {
    const int error = errno;
    problem_ = path + (raw ? ": cannot be locked: " : ": cannot be set to " + std::to_string(baud) + " baud: ") +
               std::strerror(error);
    ::close(file);
    return !raw && error == EINVAL ? Status::invalid_argument : Status::io_error;
  }
  file_ = file;
  return Status::ok;
}

void SerialLink::close() {
  // Not tcdrain(): a line that stands still would keep the program from ending.
  if (file_ >= 0) ::close(file_);
  file_ = -1;
  rest_begin_ = 0;
  rest_end_ = 0;
}

Status SerialLink::send(std::span<const std::uint8_t> packet) {
  if (packet.empty() || packet.size() > max_packet_bytes()) return Status::invalid_argument;
  if (const Status status = flush(); status != Status::ok) return status;
  std::size_t written = 0;
  if (const Status status = write_some(packet, written); status != Status::ok) return status;
  const auto rest = packet.subspan(written);
  std::copy(rest.begin(), rest.end(), rest_.begin());
  rest_begin_ = 0;
  rest_end_ = rest.size();
  return Status::ok;
}

Status SerialLink::flush() {
  if (file_ < 0) return Status::not_configured;
  if (waiting_bytes() == 0) return Status::ok;
  std::size_t written = 0;
  const Status status = write_some(std::span(rest_).first(rest_end_).subspan(rest_begin_), written);
  if (status != Status::ok) return status;
  rest_begin_ += written;
  return waiting_bytes() == 0 ? Status::ok : Status::no_capacity;
}

Status SerialLink::write_some(std::span<const std::uint8_t> bytes, std::size_t& written) {
  const ssize_t result = ::write(file_, bytes.data(), bytes.size());
  written = result > 0 ? static_cast<std::size_t>(result) : 0;
  if (result >= 0) return Status::ok;
  switch (errno) {
    case EAGAIN:
    case EINTR: return Status::ok;
    case EIO:  // hung up
    case ENXIO:
    case ENODEV: return Status::device_lost;
    default: return Status::io_error;
  }
}

}  // namespace relnav::platform::linux
