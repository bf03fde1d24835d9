#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/packet_link.hpp"
#include "platform/host/bounded_record.hpp"

namespace relnav::platform::host {

/// Link that keeps what it is sent, up to a bound, and answers by script. No allocation after construction.
class ScriptedPacketLink final : public hal::PacketLink {
 public:
  explicit ScriptedPacketLink(std::size_t capacity_packets = 1024, std::uint32_t max_packet_bytes = 1400);

  /// After those pushed before, the next `count` valid calls of send() answer `status`; ok lets them through.
  Status push_answer(Status status, std::uint32_t count = 1);

  [[nodiscard]] std::size_t size() const { return lengths_.size(); }
  /// i < size(), in the order sent.
  [[nodiscard]] std::span<const std::uint8_t> packet(std::size_t i) const;
  [[nodiscard]] std::size_t refused() const { return refused_; }
  /// Forgets the packets and makes room; the script stays.
  void clear();

  /// no_capacity when the bound is reached.
  Status send(std::span<const std::uint8_t> packet) override;
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return max_packet_bytes_; }

 private:
  struct Answer {
    Status status = Status::ok;
    std::uint32_t count = 0;
  };
  Status next_answer();

  std::uint32_t max_packet_bytes_;
  std::size_t capacity_packets_;
  std::vector<std::uint8_t> bytes_;
  BoundedRecord<std::size_t> lengths_;
  BoundedRecord<Answer> answers_;
  std::size_t refused_ = 0;
};

}  // namespace relnav::platform::host
