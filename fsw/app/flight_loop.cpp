#include "fsw/app/flight_loop.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/app/saturating.hpp"
#include "fsw/base/crc16.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::app {
namespace {

using telemetry::EventId;

/// Whole seconds that a packet's time field can count.
constexpr std::int64_t most_seconds_ns = 4'294'967'295'999'999'999;

/// Test ratio as an event's argument: thousandths, bounded.
std::int64_t in_thousandths(double ratio) {
  constexpr double most = 1e9;
  return std::isfinite(ratio) ? static_cast<std::int64_t>(1e3 * std::clamp(ratio, 0.0, most)) : -1;
}

/// Of what makes one run differ from another: camera, motion and range.
std::uint16_t crc_of(const FlightLoopConfig& config) {
  std::array<std::uint8_t, 128> bytes{};
  telemetry::PacketWriter writer(bytes);
  const CameraIntrinsics& camera = config.camera;
  for (const double value : {camera.fu, camera.fv, camera.cu, camera.cv}) writer.f64(value);
  for (const double value : camera.coefficients) writer.f64(value);
  writer.i32(camera.width_px);
  writer.i32(camera.height_px);
  writer.u8(static_cast<std::uint8_t>(camera.model));
  writer.u8(static_cast<std::uint8_t>(config.navigator.filter.motion));
  writer.f64(config.navigator.filter.range_m);
  writer.f64(config.navigator.filter.range_sigma_m);
  return crc16(writer.written());
}

/// False: the intrinsics are unusable, or the image larger than config.hpp allows.
bool add_camera(const CameraIntrinsics& intrinsics, const Mat3& R_KC, const Vec3& t_KC, CameraRig& rig) {
  const Expected<CameraModel> model = CameraModel::create(intrinsics);
  if (!model || static_cast<std::size_t>(intrinsics.width_px) > config::max_image_width ||
      static_cast<std::size_t>(intrinsics.height_px) > config::max_image_height) {
    return false;
  }
  return rig.push_back({model.value(), R_KC, t_KC}) == Status::ok;
}

/// The navigator has done nothing at all.
bool is_prediction_valid(Status update) {
  return update != Status::out_of_order && update != Status::invalid_argument && update != Status::not_configured;
}

}  // namespace

FlightLoop::FlightLoop(hal::Camera& camera, hal::Clock& clock, hal::PacketLink& link, hal::Watchdog& watchdog,
                       hal::Camera* second, const FlightPeripherals& peripherals)
    : clock_(clock),
      watchdog_(watchdog),
      navigators_(std::in_place_type<NoncoopNavigator>, clock),
      navigator_(std::get_if<NoncoopNavigator>(&navigators_)),
      intake_(camera, second, clock),
      telemetry_(link),
      events_(telemetry_),
      lines_(peripherals.lines, clock, telemetry_, events_),
      commands_(peripherals.commands, clock, telemetry_, events_),
      exposures_{AutoExposure(peripherals.exposures[0]), AutoExposure(peripherals.exposures[1])} {}

// ---- configuration and start ----

ConfigItem FlightLoop::validate(const FlightLoopConfig& config, CameraRig& rig) const {
  if (!add_camera(config.camera, Mat3::Identity(), Vec3::Zero(), rig)) return ConfigItem::camera;
  if (config.navigation == NavigationKind::coop_stereo) {
    const SecondCamera& second = config.second;
    if (!intake_.has(1) || !(second.pair_tolerance.ns >= 0) ||
        !add_camera(second.intrinsics, second.R_C1C0, second.t_C1C0, rig)) {
      return ConfigItem::camera;
    }
  }
  const telemetry::PacketConfig& packets = config.packets;
  if (telemetry::validate(packets) != Status::ok || packets.epoch_offset_ns < 0 ||
      packets.epoch_offset_ns > most_seconds_ns) {
    return ConfigItem::packets;
  }
  if (!config.lines.is_valid()) return ConfigItem::lines;
  if (!config.exposure.is_valid()) return ConfigItem::exposure;
  const FilterLimits& filter = config.filter;
  const bool limits_valid = config.acquire_wait.ns >= 0 && config.camera_silence.ns > 0 &&
                            config.lost_after_frames > 0 && config.frames.gap_periods > 0 &&
                            config.frames.restart_gap.ns > 0 && config.frames.max_age.ns >= 0 &&
                            filter.max_refused_in_a_row > 0 && filter.max_test_ratio_frames > 0 &&
                            std::isfinite(filter.max_test_ratio) && filter.max_test_ratio > 0.0;
  return limits_valid ? ConfigItem::none : ConfigItem::limits;
}

