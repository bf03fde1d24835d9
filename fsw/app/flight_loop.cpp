#include "fsw/app/flight_loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/base/crc16.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::app {
namespace {

using telemetry::EventId;

constexpr std::size_t first_camera = 0;
constexpr std::size_t second_camera = 1;
/// Whole seconds that a packet's time field can count.
constexpr std::int64_t most_seconds_ns = 4'294'967'295'999'999'999;

template <typename Count>
void increment(Count& count) {
  if (count < std::numeric_limits<Count>::max()) ++count;
}

EventId event_of(FrameFault fault) {
  switch (fault) {
    case FrameFault::size: return EventId::frame_refused_size;
    case FrameFault::format: return EventId::frame_refused_format;
    case FrameFault::age: return EventId::frame_refused_age;
    case FrameFault::no_contrast: return EventId::image_without_contrast;
    case FrameFault::frozen: return EventId::image_frozen;
    case FrameFault::none:
    case FrameFault::time_range:
    case FrameFault::time_order: break;
  }
  return EventId::frame_refused_out_of_order;
}

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
                       hal::Camera* second)
    : camera_(camera),
      clock_(clock),
      watchdog_(watchdog),
      navigators_(std::in_place_type<NoncoopNavigator>, clock),
      navigator_(std::get_if<NoncoopNavigator>(&navigators_)),
      mate_(second),
      telemetry_(link) {}

// ---- configuration and start ----

