#pragma once
#include <cstdint>
#include <string>

#include "hal/command_source.hpp"

namespace relnav::platform::posix {

/// One datagram a packet, from anybody who reaches the port. Empty datagrams are passed over.
class UdpCommandSource final : public hal::CommandSource {
 public:
  UdpCommandSource() = default;
  UdpCommandSource(const UdpCommandSource&) = delete;
  UdpCommandSource& operator=(const UdpCommandSource&) = delete;
  ~UdpCommandSource();

  /// Listens on an address of this machine (name, IPv4 or IPv6; 0.0.0.0 and :: are all of them), port 0: any free one.
  /// invalid_argument: does not resolve; no_capacity: the port is in use; unsupported: no address of this machine; io_error: no
  /// permission, no socket. problem() then says which in one line.
  Status open(const char* host, std::uint16_t port);
  void close();
  /// That is listened on; 0 before open().
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] const std::string& problem() const { return problem_; }

  /// not_configured before open().
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;

 private:
  int socket_ = -1;
  std::uint16_t port_ = 0;
  std::string problem_;
};

}  // namespace relnav::platform::posix
