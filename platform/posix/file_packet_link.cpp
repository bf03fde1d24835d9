#include "platform/posix/file_packet_link.hpp"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>

namespace relnav::platform::posix {

FilePacketLink::~FilePacketLink() { static_cast<void>(close()); }

Status FilePacketLink::open(const char* path, Start start) {
  static_cast<void>(close());
  const int mode = start == Start::truncate ? O_TRUNC : 0;
  file_ = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | mode, 0644);
  return file_ < 0 ? Status::io_error : Status::ok;
}

Status FilePacketLink::close() {
  if (file_ < 0) return Status::ok;
  const int result = ::close(file_);
  file_ = -1;
  return result == 0 ? Status::ok : Status::io_error;
}

Status FilePacketLink::send(std::span<const std::uint8_t> packet) {
  if (packet.empty() || packet.size() > max_packet_bytes()) return Status::invalid_argument;
  if (file_ < 0) return Status::not_configured;
  const off_t before = ::lseek(file_, 0, SEEK_END);
  const ssize_t written = ::write(file_, packet.data(), packet.size());
  const int error = errno;
  if (written == static_cast<ssize_t>(packet.size())) return Status::ok;
  if (written > 0 && (before < 0 || ::ftruncate(file_, before) != 0)) return Status::io_error;
  return written > 0 || error == ENOSPC ? Status::no_capacity : Status::io_error;
}

}  // namespace relnav::platform::posix