ConfigItem FlightLoop::validate(const FlightLoopConfig& config, CameraRig& rig) const {
  if (!add_camera(config.camera, Mat3::Identity(), Vec3::Zero(), rig)) return ConfigItem::camera;
  if (config.navigation == NavigationKind::coop_stereo) {
    const SecondCamera& second = config.second;
    if (!mate_.exists() || !(second.pair_tolerance.ns >= 0) ||
        !add_camera(second.intrinsics, second.R_C1C0, second.t_C1C0, rig)) {
      return ConfigItem::camera;
    }
  }
  const telemetry::PacketConfig& packets = config.packets;
  if (telemetry::validate(packets) != Status::ok || packets.epoch_offset_ns < 0 ||
      packets.epoch_offset_ns > most_seconds_ns) {
    return ConfigItem::packets;
  }
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
  if (refused != ConfigItem::none) {
    event(EventId::configuration_refused, Status::invalid_argument, {static_cast<std::int64_t>(refused)});
    return Status::invalid_argument;
  }
  const Status status = telemetry_.configure(config.packets, config.event_spacing_frames);
  if (status != Status::ok) return status;
  config_ = config;
  config_.frames.latest_time_ns =
      std::min(config.frames.latest_time_ns, most_seconds_ns - config.packets.epoch_offset_ns);
  const int sensor_bits = config.navigation == NavigationKind::noncoop ? 8 : config.coop.sensor_bits;
  cameras_ = {};
  for (std::size_t c = 0; c < rig.size(); ++c) {
    const CameraIntrinsics& k = rig[c].model.intrinsics();
    cameras_[c].checks.configure(config_.frames, static_cast<std::uint32_t>(k.width_px),
                                 static_cast<std::uint32_t>(k.height_px), sensor_bits);
  }
  watch_.configure(config.filter);
  watch_.restart();
  report_ = StepReport();
  counts_ = Counts();
  stamp_ = event_stamp_ = FrameStamp();
  has_estimate_ = false;
  without_update_ = 0;
  reported_drops_ = 0;
  configured_ = true;
  event(EventId::configuration_accepted, Status::ok, {crc_of(config)});
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

Status FlightLoop::start() {
  if (!configured_) return Status::not_configured;
  if (report_.mode != Mode::standby) return Status::invalid_argument;
  const bool stereo = config_.navigation == NavigationKind::coop_stereo;
  for (std::size_t c = 0; c < (stereo ? 2U : 1U); ++c) {
    const Status status = start_camera(c);
    if (status == Status::ok) continue;
    event(EventId::camera_lost, status, {static_cast<std::int64_t>(c)});
    if (c == second_camera) static_cast<void>(stop_camera(first_camera));  // the start has failed whatever it says
    return status;
  }
  without_update_ = 0;
  accept_new_time_base();
  change_mode(Mode::acquire, Status::ok);
  return Status::ok;
}

Status FlightLoop::stop() {
  if (report_.mode == Mode::standby) return Status::ok;
  navigator_->restart();
  watch_.restart();
  has_estimate_ = false;
  change_mode(Mode::standby, Status::ok);
  const bool stereo = config_.navigation == NavigationKind::coop_stereo;
  const Status mate_stopped = stereo ? stop_camera(second_camera) : Status::ok;
  const Status stopped = stop_camera(first_camera);
  return stopped != Status::ok ? stopped : mate_stopped;
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
  watchdog_status_ = watchdog_.kick();
  report_.times.total_ns = (clock_.now() - begin).ns;
  return report_;
}

void FlightLoop::begin_report() {
  report_.features = report_.matched = report_.inliers = 0;
  report_.dropped = 0;
  report_.test_ratio = 0.0;
  report_.feature_reports.clear();
  report_.times = StageTimes();
  frame_processed_ = health_due_ = false;
  event_stamp_ = stamp_;
}

Status FlightLoop::take_frame() {
  if (!is_there(first_camera)) {
    count_frame_without_update(Status::device_lost);
    return Status::device_lost;
  }
  const Time begin = clock_.now();
  hal::Frame frame;
  const Status acquired = camera_.acquire(config_.acquire_wait, frame);
  report_.times.acquire_ns = (clock_.now() - begin).ns;
  if (acquired != Status::ok) return without_frame(acquired);
  cameras_[first_camera].silence_ns = 0;
  const Status used = use_frame(frame);
  const Status released = camera_.release(frame);
  // A lease that cannot be given back would starve the camera: it is started anew.
  if (released != Status::ok) lose_camera(first_camera, released);
  return used;
}

Status FlightLoop::without_frame(Status reason) {
  switch (reason) {
    case Status::no_data: return reason;
    case Status::timeout:
      cameras_[first_camera].silence_ns += config_.acquire_wait.ns;
      if (cameras_[first_camera].silence_ns < config_.camera_silence.ns) return reason;
      health_due_ = true;
      lose_camera(first_camera, reason);
      if (report_.mode == Mode::track || report_.mode == Mode::acquire) give_up_estimate(reason);
      return Status::device_lost;
    case Status::device_lost:
    case Status::not_configured:
    case Status::no_capacity:
      lose_camera(first_camera, reason);
      count_frame_without_update(reason);
      return Status::device_lost;
    default:
      increment(counts_.incomplete);
      count_frame_without_update(reason);
      event(EventId::frame_incomplete, reason, {counts_.incomplete});
      return Status::incomplete;
  }
}

Status FlightLoop::use_frame(const hal::Frame& frame) {
  const FrameCheck check = cameras_[first_camera].checks.check(frame, clock_.now(), clock_.id());
  if (check.fault != FrameFault::time_range) event_stamp_ = {frame.mid_exposure, frame.sequence};
  if (check.gap) report_gap(frame, check);
  if (check.restart && (navigator_->has_started() || report_.mode == Mode::track)) give_up_estimate(Status::timeout);
  if (check.fault != FrameFault::none) {
    increment(counts_.refused);
    report_refusal(frame, check, config_.camera);
    count_frame_without_update(status_of(check.fault));
    return status_of(check.fault);
  }
  return use_pair(frame);
}

Status FlightLoop::use_pair(const hal::Frame& frame) {
  std::array<CameraImage, config::max_cameras> images{image_of(frame)};
  if (config_.navigation != NavigationKind::coop_stereo) return navigate(frame, {images.data(), 1});
  hal::Frame second;
  const bool paired = find_mate(frame, second);
  if (paired) images[second_camera] = image_of(second);
  const Status used = navigate(frame, images);
  if (paired) {
    const Status released = mate_.release(second);
    if (released != Status::ok) lose_camera(second_camera, released);
  }
  return used;
}

bool FlightLoop::find_mate(const hal::Frame& frame, hal::Frame& second) {
  if (!is_there(second_camera)) return false;
  CameraState& state = cameras_[second_camera];
  const Status found = mate_.acquire(frame.mid_exposure, config_.second.pair_tolerance, config_.acquire_wait, second);
  if (found != Status::ok) {
    without_mate(found);
    return false;
  }
  state.silence_ns = 0;
  const FrameCheck check = state.checks.check(second, clock_.now(), clock_.id());
  if (check.gap) report_gap(second, check);
  if (check.fault == FrameFault::none) return true;
  increment(counts_.refused);
  report_refusal(second, check, config_.second.intrinsics);
  const Status released = mate_.release(second);
  if (released != Status::ok) lose_camera(second_camera, released);
  return false;
}

void FlightLoop::without_mate(Status reason) {
  CameraState& state = cameras_[second_camera];
  switch (reason) {
    case Status::device_lost:
    case Status::not_configured:
    case Status::no_capacity: lose_camera(second_camera, reason); return;
    case Status::timeout:
      // A frame of a later time waits: this one's was missed.
      state.silence_ns = mate_.is_waiting() ? 0 : state.silence_ns + config_.acquire_wait.ns;
      if (state.silence_ns >= config_.camera_silence.ns) {
        lose_camera(second_camera, reason);
        return;
      }
      break;
    default: break;
  }
  increment(counts_.incomplete);
  event(EventId::frame_incomplete, reason, {counts_.incomplete});
}

/// What kept the navigator from starting, as an event.
Status FlightLoop::judge_start(Status status) {
  if (status == Status::too_few_features) {
    const bool coop = config_.navigation != NavigationKind::noncoop;
    event(EventId::too_few_features, status,
          {report_.matched, coop ? config_.coop.min_observations : config_.navigator.min_start_features});
  } else if (status == Status::ambiguous) {
    event(EventId::pose_ambiguous, status, {report_.matched});
  } else {
    event(EventId::numerical_fault, status);
  }
  count_frame_without_update(status);
  return status;
}

Status FlightLoop::navigate(const hal::Frame& frame, std::span<const CameraImage> images) {
  stamp_ = {frame.mid_exposure, frame.sequence};
  frame_processed_ = true;
  increment(counts_.processed);
  const bool was_started = navigator_->has_started();
  const Status status = navigator_->process(images, frame.mid_exposure, report_);
  if (report_.dropped > 0) event(EventId::spots_dropped, Status::no_capacity, {report_.dropped});
  if (!navigator_->has_started()) return judge_start(status);
  if (!was_started && report_.mode == Mode::lost) change_mode(Mode::acquire, Status::ok);
  if (!is_prediction_valid(status)) {
    event(EventId::numerical_fault, status);
    count_frame_without_update(status);
    return status;
  }
  if (status != Status::ok) {
    increment(counts_.refused_updates);
    event(EventId::update_refused, status, {in_thousandths(report_.test_ratio), report_.matched, report_.inliers});
  }
  const bool starting = navigator_->is_starting();
  const Status verdict = watch_.judge(navigator_->check(), report_.state, {status, report_.test_ratio, starting});
  if (verdict != Status::ok) {
    event(EventId::numerical_fault, verdict);
    give_up_estimate(verdict);
    return verdict;
  }
  has_estimate_ = true;
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
    event(EventId::track_acquired, Status::ok, {report_.features});
  }
  return Status::ok;
}

