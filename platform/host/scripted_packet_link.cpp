#include "platform/host/scripted_packet_link.hpp"

#include <algorithm>

namespace relnav::platform::host {

ScriptedPacketLink::ScriptedPacketLink(std::size_t capacity_packets, std::uint32_t max_packet_bytes)
    : max_packet_bytes_(max_packet_bytes),
      capacity_packets_(capacity_packets),
      bytes_(capacity_packets * max_packet_bytes),
      lengths_(capacity_packets),
      answers_(4096) {}

Status ScriptedPacketLink::push_answer(Status status, std::uint32_t count) {
  if (count == 0) return Status::invalid_argument;
  return answers_.push({status, count}) ? Status::ok : Status::no_capacity;
}

std::span<const std::uint8_t> ScriptedPacketLink::packet(std::size_t i) const {
  return std::span<const std::uint8_t>(bytes_).subspan(i * max_packet_bytes_, lengths_[i]);
}

void ScriptedPacketLink::clear() {
  lengths_.clear();
  refused_ = 0;
}

Status ScriptedPacketLink::next_answer() {
  if (!answers_.has_next()) return Status::ok;
  Answer& answer = answers_.next();
  const Status status = answer.status;
  --answer.count;
  if (answer.count == 0) answers_.skip();
  return status;
}

Status ScriptedPacketLink::send(std::span<const std::uint8_t> packet) {
  Status answer = Status::invalid_argument;
  if (!packet.empty() && packet.size() <= max_packet_bytes_) {
    answer = next_answer();
    if (answer == Status::ok && lengths_.size() == capacity_packets_) answer = Status::no_capacity;
  }
  if (answer != Status::ok) {
    ++refused_;
    return answer;
  }
  const std::size_t start = lengths_.size() * max_packet_bytes_;
  std::copy(packet.begin(), packet.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(start));
  lengths_.push(packet.size());
  return Status::ok;
}

}  // namespace relnav::platform::host