Status FlightLoop::configure(const FlightLoopConfig& config) {
  if (report_.mode != Mode::standby) return Status::invalid_argument;
  CameraRig rig;
  ConfigItem refused = validate(config, rig);
  if (refused == ConfigItem::none && configure_navigator(config, rig) != Status::ok) refused = ConfigItem::navigator;
  Status reason = Status::invalid_argument;
  if (refused == ConfigItem::none) {
    const Status lines = lines_.configure(config.lines);
    if (lines != Status::ok) {
      configured_ = false;
      refused = ConfigItem::lines;
      reason = lines;
    }
  }
  if (refused != ConfigItem::none) {
    events_.report(EventId::configuration_refused, reason, {static_cast<std::int64_t>(refused)});
    return Status::invalid_argument;
  }
  const Status status = telemetry_.configure(config.packets, config.event_spacing_frames);
  if (status != Status::ok) return status;
  config_ = config;
  config_.frames.latest_time_ns =
      std::min(config.frames.latest_time_ns, most_seconds_ns - config.packets.epoch_offset_ns);
  configure_intake(rig);
  watch_.configure(config.filter);
  watch_.restart();
  report_ = StepReport();
  counts_ = Counts();
  events_.configure(config);
  commands_.configure(config.packets);
  latency_.reset();
  stamp_ = FrameStamp();
  has_estimate_ = false;
  without_update_ = 0;
  silence_ = {};
  reported_drops_ = 0;
  configured_ = true;
  events_.report(EventId::configuration_accepted, Status::ok, {crc_of(config)});
  return Status::ok;
}

Status FlightLoop::configure_navigator(const FlightLoopConfig& config, const CameraRig& rig) {
  const bool noncoop = config.navigation == NavigationKind::noncoop;
  if (noncoop != std::holds_alternative<NoncoopNavigator>(navigators_)) {
    configured_ = false;
    if (noncoop) {
      navigator_ = &navigators_.emplace<NoncoopNavigator>(clock_);
    } else {
      navigator_ = &navigators_.emplace<CoopNavigator>(clock_);
    }
  }
  if (auto* navigator = std::get_if<NoncoopNavigator>(&navigators_)) {
    return navigator->configure(config.navigator, rig[0].model);
  }
  return std::get_if<CoopNavigator>(&navigators_)->configure(config.coop, rig);
}

void FlightLoop::configure_intake(const CameraRig& rig) {
  intake_.configure({rig.size(), config_.acquire_wait, config_.second.pair_tolerance, config_.frames.restart_gap});
  const int sensor_bits = config_.navigation == NavigationKind::noncoop ? 8 : config_.coop.sensor_bits;
  for (std::size_t c = 0; c < rig.size(); ++c) {
    const CameraIntrinsics& k = rig[c].model.intrinsics();
    intake_.feed(c).configure(config_.frames, config_.camera_silence, static_cast<std::uint32_t>(k.width_px),
                              static_cast<std::uint32_t>(k.height_px), sensor_bits);
    exposures_[c].configure(config_.exposure);
    if (exposures_[c].is_on()) intake_.feed(c).measure_brightness(config_.exposure.brightness);
  }
}

Status FlightLoop::start() {
  if (!configured_) return Status::not_configured;
  if (report_.mode != Mode::standby) return Status::invalid_argument;
  std::size_t camera = 0;
  const Status status = intake_.start(camera);
  if (status != Status::ok) {
    events_.camera_lost(camera, status);
    return status;
  }
  silence_ = {};
  without_update_ = 0;
  intake_.accept_new_time_base();
  change_mode(Mode::acquire, Status::ok);
  return Status::ok;
}