void FlightLoop::report_gap(const hal::Frame& frame, const FrameCheck& check) {
  const std::uint32_t room = 0xFFFFFFFFU - counts_.lost;
  counts_.lost += std::min(room, check.missing_by_sequence);
  event(EventId::frame_gap, Status::ok, {frame.sequence, check.previous_sequence, check.missing_frames});
}

void FlightLoop::report_refusal(const hal::Frame& frame, const FrameCheck& check, const CameraIntrinsics& expected) {
  EventArgs args{};
  switch (check.fault) {
    case FrameFault::size: args = {frame.width_px, frame.height_px, expected.width_px, expected.height_px}; break;
    case FrameFault::format: args = {static_cast<std::int64_t>(frame.format)}; break;
    case FrameFault::age: args = {frame.sequence, check.age.ns, config_.frames.max_age.ns}; break;
    case FrameFault::no_contrast: args = {check.darkest, check.brightest}; break;
    case FrameFault::frozen: args = {check.repeats}; break;
    case FrameFault::none:
    case FrameFault::time_range:
    case FrameFault::time_order: args = {frame.sequence, frame.mid_exposure.ns, check.previous_time.ns}; break;
  }
  // A scene without contrast or a frozen image is one happening, however long it lasts.
  const bool is_episode = check.fault == FrameFault::no_contrast || check.fault == FrameFault::frozen;
  if (is_episode && !check.first_in_a_row) return;
  event(event_of(check.fault), status_of(check.fault), args);
}

// ---- camera ----

Status FlightLoop::start_camera(std::size_t camera) {
  CameraState& state = cameras_[camera];
  const Status status = camera == first_camera ? camera_.start() : mate_.start();
  state.is_lost = status != Status::ok;
  state.silence_ns = 0;
  return status;
}

Status FlightLoop::stop_camera(std::size_t camera) { return camera == first_camera ? camera_.stop() : mate_.stop(); }

