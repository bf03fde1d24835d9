#include "platform/posix/udp_packet_link.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace relnav::platform::posix {

UdpPacketLink::~UdpPacketLink() { close(); }

void UdpPacketLink::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

Status UdpPacketLink::open(const char* host, std::uint16_t port) {
  close();
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  char service[8] = {};
  std::snprintf(service, sizeof(service), "%u", static_cast<unsigned>(port));
  addrinfo* found = nullptr;
  if (port == 0 || ::getaddrinfo(host, service, &hints, &found) != 0) return Status::invalid_argument;
  const addrinfo* chosen =
      found;  // IPv4 if there is one: a name such as localhost has both, and ground tools listen on IPv4
  for (const addrinfo* candidate = found; candidate != nullptr; candidate = candidate->ai_next) {
    if (candidate->ai_family == AF_INET) {
      chosen = candidate;
      break;
    }
  }
  Status status = Status::io_error;
  if (chosen->ai_addrlen <= max_address_bytes) {
    socket_ = ::socket(chosen->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    std::memcpy(address_, chosen->ai_addr, chosen->ai_addrlen);
    address_bytes_ = chosen->ai_addrlen;
    if (socket_ >= 0) status = Status::ok;
  }
  ::freeaddrinfo(found);
  return status;
}

Status UdpPacketLink::send(std::span<const std::uint8_t> packet) {
  if (packet.empty() || packet.size() > max_packet_bytes()) return Status::invalid_argument;
  if (socket_ < 0) return Status::not_configured;
  const void* const address = address_;  // aligned for any of them
  const ssize_t sent = ::sendto(socket_, packet.data(), packet.size(), MSG_NOSIGNAL,
                                static_cast<const sockaddr*>(address), address_bytes_);
  if (sent == static_cast<ssize_t>(packet.size())) return Status::ok;
  switch (errno) {
    case EAGAIN:
    case ENOBUFS: return Status::no_capacity;
    case ENETDOWN:
    case ENETUNREACH:
    case EHOSTUNREACH: return Status::device_lost;
    default: return Status::io_error;
  }
}

}  // namespace relnav::platform::posix
