#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/packet_link.hpp"

namespace relnav::platform::linux {

/// Packets one after the other on a serial line: raw bytes, 8 data bits, no parity, 1 stop bit, no flow control. Packets are not
/// framed: a receiver finds their bounds by their headers.
///
/// The line takes what fits its own buffer (some 4 KiB). The rest of a packet waits here and goes out with the next send() or
/// flush(); until it is out no other packet is taken (no_capacity).
class SerialLink final : public hal::PacketLink {
 public:
  SerialLink() = default;
  SerialLink(const SerialLink&) = delete;
  SerialLink& operator=(const SerialLink&) = delete;
  ~SerialLink() { close(); }

  /// `baud`: a standard rate, 1200 to 4000000. The device is locked against others. On an error problem() says what is wrong:
  /// no_data: no such device; unsupported: not a serial line; invalid_argument: not a rate, or one the device does not do;
  /// no_capacity: somebody else has it; io_error.
  Status open(const std::string& path, std::uint32_t baud);
  /// What waits is gone.
  void close();
  [[nodiscard]] const std::string& problem() const { return problem_; }

  /// not_configured before open(). device_lost: the line is gone; open() comes next.
  Status send(std::span<const std::uint8_t> packet) override;
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return static_cast<std::uint32_t>(rest_.size()); }
  /// Writes on. ok: nothing waits any more; no_capacity: the line took less than that.
  Status flush();
  [[nodiscard]] std::size_t waiting_bytes() const { return rest_end_ - rest_begin_; }

 private:
  Status write_some(std::span<const std::uint8_t> bytes, std::size_t& written);

  int file_ = -1;
  std::array<std::uint8_t, 2048> rest_{};
  std::size_t rest_begin_ = 0;
  std::size_t rest_end_ = 0;
  std::string problem_;
};

}  // namespace relnav::platform::linux
