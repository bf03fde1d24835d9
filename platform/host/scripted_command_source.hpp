#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/command_source.hpp"
#include "platform/host/bounded_record.hpp"

namespace relnav::platform::host {

/// Source that gives packets and faults by script, in the order pushed. No allocation while it is read.
class ScriptedCommandSource final : public hal::CommandSource {
 public:
  explicit ScriptedCommandSource(std::size_t script_capacity = 1024) : script_(script_capacity) {}

  /// no_capacity: the script is full; invalid_argument: an empty packet.
  Status push_packet(std::span<const std::uint8_t> packet);
  /// One receive() answers `status` (not ok) in this place.
  Status push_status(Status status);
  [[nodiscard]] std::size_t calls() const { return calls_; }
  [[nodiscard]] std::size_t script_left() const { return script_.pending(); }

  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;

 private:
  struct Item {
    std::vector<std::uint8_t> packet;
    Status status = Status::ok;
  };

  BoundedRecord<Item> script_;
  std::size_t calls_ = 0;
};

}  // namespace relnav::platform::host