void FlightLoop::lose_camera(std::size_t camera, Status reason) {
  CameraState& state = cameras_[camera];
  if (state.is_lost) return;
  state.is_lost = true;
  state.recovery_attempts = 0;
  increment(counts_.camera_losses);
  event(EventId::camera_lost, reason, {static_cast<std::int64_t>(camera)});
}

bool FlightLoop::is_there(std::size_t camera) {
  CameraState& state = cameras_[camera];
  if (!state.is_lost) return true;
  increment(state.recovery_attempts);
  const Status stopped = stop_camera(camera);  // a camera that only fell silent still streams
  if (start_camera(camera) != Status::ok) return false;
  event(EventId::camera_recovered, stopped, {static_cast<std::int64_t>(camera), state.recovery_attempts});
  return true;
}

void FlightLoop::accept_new_time_base() {
  for (CameraState& state : cameras_) state.checks.accept_new_time_base();
}

// ---- modes ----

void FlightLoop::count_frame_without_update(Status reason) {
  increment(without_update_);
  if (without_update_ < config_.lost_after_frames) return;
  if (report_.mode == Mode::track || report_.mode == Mode::acquire) {
    give_up_estimate(reason);
  } else {
    accept_new_time_base();
  }
}

void FlightLoop::give_up_estimate(Status reason) {
  if (report_.mode == Mode::track) event(EventId::track_lost, reason, {without_update_, report_.features});
  if (navigator_->has_started()) {
    increment(report_.reset_counter);
    event(EventId::filter_reset, reason, {report_.reset_counter});
  }
  navigator_->restart();
  watch_.restart();
  accept_new_time_base();
  has_estimate_ = false;
  report_.state = RelativeState();
  if (report_.mode != Mode::lost) change_mode(Mode::lost, reason);
}

void FlightLoop::change_mode(Mode to, Status reason) {
  const Mode from = report_.mode;
  RELNAV_ASSERT(is_allowed(from, to));
  report_.mode = to;
  event(EventId::mode_changed, reason, {static_cast<std::int64_t>(from), static_cast<std::int64_t>(to)});
}

// ---- telemetry ----

void FlightLoop::event(EventId id, Status status, const EventArgs& args) {
  telemetry_.send_event(id, status, event_stamp_, counts_.frames, args);
}

void FlightLoop::send_packets() {
  report_.refused_updates = static_cast<std::uint16_t>(std::min<std::uint32_t>(counts_.refused_updates, 0xFFFFU));
  if (report_.status == Status::no_data || report_.status == Status::timeout) return;
  increment(counts_.frames);
  if (telemetry_.dropped() != reported_drops_) {
    reported_drops_ = telemetry_.dropped();
    event(EventId::telemetry_dropped, Status::no_capacity, {reported_drops_});
  }
  if (frame_processed_) {
    telemetry_.send_state(report_, stamp_, {has_estimate_, config_.is_scale_known()});
    if (config_.features_every_frames > 0 && (counts_.processed - 1U) % config_.features_every_frames == 0) {
      telemetry_.send_features(report_, stamp_);
    }
  }
  if (config_.health_every_frames == 0) return;
  if (health_due_ || (counts_.frames - 1U) % config_.health_every_frames == 0) send_health();
}

void FlightLoop::send_health() {
  telemetry::HealthPacket p;
  p.time_ns = static_cast<std::uint64_t>(stamp_.time.ns);
  p.frame_sequence = stamp_.sequence;
  p.mode = static_cast<std::uint8_t>(report_.mode);
  const bool streaming = std::none_of(cameras_.begin(), cameras_.end(), [](const CameraState& c) { return c.is_lost; });
  if (streaming) p.flags |= telemetry::health::camera_streaming;
  if (navigator_->has_started()) p.flags |= telemetry::health::filter_running;
  p.last_status = static_cast<std::uint8_t>(report_.status);
  p.frames_processed = counts_.processed;
  p.frames_refused = counts_.refused;
  p.frames_incomplete = counts_.incomplete;
  p.frames_lost = counts_.lost;
  p.camera_losses = counts_.camera_losses;
  p.features = report_.features;
  p.matched = report_.matched;
  p.inliers = report_.inliers;
  p.refused_updates = counts_.refused_updates;
  p.reset_counter = static_cast<std::uint16_t>(report_.reset_counter & 0xFFFFU);
  p.test_ratio = static_cast<float>(report_.test_ratio);
  telemetry_.send_health(p);
}

}  // namespace relnav::app
