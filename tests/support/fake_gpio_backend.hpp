#pragma once
/// A GPIO chip in memory, as the kernel and libgpiod show it: edges wait in a buffer of 16 a line, and a descriptor becomes
/// readable. Counting edges as version 2 of the interface does (the oldest are lost), or not, as version 1 (the newest are lost).
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "platform/linux/gpio_backend.hpp"

namespace relnav::test {

class FakeGpioBackend final : public platform::linux::GpioBackend {
 public:
  enum class Api : std::uint8_t { v1, v2 };
  explicit FakeGpioBackend(std::uint32_t lines, Api api = Api::v2) : lines_(lines), api_(api) {}
  ~FakeGpioBackend() override { FakeGpioBackend::close(); }

  // The world outside.
  bool level(std::uint32_t offset) const { return lines_.at(offset).level; }
  void drive(std::uint32_t offset, bool level, Time time) {
    Line& line = lines_.at(offset);
    if (line.level == level) return;
    line.level = level;
    const bool asked =
        line.edges == hal::Edges::both || line.edges == (level ? hal::Edges::rising : hal::Edges::falling);
    if (line.use != Use::input || !asked) return;
    ++line.seen;
    if (line.waiting.size() == kept_edges()) {
      if (api_ == Api::v1) return;
      line.waiting.pop_front();
    }
    line.waiting.push_back({level, time, api_ == Api::v2 ? line.seen : 0U});
    signal(line);
  }
  void unplug() {
    gone_ = true;
    for (Line& line : lines_) {
      if (line.event >= 0) signal(line);  // poll() wakes up
    }
  }
  void plug() { gone_ = false; }
  void set_name(std::uint32_t offset, const std::string& name) { lines_.at(offset).name = name; }
  /// Another process has the line.
  void occupy(std::uint32_t offset) { lines_.at(offset).occupied = true; }
  /// The next set() or get() answers this.
  void fail_next(Status status) { failure_ = status; }
  /// Called before the edges of a line are read.
  void (*before_read)(FakeGpioBackend&, std::uint32_t) = nullptr;
  int opens() const { return opens_; }
  bool is_open() const { return open_; }

  Status open(const std::string& path) override {
    problem_ = path + ": no such device";
    if (gone_) return Status::no_data;
    open_ = true;
    ++opens_;
    return Status::ok;
  }
  void close() override {
    open_ = false;
    for (std::uint32_t i = 0; i < lines_.size(); ++i) release(i);
  }
  std::uint32_t line_count() const override { return static_cast<std::uint32_t>(lines_.size()); }
  std::string line_name(std::uint32_t offset) override { return lines_.at(offset).name; }
  Status request_output(std::uint32_t offset, bool initial) override {
    if (const Status status = grant(offset, Use::output, hal::Edges::none); status != Status::ok) return status;
    lines_[offset].level = initial;
    return Status::ok;
  }
  Status request_input(std::uint32_t offset, hal::Edges edges) override { return grant(offset, Use::input, edges); }
  void release(std::uint32_t offset) override {
    Line& line = lines_.at(offset);
    if (line.event >= 0) ::close(line.event);
    line.event = -1;
    line.use = Use::none;
    line.waiting.clear();
    line.seen = 0;
  }
  Status set(std::uint32_t offset, bool level) override {
    if (const Status status = check(); status != Status::ok) return status;
    if (lines_.at(offset).use != Use::output) return Status::io_error;
    lines_[offset].level = level;
    return Status::ok;
  }
  Status get(std::uint32_t offset, bool& level) override {
    if (const Status status = check(); status != Status::ok) return status;
    level = lines_.at(offset).level;
    return Status::ok;
  }
  int edge_descriptor(std::uint32_t offset) const override { return lines_.at(offset).event; }
  Status read_edges(std::uint32_t offset, std::span<platform::linux::KernelEdge> edges, std::size_t& count) override {
    count = 0;
    if (gone_) return Status::device_lost;
    if (before_read != nullptr) before_read(*this, offset);
    Line& line = lines_.at(offset);
    for (; count < edges.size() && !line.waiting.empty(); ++count) {
      edges[count] = line.waiting.front();
      line.waiting.pop_front();
    }
    if (line.waiting.empty()) {
      eventfd_t value = 0;
      static_cast<void>(::eventfd_read(line.event, &value));
    }
    return Status::ok;
  }
  std::size_t kept_edges() const override { return 16; }
  const std::string& problem() const override { return problem_; }

 private:
  enum class Use : std::uint8_t { none, input, output };
  struct Line {
    Use use = Use::none;
    hal::Edges edges = hal::Edges::none;
    bool level = false;
    bool occupied = false;
    std::string name;
    std::uint32_t seen = 0;
    int event = -1;
    std::deque<platform::linux::KernelEdge> waiting;
  };
  static void signal(Line& line) { static_cast<void>(::eventfd_write(line.event, 1)); }
  Status check() {
    const Status failure = failure_;
    failure_ = Status::ok;
    return gone_ ? Status::device_lost : failure;
  }
  Status grant(std::uint32_t offset, Use use, hal::Edges edges) {
    if (gone_) return Status::device_lost;
    Line& line = lines_.at(offset);
    problem_ = "line " + std::to_string(offset) + ": busy";
    if (line.occupied || line.use != Use::none) return Status::no_capacity;
    line.use = use;
    line.edges = edges;
    if (edges != hal::Edges::none) line.event = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    return Status::ok;
  }

  std::vector<Line> lines_;
  Api api_;
  bool gone_ = false;
  bool open_ = false;
  int opens_ = 0;
  Status failure_ = Status::ok;
  std::string problem_;
};

}  // namespace relnav::test
