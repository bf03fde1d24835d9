#include "platform/host/scripted_command_source.hpp"

#include <algorithm>

namespace relnav::platform::host {

Status ScriptedCommandSource::push_packet(std::span<const std::uint8_t> packet) {
  if (packet.empty()) return Status::invalid_argument;
  Item item;
  item.packet.assign(packet.begin(), packet.end());
  return script_.push(item) ? Status::ok : Status::no_capacity;
}

Status ScriptedCommandSource::push_status(Status status) {
  if (status == Status::ok) return Status::invalid_argument;
  Item item;
  item.status = status;
  return script_.push(item) ? Status::ok : Status::no_capacity;
}

Status ScriptedCommandSource::receive(std::span<std::uint8_t> buffer, std::size_t& bytes) {
  ++calls_;
  if (!script_.has_next()) return Status::no_data;
  const Item& item = script_.next();
  script_.skip();
  if (item.status != Status::ok) return item.status;
  if (item.packet.size() > buffer.size()) return Status::no_capacity;
  std::copy(item.packet.begin(), item.packet.end(), buffer.begin());
  bytes = item.packet.size();
  return Status::ok;
}

}  // namespace relnav::platform::host