Status FlightLoop::stop() {
  if (report_.mode == Mode::standby) return Status::ok;
  navigator_->restart();
  watch_.restart();
  has_estimate_ = false;
  change_mode(Mode::standby, Status::ok);
  return intake_.stop();
}

// ---- one step ----

const StepReport& FlightLoop::step() {
  const Time begin = clock_.now();
  begin_report();
  if (report_.mode == Mode::standby) {
    report_.status = Status::not_configured;
  } else {
    report_.status = take_frame();
    const Time before = clock_.now();
    send_packets();
    report_.times.telemetry_ns = (clock_.now() - before).ns;
  }
  lines_.serve();
  serve_commands();
  lines_.beat();
  watchdog_status_ = watchdog_.kick();
  report_.times.total_ns = (clock_.now() - begin).ns;
  return report_;
}

void FlightLoop::begin_report() {
  report_.features = report_.matched = report_.inliers = 0;
  report_.dropped = 0;
  report_.exposures.fill({});
  report_.tears.fill({});
  report_.test_ratio = 0.0;
  report_.feature_reports.clear();
  report_.times = StageTimes();
  report_.predicted = false;
  report_.processed = health_due_ = false;
  events_.begin_step(stamp_);
}

Status FlightLoop::take_frame() {
  const FrameEpoch epoch = intake_.gather();
  report_.times.acquire_ns = epoch.acquire_time.ns;
  for (std::size_t c = 0; c < intake_.cameras(); ++c) events_.arrival(c, intake_.feed(c).outcome());
  if (epoch.restart && (navigator_->has_started() || report_.mode == Mode::track)) give_up_estimate(Status::timeout);
  for (std::size_t c = 0; c < intake_.cameras(); ++c) events_.fault(c, intake_.feed(c).outcome());
  const Status used = epoch.status == Status::ok ? navigate(epoch) : without_frame(epoch);
  for (std::size_t c = 0; c < intake_.cameras(); ++c) {
    const Status released = intake_.give_back(c);
    if (released != Status::ok) events_.camera_lost(c, released);
  }
  serve_exposures();
  return used;
}

void FlightLoop::serve_exposures() {
  for (std::size_t c = 0; c < intake_.cameras(); ++c) {
    if (!exposures_[c].is_on()) continue;
    const FeedOutcome& outcome = intake_.feed(c).outcome();
    report_.exposures[c] = exposures_[c].serve(outcome.measured ? &outcome.brightness : nullptr);
  }
}

Status FlightLoop::without_frame(const FrameEpoch& epoch) {
  if (epoch.waited.ns > 0) {
    silence_.ns += epoch.waited.ns;
    if (silence_ < config_.camera_silence) return epoch.status;
    silence_ = {};
    health_due_ = true;
    if (report_.mode == Mode::track || report_.mode == Mode::acquire) give_up_estimate(Status::timeout);
    return epoch.status;
  }
  const bool lost = epoch.status == Status::device_lost;
  if (!epoch.damaged && !epoch.refused && !lost) return epoch.status;
  if (!epoch.damaged) silence_ = {};
  count_frame_without_update(epoch.reason);
  if (epoch.damaged) events_.report(EventId::frame_incomplete, epoch.reason, {intake_.incomplete()});
  return epoch.status;
}

/// What kept the navigator from starting, as an event.
Status FlightLoop::judge_start(Status status) {
  if (status == Status::too_few_features) {
    const bool coop = config_.navigation != NavigationKind::noncoop;
    events_.report(EventId::too_few_features, status,
                   {report_.matched, coop ? config_.coop.min_observations : config_.navigator.min_start_features});
  } else if (status == Status::ambiguous) {
    events_.report(EventId::pose_ambiguous, status, {report_.matched});
  } else if (status != Status::unfinished) {
    events_.report(EventId::numerical_fault, status);
  }
  count_frame_without_update(status);
  return status;
}

