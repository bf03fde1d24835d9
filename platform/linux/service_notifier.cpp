#include "platform/linux/service_notifier.hpp"

#include <sys/socket.h>
#include <sys/types.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>

namespace relnav::platform::linux {
namespace {

/// -1: no number, or too large a one.
std::int64_t number(const char* text) {
  std::int64_t value = -1;
  const char* const end = text + std::strlen(text);
  const auto [last, error] = std::from_chars(text, end, value);
  return error == std::errc{} && last == end ? value : -1;
}

}  // namespace

Status ServiceNotifier::open(const char* address) {
  close();
  if (address == nullptr || *address == '\0') return Status::ok;
  static_assert(sizeof(sockaddr_un) <= max_address_bytes);
  sockaddr_un target{};
  target.sun_family = AF_UNIX;
  const std::size_t length = std::strlen(address);
  if ((address[0] != '/' && address[0] != '@') || length >= sizeof(target.sun_path)) {
    problem_ = std::string("NOTIFY_SOCKET=") + address + ": expected a path from the root or @name, shorter than " +
               std::to_string(sizeof(target.sun_path)) + " bytes";
    return Status::invalid_argument;
  }
  std::memcpy(target.sun_path, address, length);
  std::size_t bytes = offsetof(sockaddr_un, sun_path) + length;
  if (address[0] == '@') {
    target.sun_path[0] = '\0';  // abstract: the length ends the name
  } else {
    ++bytes;
  }
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0) {
    problem_ = std::string("NOTIFY_SOCKET=") + address + ": no socket: " + std::strerror(errno);
    return Status::io_error;
  }
  std::memcpy(address_, &target, bytes);
  address_bytes_ = static_cast<std::uint32_t>(bytes);
  return Status::ok;
}

void ServiceNotifier::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

Status ServiceNotifier::status(std::string_view text) {
  constexpr std::string_view key = "STATUS=";
  std::array<char, key.size() + 200> message{};
  const std::size_t length = std::min(text.size(), message.size() - key.size());
  std::copy(key.begin(), key.end(), message.begin());
  // A line end would begin another assignment.
  std::replace_copy(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length), message.begin() + key.size(),
                    '\n', ' ');
  return send({message.data(), key.size() + length});
}

Status ServiceNotifier::send(std::string_view message) {
  if (socket_ < 0) return Status::ok;
  const void* const address = address_;  // aligned for a sockaddr
  const ssize_t sent = ::sendto(socket_, message.data(), message.size(), MSG_NOSIGNAL,
                                static_cast<const sockaddr*>(address), address_bytes_);
  if (sent == static_cast<ssize_t>(message.size())) return Status::ok;
  switch (errno) {
    case EAGAIN:
    case ENOBUFS: return Status::no_capacity;
    case ENOENT:
    case ECONNREFUSED: return Status::device_lost;
    default: return Status::io_error;
  }
}

Duration ServiceNotifier::watchdog_interval(const char* usec, const char* pid) {
  if (usec == nullptr) return {};
  if (pid != nullptr && number(pid) != std::int64_t{::getpid()}) return {};  // meant for another process
  const std::int64_t interval_us = number(usec);
  if (interval_us <= 0 || interval_us > INT64_MAX / 1000) return {};
  return {interval_us * 1000};
}

}  // namespace relnav::platform::linux
