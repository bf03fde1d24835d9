#pragma once
#include <cstdint>
#include <span>

#include "hal/packet_link.hpp"

namespace relnav::platform::posix {

/// Packets one after the other in a file.
class FilePacketLink final : public hal::PacketLink {
 public:
  FilePacketLink() = default;
  FilePacketLink(const FilePacketLink&) = delete;
  FilePacketLink& operator=(const FilePacketLink&) = delete;
  ~FilePacketLink();

  enum class Start : std::uint8_t { truncate, append };
  /// Closes a file that is open. io_error when the path cannot be opened for writing.
  Status open(const char* path, Start start = Start::truncate);
  /// io_error when the system reports a write that failed late.
  Status close();

  /// not_configured before open(); no_capacity when the disk is full; io_error. A packet written in part is taken back.
  Status send(std::span<const std::uint8_t> packet) override;
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return 65542; }

 private:
  int file_ = -1;
};

}  // namespace relnav::platform::posix