Status FlightLoop::navigate(const FrameEpoch& epoch) {
  silence_ = {};
  stamp_ = epoch.stamp;
  events_.concern(stamp_);
  if (epoch.missing != FrameEpoch::no_camera) events_.missing_mate(epoch, intake_.incomplete());
  report_.camera = static_cast<std::uint8_t>(epoch.camera);
  report_.processed = true;
  increment(counts_.processed);
  const hal::Frame& frame = intake_.feed(epoch.camera).frame();
  latency_.begin(frame, clock_.id());
  if (frame.clock == clock_.id()) lines_.frame(frame.mid_exposure);
  const bool was_started = navigator_->has_started();
  const Status status = navigator_->process({epoch.images.data(), intake_.cameras()}, stamp_.time, report_);
  if (report_.dropped > 0) events_.report(EventId::spots_dropped, Status::no_capacity, {report_.dropped});
  for (const Tear& tear : report_.tears) {
    if (tear.exists()) events_.torn_image(tear);
  }
  if (!navigator_->has_started()) return judge_start(status);
  if (!was_started && report_.mode == Mode::lost) change_mode(Mode::acquire, Status::ok);
  if (!is_prediction_valid(status)) {
    events_.report(EventId::numerical_fault, status);
    count_frame_without_update(status);
    return status;
  }
  if (status != Status::ok) {
    increment(counts_.refused_updates);
    events_.report(EventId::update_refused, status,
                   {in_thousandths(report_.test_ratio), report_.matched, report_.inliers});
  }
  const bool starting = navigator_->is_starting();
  const Status verdict = watch_.judge(navigator_->check(), report_.state, {status, report_.test_ratio, starting});
  if (verdict != Status::ok) {
    events_.report(EventId::numerical_fault, verdict);
    give_up_estimate(verdict);
    return verdict;
  }
  has_estimate_ = true;
  report_.predicted = was_started && (status != Status::ok || report_.inliers == 0);
  if (!was_started) {
    without_update_ = 0;
    return Status::ok;
  }
  if (report_.inliers < config_.min_inliers) {
    count_frame_without_update(Status::too_few_features);
    return has_estimate_ ? Status::ok : Status::too_few_features;
  }
  without_update_ = 0;
  if (report_.mode == Mode::acquire && !starting) {
    change_mode(Mode::track, Status::ok);
    events_.report(EventId::track_acquired, Status::ok, {report_.features});
  }
  return Status::ok;
}

// ---- modes ----

void FlightLoop::count_frame_without_update(Status reason) {
  increment(without_update_);
  if (without_update_ < config_.lost_after_frames) return;
  if (report_.mode == Mode::track || report_.mode == Mode::acquire) {
    give_up_estimate(reason);
  } else {
    intake_.accept_new_time_base();
  }
}

void FlightLoop::give_up_estimate(Status reason) {
  if (report_.mode == Mode::track) events_.report(EventId::track_lost, reason, {without_update_, report_.features});
  if (navigator_->has_started()) {
    increment(report_.reset_counter);
    events_.report(EventId::filter_reset, reason, {report_.reset_counter});
  }
  navigator_->restart();
  watch_.restart();
  intake_.accept_new_time_base();
  has_estimate_ = false;
  report_.state = RelativeState();
  if (report_.mode != Mode::lost) change_mode(Mode::lost, reason);
}

void FlightLoop::change_mode(Mode to, Status reason) {
  const Mode from = report_.mode;
  RELNAV_ASSERT(is_allowed(from, to));
  report_.mode = to;
  events_.report(EventId::mode_changed, reason, {static_cast<std::int64_t>(from), static_cast<std::int64_t>(to)});
}

// ---- commands ----

void FlightLoop::serve_commands() {
  Status named = Status::ok;
  if (lines_.take_naming(named)) commands_.finish(naming_request_, named);
  for (int i = 0; i < CommandService::most_a_step; ++i) {
    telemetry::Telecommand command;
    const Status status = commands_.next(command);
    if (status == Status::no_data) return;
    if (status != Status::ok) continue;
    const Status outcome = execute(command);
    if (outcome != Status::unfinished) commands_.finish(command.request, outcome);
  }
}

