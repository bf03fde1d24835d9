#pragma once
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace relnav::hal {

/// Way out for telemetry packets. Contract (tests/contract/packet_link_contract.hpp):
/// LNK-1  send() takes one whole packet of 1..max_packet_bytes() bytes or none of it.
/// LNK-2  send() of an empty or oversized packet returns invalid_argument and sends nothing.
/// LNK-3  send() never blocks: no room now is no_capacity (the packet is not sent), a fault is io_error or device_lost.
/// LNK-4  Packets that arrive do so unchanged, in the order sent, and are not merged or split.
/// LNK-5  send() keeps no reference to `packet` once it has returned.
/// LNK-6  After a refused send() the next one stands on its own: nothing of the refused packet is ever sent.
class PacketLink {
 public:
  virtual Status send(std::span<const std::uint8_t> packet) = 0;
  [[nodiscard]] virtual std::uint32_t max_packet_bytes() const = 0;

 protected:
  PacketLink() = default;
  PacketLink(const PacketLink&) = default;
  PacketLink& operator=(const PacketLink&) = default;
  ~PacketLink() = default;
};

}  // namespace relnav::hal
