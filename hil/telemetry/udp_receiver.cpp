#include "hil/telemetry/udp_receiver.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "platform/files/input_error.hpp"

namespace relnav::hil {

UdpReceiver::UdpReceiver(const std::string& url) : buffer_(65536) {
  const UdpAddress address = parse_udp_url(url);
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const int failure = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (failure != 0)
    throw InputError(url, 0, std::string("does not resolve: ") + ::gai_strerror(failure),
                     "udp://HOST:PORT, an address of this machine");
  for (const addrinfo* a = found; a != nullptr && socket_ < 0; a = a->ai_next) {
    socket_ = ::socket(a->ai_family, a->ai_socktype, a->ai_protocol);
    if (socket_ >= 0 && ::bind(socket_, a->ai_addr, a->ai_addrlen) != 0) {
      ::close(socket_);
      socket_ = -1;
    }
  }
  const int reason = errno;
  ::freeaddrinfo(found);
  if (socket_ < 0)
    throw InputError(url, 0, std::string("cannot be listened on: ") + std::strerror(reason),
                     "a free port of this machine");
}

UdpReceiver::~UdpReceiver() { ::close(socket_); }

std::span<const std::uint8_t> UdpReceiver::receive(int wait_ms) {
  pollfd entry{socket_, POLLIN, 0};
  if (::poll(&entry, 1, wait_ms) <= 0) return {};
  const ssize_t size = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
  if (size <= 0) return {};
  return {buffer_.data(), static_cast<std::size_t>(size)};
}

}  // namespace relnav::hil