Status FlightLoop::execute(const telemetry::Telecommand& command) {
  switch (command.id) {
    case telemetry::TelecommandId::ping: commands_.pong(); return Status::ok;
    case telemetry::TelecommandId::start: return start();
    case telemetry::TelecommandId::stop: return stop();
    case telemetry::TelecommandId::restart: return restart_estimate();
    case telemetry::TelecommandId::health: send_health(); return Status::ok;
    case telemetry::TelecommandId::set_tai: break;
  }
  const Status status = lines_.name_next_pulse(command.argument);
  if (status != Status::ok) return status;
  naming_request_ = command.request;
  return Status::unfinished;
}

Status FlightLoop::restart_estimate() {
  if (report_.mode == Mode::standby) return Status::not_configured;
  const RelativeState state = report_.state;  // of this step's frame: it was good
  give_up_estimate(Status::ok);
  report_.state = state;
  without_update_ = 0;
  return Status::ok;
}

// ---- telemetry ----

void FlightLoop::send_packets() {
  report_.refused_updates = static_cast<std::uint16_t>(std::min<std::uint32_t>(counts_.refused_updates, 0xFFFFU));
  if (report_.status == Status::no_data || report_.status == Status::timeout) return;
  events_.count_frame();
  if (telemetry_.dropped() != reported_drops_) {
    reported_drops_ = telemetry_.dropped();
    events_.report(EventId::telemetry_dropped, Status::no_capacity, {reported_drops_});
  }
  if (report_.processed) {
    latency_.packet(clock_);
    telemetry_.send_state(report_, stamp_, {has_estimate_, config_.is_scale_known(), report_.predicted});
    if (config_.features_every_frames > 0 && (counts_.processed - 1U) % config_.features_every_frames == 0) {
      telemetry_.send_features(report_, stamp_);
    }
  }
  if (config_.health_every_frames == 0) return;
  if (health_due_ || (events_.frames() - 1U) % config_.health_every_frames == 0) send_health();
}

void FlightLoop::send_health() {
  telemetry::HealthPacket p;
  p.time_ns = static_cast<std::uint64_t>(stamp_.time.ns);
  p.frame_sequence = stamp_.sequence;
  p.mode = static_cast<std::uint8_t>(report_.mode);
  constexpr std::array<std::uint8_t, config::max_cameras> streaming{telemetry::health::camera_streaming,
                                                                    telemetry::health::second_camera_streaming};
  for (std::size_t c = 0; c < intake_.cameras(); ++c) {
    const CameraFeed& feed = intake_.feed(c);
    if (!feed.is_lost()) p.flags |= streaming[c];
    p.frames_refused = saturated_sum(p.frames_refused, feed.counts().refused);
    p.frames_lost = saturated_sum(p.frames_lost, feed.counts().missing);
    p.camera_losses = saturated_sum(p.camera_losses, feed.counts().losses);
  }
  if (navigator_->has_started()) p.flags |= telemetry::health::filter_running;
  p.last_status = static_cast<std::uint8_t>(report_.status);
  p.frames_processed = counts_.processed;
  p.frames_incomplete = intake_.incomplete();
  p.features = report_.features;
  p.matched = report_.matched;
  p.inliers = report_.inliers;
  p.refused_updates = counts_.refused_updates;
  p.reset_counter = static_cast<std::uint16_t>(report_.reset_counter & 0xFFFFU);
  p.test_ratio = static_cast<float>(report_.test_ratio);
  const LatencyMeter::Latencies largest = latency_.take_largest();
  p.latency_us = latency_.latest().from_exposure_us;
  p.latency_max_us = largest.from_exposure_us;
  p.arrival_latency_us = latency_.latest().from_arrival_us;
  p.arrival_latency_max_us = largest.from_arrival_us;
  telemetry_.send_health(p);
}

}  // namespace relnav::app
