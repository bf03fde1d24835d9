#include "platform/host/scripted_gpio_lines.hpp"

#include <algorithm>

namespace relnav::platform::host {

ScriptedGpioLines::ScriptedGpioLines(std::uint32_t lines, std::size_t unread_edges)
    : lines_(lines), unread_capacity_(unread_edges), calls_(16384) {
  unread_.reserve(unread_edges);
}

void ScriptedGpioLines::fail_calls(Status status, std::uint32_t count) {
  failure_ = status;
  failures_left_ = count;
}

Status ScriptedGpioLines::record(GpioCall::Kind kind, Status answer, std::uint32_t offset, bool level) {
  calls_.push({kind, answer, offset, level});
  return answer;
}

/// Whether a call on this line may go ahead.
Status ScriptedGpioLines::check(std::uint32_t offset, bool wanted_requested) {
  if (lost_) return Status::device_lost;
  if (offset >= lines_.size()) return wanted_requested ? Status::not_configured : Status::invalid_argument;
  const bool requested = lines_[offset].use != Use::none;
  if (wanted_requested && !requested) return Status::not_configured;
  if (!wanted_requested && requested) return Status::no_capacity;
  if (failures_left_ > 0) {
    --failures_left_;
    return failure_;
  }
  return Status::ok;
}

Status ScriptedGpioLines::request_output(std::uint32_t offset, bool initial) {
  const Status status = check(offset, false);
  if (status == Status::ok) lines_[offset] = {Use::output, hal::Edges::none, initial, 0};
  return record(GpioCall::Kind::request_output, status, offset, initial);
}

Status ScriptedGpioLines::request_input(std::uint32_t offset, hal::Edges edges) {
  const Status status = check(offset, false);
  if (status == Status::ok) lines_[offset] = {Use::input, edges, lines_[offset].level, 0};
  return record(GpioCall::Kind::request_input, status, offset, false);
}

Status ScriptedGpioLines::release(std::uint32_t offset) {
  if (offset >= lines_.size() || lines_[offset].use == Use::none) {
    return record(GpioCall::Kind::release, Status::not_configured, offset, false);
  }
  lines_[offset].use = Use::none;
  std::erase_if(unread_, [offset](const hal::LineEdge& edge) { return edge.offset == offset; });
  return record(GpioCall::Kind::release, Status::ok, offset, false);
}

Status ScriptedGpioLines::set(std::uint32_t offset, bool level) {
  Status status = check(offset, true);
  if (status == Status::ok && lines_[offset].use != Use::output) status = Status::invalid_argument;
  if (status == Status::ok) lines_[offset].level = level;
  return record(GpioCall::Kind::set, status, offset, level);
}

Status ScriptedGpioLines::get(std::uint32_t offset, bool& level) {
  const Status status = check(offset, true);
  if (status == Status::ok) level = lines_[offset].level;
  return record(GpioCall::Kind::get, status, offset, status == Status::ok && level);
}

Status ScriptedGpioLines::wait_edge(Duration wait, hal::LineEdge& edge) {
  Status status = Status::ok;
  if (lost_) {
    status = Status::device_lost;
  } else if (failures_left_ > 0) {
    --failures_left_;
    status = failure_;
  } else if (unread_.empty()) {
    if (clock_ != nullptr) clock_->advance(wait);
    status = wait.ns > 0 ? Status::timeout : Status::no_data;
  } else {
    edge = unread_.front();
    unread_.erase(unread_.begin());
  }
  return record(GpioCall::Kind::wait_edge, status, status == Status::ok ? edge.offset : 0U,
                status == Status::ok && edge.rising);
}

Status ScriptedGpioLines::drive(std::uint32_t offset, bool level, Time time) {
  if (offset >= lines_.size() || lines_[offset].use == Use::output) return Status::invalid_argument;
  Line& line = lines_[offset];
  if (line.level == level) return Status::ok;
  line.level = level;
  const hal::Edges edges = line.edges;
  const bool asked = edges == hal::Edges::both || edges == (level ? hal::Edges::rising : hal::Edges::falling);
  if (line.use != Use::input || !asked) return Status::ok;
  ++line.edges_seen;
  if (unread_.size() == unread_capacity_) return Status::ok;  // lost: the sequence will show it
  const hal::LineEdge edge{offset, level, time, hal::ClockId::monotonic, line.edges_seen};
  const auto after = std::upper_bound(unread_.begin(), unread_.end(), edge,
                                      [](const hal::LineEdge& a, const hal::LineEdge& b) { return a.time < b.time; });
  unread_.insert(after, edge);
  return Status::ok;
}

}  // namespace relnav::platform::host
