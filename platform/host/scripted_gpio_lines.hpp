#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/gpio_lines.hpp"
#include "platform/host/bounded_record.hpp"
#include "platform/host/scripted_clock.hpp"

namespace relnav::platform::host {

/// A call the lines have seen, with its answer.
struct GpioCall {
  enum class Kind : std::uint8_t { request_output, request_input, release, set, get, wait_edge };
  Kind kind = Kind::get;
  Status answer = Status::ok;
  std::uint32_t offset = 0;
  bool level = false;
};

/// Digital lines in memory: the test moves the inputs, sees the outputs, and plays faults. No allocation after construction.
class ScriptedGpioLines final : public hal::GpioLines {
 public:
  explicit ScriptedGpioLines(std::uint32_t lines = 32, std::size_t unread_edges = 64);

  /// Level from outside on an input line (or one not requested yet), as seen at `time`; makes an edge if it was asked for.
  /// invalid_argument: no such line, or an output.
  Status drive(std::uint32_t offset, bool level, Time time);
  /// What is on the line, whoever drives it. False for a line that does not exist.
  [[nodiscard]] bool level(std::uint32_t offset) const { return offset < lines_.size() && lines_[offset].level; }
  /// The next `count` calls that would succeed answer `status` and do nothing.
  void fail_calls(Status status, std::uint32_t count = 1);
  void lose_device() { lost_ = true; }
  void restore_device() { lost_ = false; }
  /// Time spent waiting is added to this clock.
  void attach_clock(ScriptedClock& clock) { clock_ = &clock; }
  [[nodiscard]] const BoundedRecord<GpioCall>& calls() const { return calls_; }

  Status request_output(std::uint32_t offset, bool initial) override;
  Status request_input(std::uint32_t offset, hal::Edges edges) override;
  Status release(std::uint32_t offset) override;
  Status set(std::uint32_t offset, bool level) override;
  Status get(std::uint32_t offset, bool& level) override;
  Status wait_edge(Duration wait, hal::LineEdge& edge) override;

 private:
  enum class Use : std::uint8_t { none, input, output };
  struct Line {
    Use use = Use::none;
    hal::Edges edges = hal::Edges::none;
    bool level = false;
    std::uint32_t edges_seen = 0;
  };

  Status check(std::uint32_t offset, bool wanted_requested);
  Status record(GpioCall::Kind kind, Status answer, std::uint32_t offset, bool level);

  std::vector<Line> lines_;
  std::vector<hal::LineEdge> unread_;
  std::size_t unread_capacity_;
  BoundedRecord<GpioCall> calls_;
  Status failure_ = Status::ok;
  std::uint32_t failures_left_ = 0;
  bool lost_ = false;
  ScriptedClock* clock_ = nullptr;
};

}  // namespace relnav::platform::host
