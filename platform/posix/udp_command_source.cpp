#include "platform/posix/udp_command_source.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace relnav::platform::posix {
namespace {

constexpr int empty_datagrams_passed_over = 8;

std::string reason(int error) {
  switch (error) {
    case EADDRINUSE: return "the port is in use by another program; expected a free one";
    case EADDRNOTAVAIL: return "this is no address of this machine; expected one, or 0.0.0.0 for all";
    case EACCES: return "no permission for this port; expected one above 1023";
    default: return std::string("cannot be listened on: ") + std::strerror(error);
  }
}

Status status_of(int error) {
  switch (error) {
    case EADDRINUSE: return Status::no_capacity;
    case EADDRNOTAVAIL: return Status::unsupported;
    default: return Status::io_error;
  }
}

std::uint16_t port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  if (address.ss_family == AF_INET6) return ntohs(reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port);
  return ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
}

}  // namespace

UdpCommandSource::~UdpCommandSource() { close(); }

void UdpCommandSource::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  port_ = 0;
}

Status UdpCommandSource::open(const char* host, std::uint16_t port) {
  close();
  const std::string where = std::string("udp://") + host + ":" + std::to_string(port) + ": ";
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (const int failure = ::getaddrinfo(host, std::to_string(port).c_str(), &hints, &found); failure != 0) {
    problem_ = where + "does not resolve: " + ::gai_strerror(failure);
    return Status::invalid_argument;
  }
  const addrinfo* chosen = found;  // IPv4 if there is one, as UdpPacketLink sends to it
  for (const addrinfo* candidate = found; candidate != nullptr; candidate = candidate->ai_next) {
    if (candidate->ai_family == AF_INET) {
      chosen = candidate;
      break;
    }
  }
  int error = 0;
  socket_ = ::socket(chosen->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0 || ::bind(socket_, chosen->ai_addr, chosen->ai_addrlen) != 0) error = errno;
  ::freeaddrinfo(found);
  if (error != 0) {
    close();
    problem_ = where + reason(error);
    return status_of(error);
  }
  port_ = port_of(socket_);
  return Status::ok;
}

Status UdpCommandSource::receive(std::span<std::uint8_t> buffer, std::size_t& bytes) {
  if (socket_ < 0) return Status::not_configured;
  for (int i = 0; i < empty_datagrams_passed_over; ++i) {
    iovec room{buffer.data(), buffer.size()};
    msghdr message{};
    message.msg_iov = &room;
    message.msg_iovlen = 1;
    const ssize_t size = ::recvmsg(socket_, &message, MSG_DONTWAIT);
    if (size < 0) return errno == EAGAIN || errno == EINTR ? Status::no_data : Status::io_error;
    if ((message.msg_flags & MSG_TRUNC) != 0) return Status::no_capacity;
    if (size == 0) continue;
    bytes = static_cast<std::size_t>(size);
    return Status::ok;
  }
  return Status::no_data;
}

}  // namespace relnav::platform::posix
