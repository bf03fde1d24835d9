#include "platform/linux/gpiod_lines.hpp"

#include <time.h>

#include <algorithm>
#include <cerrno>
#include <charconv>

#include "platform/linux/gpio_chip.hpp"
#include "platform/linux/monotonic_clock.hpp"

namespace relnav::platform::linux {
namespace {

/// Buffers of the kernel that a line's unread edges fill before they are left with the kernel.
constexpr std::size_t unread_buffers = 4;

Time monotonic_now() { return MonotonicClock().now(); }

timespec to_timespec(Duration length) {
  const std::int64_t ns = std::max<std::int64_t>(length.ns, 0);
  timespec result{};
  result.tv_sec = static_cast<time_t>(ns / 1'000'000'000);
  result.tv_nsec = static_cast<decltype(result.tv_nsec)>(ns % 1'000'000'000);
  return result;
}

}  // namespace

Status GpiodLines::open(const std::string& chip) {
  close();
  chip_ = chip;
  chip_is_path_ = false;
  return open_backend();
}

Status GpiodLines::open_path(const std::string& path) {
  close();
  chip_ = path;
  chip_is_path_ = true;
  return open_backend();
}

Status GpiodLines::open_backend() {
  std::string path = chip_;
  if (!chip_is_path_) {
    if (const Status status = find_gpio_chip(chip_, path, problem_); status != Status::ok) return status;
  }
  if (const Status status = backend_.open(path); status != Status::ok) {
    problem_ = backend_.problem();
    return status;
  }
  // Lines lost with the chip stay so; all memory is taken here.
  lines_.resize(backend_.line_count());
  watched_.reserve(lines_.size());
  watched_lines_.reserve(lines_.size());
  fresh_.resize(backend_.kept_edges());
  open_ = true;
  lost_ = false;
  return Status::ok;
}

void GpiodLines::close() {
  if (open_) backend_.close();
  open_ = false;
  lost_ = false;
  lines_.clear();
  watched_.clear();
  watched_lines_.clear();
}

Status GpiodLines::find_line(const std::string& line, std::uint32_t& offset) {
  if (!open_) return Status::not_configured;
  if (lost_) return Status::device_lost;
  const auto count = static_cast<std::uint32_t>(lines_.size());
  if (!line.empty() && line.find_first_not_of("0123456789") == std::string::npos) {
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (error == std::errc{} && number < count) {
      offset = number;
      return Status::ok;
    }
    problem_ = "GPIO chip " + chip_ + ": there is no line " + line + "; expected 0 to " + std::to_string(count - 1);
    return Status::invalid_argument;
  }
  std::uint32_t matches = 0;
  std::uint32_t match = 0;
  std::string names;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name = backend_.line_name(i);
    if (name.empty()) continue;
    names += (names.empty() ? "" : ", ") + name;
    if (name != line) continue;
    ++matches;
    match = i;
  }
  if (matches == 1) {
    offset = match;
    return Status::ok;
  }
  problem_ = "GPIO chip " + chip_ + ": " + (matches == 0 ? "no line" : "more than one line") + " is named \"" + line +
             "\"; its lines are 0 to " + std::to_string(count - 1) + (names.empty() ? ", without names" : ": " + names);
  return matches == 0 ? Status::invalid_argument : Status::ambiguous;
}

Status GpiodLines::request_output(std::uint32_t offset, bool initial) {
  return request(offset, Use::output, hal::Edges::none, initial);
}

Status GpiodLines::request_input(std::uint32_t offset, hal::Edges edges) {
  return request(offset, Use::input, edges, false);
}

Status GpiodLines::request(std::uint32_t offset, Use use, hal::Edges edges, bool initial) {
  if (!open_) return Status::not_configured;
  if (lost_ && open_backend() != Status::ok) return Status::device_lost;
  if (offset >= lines_.size()) return Status::invalid_argument;
  Line& line = lines_[offset];
  if (line.use != Use::none) return Status::no_capacity;
  const Status status =
      use == Use::output ? backend_.request_output(offset, initial) : backend_.request_input(offset, edges);
  if (status != Status::ok) {
    problem_ = backend_.problem();
    return note(status);
  }
  line = Line{use, edges};
  if (edges != hal::Edges::none) line.unread.resize(unread_buffers * backend_.kept_edges());
  watch_lines();
  return Status::ok;
}

Status GpiodLines::release(std::uint32_t offset) {
  if (offset >= lines_.size() || lines_[offset].use == Use::none) return Status::not_configured;
  if (lines_[offset].use != Use::lost) backend_.release(offset);
  lines_[offset] = Line{};
  watch_lines();
  return Status::ok;
}

Status GpiodLines::set(std::uint32_t offset, bool level) {
  if (const Status status = check_requested(offset); status != Status::ok) return status;
  if (lines_[offset].use != Use::output) return Status::invalid_argument;
  return note(backend_.set(offset, level));
}

Status GpiodLines::get(std::uint32_t offset, bool& level) {
  if (const Status status = check_requested(offset); status != Status::ok) return status;
  return note(backend_.get(offset, level));
}

Status GpiodLines::wait_edge(Duration wait, hal::LineEdge& edge) {
  if (!open_) return Status::not_configured;
  if (lost_) return Status::device_lost;
  // An edge is the oldest for sure if it is older than the look at all lines that found it.
  Time now = monotonic_now();
  const Time deadline = now + Duration{std::max<std::int64_t>(wait.ns, 0)};
  Duration left = deadline - now;
  for (bool waited = false;; waited = true) {
    if (const Status status = note(collect()); status != Status::ok) return status;
    if (take(now, edge)) return Status::ok;
    if (oldest() != nullptr) {  // came during the look: look again
      now = monotonic_now();
      if (const Status status = note(collect()); status != Status::ok) return status;
      if (take(Time{INT64_MAX}, edge)) return Status::ok;
    }
    if (waited || left.ns == 0) return wait.ns > 0 ? Status::timeout : Status::no_data;
    const timespec timeout = to_timespec(left);
    const int ready = ::ppoll(watched_.data(), watched_.size(), &timeout, nullptr);
    if (ready < 0 && errno != EINTR) return Status::io_error;
    for (const pollfd& line : watched_) {
      if (ready > 0 && (line.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) return lost();
    }
    now = monotonic_now();
    left = Duration{std::max<std::int64_t>((deadline - now).ns, 0)};
  }
}

Status GpiodLines::check_requested(std::uint32_t offset) const {
  if (lost_) return Status::device_lost;
  if (offset >= lines_.size() || lines_[offset].use == Use::none) return Status::not_configured;
  return lines_[offset].use == Use::lost ? Status::device_lost : Status::ok;
}

Status GpiodLines::lost() {
  for (Line& line : lines_) {
    if (line.use != Use::none) line.use = Use::lost;
  }
  watch_lines();
  backend_.close();
  lost_ = true;
  return Status::device_lost;
}

/// Passes a status of the backend on, and everything goes down with the device.
Status GpiodLines::note(Status status) { return status == Status::device_lost ? lost() : status; }

Status GpiodLines::collect() {
  for (const std::uint32_t offset : watched_lines_) {
    if (const Status status = collect_line(offset); status != Status::ok) return status;
  }
  return Status::ok;
}

Status GpiodLines::collect_line(std::uint32_t offset) {
  Line& line = lines_[offset];
  // What does not fit stays with the kernel: it counts what it loses, or is found full.
  while (line.unread.size() - line.count >= fresh_.size()) {
    std::size_t count = 0;
    if (const Status status = backend_.read_edges(offset, fresh_, count); status != Status::ok) return status;
    for (std::size_t i = 0; i < count; ++i) append(offset, fresh_[i]);
    if (count < fresh_.size()) break;
    line.gap = true;
  }
  return Status::ok;
}

void GpiodLines::append(std::uint32_t offset, const KernelEdge& edge) {
  Line& line = lines_[offset];
  line.sequence = edge.sequence != 0 ? edge.sequence : line.sequence + (line.gap ? 2U : 1U);
  line.gap = false;
  line.unread[(line.first + line.count) % line.unread.size()] = {offset, edge.rising, edge.time,
                                                                 hal::ClockId::monotonic, line.sequence};
  ++line.count;
}

/// The line whose oldest unread edge is older than those of the others.
GpiodLines::Line* GpiodLines::oldest() {
  Line* result = nullptr;
  for (const std::uint32_t offset : watched_lines_) {
    Line& line = lines_[offset];
    if (line.count == 0) continue;
    if (result == nullptr || line.unread[line.first].time < result->unread[result->first].time) result = &line;
  }
  return result;
}

/// The oldest edge, if it is older than `before`.
bool GpiodLines::take(Time before, hal::LineEdge& edge) {
  Line* const line = oldest();
  if (line == nullptr || line->unread[line->first].time >= before) return false;
  edge = line->unread[line->first];
  line->first = (line->first + 1) % line->unread.size();
  --line->count;
  return true;
}

void GpiodLines::watch_lines() {
  watched_.clear();
  watched_lines_.clear();
  for (std::uint32_t i = 0; i < lines_.size(); ++i) {
    if (lines_[i].use != Use::input || lines_[i].edges == hal::Edges::none) continue;
    watched_.push_back({backend_.edge_descriptor(i), POLLIN, 0});
    watched_lines_.push_back(i);
  }
}

}  // namespace relnav::platform::linux
