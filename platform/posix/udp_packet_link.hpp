#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/packet_link.hpp"

namespace relnav::platform::posix {

/// One datagram a packet. Nobody listening is not an error.
class UdpPacketLink final : public hal::PacketLink {
 public:
  UdpPacketLink() = default;
  UdpPacketLink(const UdpPacketLink&) = delete;
  UdpPacketLink& operator=(const UdpPacketLink&) = delete;
  ~UdpPacketLink();

  /// Host name or numeric address (IPv4, IPv6). invalid_argument when it cannot be resolved, io_error when no socket can be had.
  Status open(const char* host, std::uint16_t port);
  void close();

  /// not_configured before open().
  Status send(std::span<const std::uint8_t> packet) override;
  /// Fits an Ethernet frame with IPv6, not fragmented.
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return 1452; }

 private:
  static constexpr std::size_t max_address_bytes = 128;

  int socket_ = -1;
  alignas(8) unsigned char address_[max_address_bytes] = {};
  std::uint32_t address_bytes_ = 0;
};

}  // namespace relnav::platform::posix
