#include "fsw/app/line_service.hpp"

#include <algorithm>

#include "fsw/app/saturating.hpp"

namespace relnav::app {
namespace {

using telemetry::EventId;
using telemetry::SyncStatus;

constexpr std::int64_t second_ns = 1'000'000'000;

std::uint32_t in_ms(Duration length) {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(length.ns / 1'000'000, 0, 0xFFFFFFFF));
}

}  // namespace

// ---- lines ----

Status LineService::configure(const LineConfig& config) {
  release_all();
  time_.configure(config.time);
  sync_ = SyncStatus::none;
  naming_ = Naming();
  exposures_.reset();
  frame_ = {};
  time_due_ = false;
  level_ = false;
  lines_ = {};
  if (gpio_ == nullptr) return Status::ok;
  lines_[heartbeat].offset = config.heartbeat;
  lines_[pulse].offset = config.pulse;
  lines_[exposure].offset = config.exposure;
  for (const Role role : {heartbeat, pulse, exposure}) {
    if (!lines_[role].exists()) continue;
    const Status status = request(role);
    if (status == Status::ok) continue;
    release_all();
    lines_ = {};
    return status;
  }
  return Status::ok;
}

Status LineService::request(Role role) {
  Line& line = lines_[role];
  Status status = Status::ok;
  switch (role) {
    case heartbeat: status = gpio_->request_output(line.number(), level_); break;
    case pulse: status = gpio_->request_input(line.number(), hal::Edges::rising); break;
    case exposure: status = gpio_->request_input(line.number(), hal::Edges::both); break;
  }
  line.held = status == Status::ok;
  return status;
}

void LineService::release_all() {
  for (Line& line : lines_) {
    if (line.held) static_cast<void>(gpio_->release(line.number()));  // whatever it says, it is not ours any more
    line.held = false;
  }
}

void LineService::fail(Role role, Status reason) {
  Line& line = lines_[role];
  if (!line.held) return;
  line.held = false;
  increment(line.failures);
  events_.report(EventId::line_failed, reason, {line.offset, line.failures});
}

void LineService::recover() {
  for (const Role role : {heartbeat, pulse, exposure}) {
    const Line& line = lines_[role];
    if (!line.exists() || line.held) continue;
    static_cast<void>(gpio_->release(line.number()));  // it may be held still, or not
    if (request(role) == Status::ok && role == exposure) exposures_.reset();
  }
}

void LineService::beat() {
  if (!lines_[heartbeat].held) return;
  level_ = !level_;
  const Status status = gpio_->set(lines_[heartbeat].number(), level_);
  if (status != Status::ok) fail(heartbeat, status);
}

// ---- edges ----

void LineService::serve() {
  if (gpio_ == nullptr) return;
  recover();
  if (lines_[pulse].held || lines_[exposure].held) read_edges();
  // When all edges have been read: the exposure of the frame that is told of may have ended after the pulse.
  if (time_due_) send_time(clock_.now());
  if (lines_[pulse].exists()) watch_time();
}

void LineService::read_edges() {
  for (int i = 0; i < most_edges; ++i) {
    hal::LineEdge edge;
    const Status status = gpio_->wait_edge(Duration{0}, edge);
    if (status == Status::no_data || status == Status::timeout) return;
    if (status != Status::ok) {
      fail(pulse, status);
      fail(exposure, status);
      return;
    }
    take(edge);
  }
}

void LineService::take(const hal::LineEdge& edge) {
  const bool is_pulse = lines_[pulse].exists() && edge.offset == lines_[pulse].number();
  if (edge.clock != clock_.id()) {
    // Nothing relates it to our clock: a platform that is set up wrongly.
    events_.report(EventId::line_failed, Status::unsupported, {edge.offset});
  } else if (is_pulse && edge.rising) {
    take_pulse(edge);
  } else if (!is_pulse) {
    exposures_.edge(edge.rising, edge.time);
  }
}

// ---- time ----

void LineService::take_pulse(const hal::LineEdge& edge) {
  if (time_due_) send_time(clock_.now());
  const TimeMap::Verdict verdict = time_.add(edge.time);
  if (verdict == TimeMap::Verdict::refused) return;
  if (verdict == TimeMap::Verdict::restarted) {
    events_.report(EventId::time_jumped, Status::inconsistent, {time_.step().ns, time_.counts().refused});
    sync_ = SyncStatus::none;
  }
  settle_naming(edge.time);
  const SyncStatus sync = time_.status(edge.time);
  if (sync == SyncStatus::locked && sync_ != SyncStatus::locked) {
    events_.report(EventId::time_synchronised, Status::ok,
                   {time_.drift_ppb(), time_.residual().ns, time_.counts().used});
  }
  sync_ = sync;
  time_due_ = true;
}

void LineService::watch_time() {
  const Time now = clock_.now();
  // Two seconds after the command the pulse that it meant is past, and its edge would have been read.
  if (naming_.state == Naming::State::awaited && (now - naming_.since).ns > 2 * second_ns) {
    naming_.state = Naming::State::over;
    naming_.outcome = Status::timeout;
  }
  if (time_.status(now) != SyncStatus::holdover || sync_ == SyncStatus::holdover) return;
  sync_ = SyncStatus::holdover;
  events_.report(EventId::time_lost, Status::timeout,
                 {in_ms(now - time_.latest_edge()), time_.drift_ppb(), time_.counts().used});
  send_time(now);
}

Status LineService::name_next_pulse(std::uint32_t tai_seconds) {
  if (!lines_[pulse].exists()) return Status::not_configured;
  if (naming_.state != Naming::State::none) return Status::no_capacity;
  naming_ = {Naming::State::awaited, Status::ok, tai_seconds, clock_.now()};
  return Status::ok;
}

void LineService::settle_naming(Time edge) {
  if (naming_.state != Naming::State::awaited || edge <= naming_.since) return;
  // Later than a second (and what the clock may be off in it): the pulse that was meant has been missed.
  const bool is_next = (edge - naming_.since).ns <= second_ns + second_ns / 100;
  if (is_next) time_.name_latest(naming_.tai_seconds);
  naming_.state = Naming::State::over;
  naming_.outcome = is_next ? Status::ok : Status::timeout;
}

bool LineService::take_naming(Status& outcome) {
  if (naming_.state != Naming::State::over) return false;
  outcome = naming_.outcome;
  naming_.state = Naming::State::none;
  return true;
}

void LineService::send_time(Time now) {
  time_due_ = false;
  constexpr std::int64_t most = 0x7FFFFFFF;
  telemetry::TimePacket p;
  p.time_ns = static_cast<std::uint64_t>(time_.latest_pulse().ns);
  p.tai_ns = static_cast<std::uint64_t>(time_.latest_seconds() * second_ns);
  p.drift_ppb = time_.drift_ppb();
  p.residual_ns = static_cast<std::int32_t>(std::clamp(time_.residual().ns, -most, most));
  p.pulse_age_ms = in_ms(now - time_.latest_edge());
  p.pulses_used = time_.counts().used;
  p.pulses_missed = time_.counts().missed;
  p.pulses_refused = time_.counts().refused;
  p.sync = static_cast<std::uint8_t>(sync_);
  p.seconds_source = static_cast<std::uint8_t>(time_.seconds_source());
  p.exposure_offset_ns = exposures_.offset_ns(frame_);
  telemetry_.send_time(p);
}

}  // namespace relnav::app
