#pragma once
#include "hal/packet_link.hpp"
#include "platform/mps2/semihosting.hpp"

namespace relnav::platform::mps2 {

/// Packets one after the other into a file of the host.
class SemihostedPacketLink final : public hal::PacketLink {
 public:
  /// io_error: the file cannot be made.
  Status open(const char* path) {
    return file_.open(path, HostFile::Access::write) == Status::ok ? Status::ok : Status::io_error;
  }
  /// not_configured before open(); io_error.
  Status send(std::span<const std::uint8_t> packet) override {
    if (packet.empty() || packet.size() > max_packet_bytes()) return Status::invalid_argument;
    return file_.is_open() ? file_.append(packet) : Status::not_configured;
  }
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return 65542; }

 private:
  HostFile file_;
};

}  // namespace relnav::platform::mps2
