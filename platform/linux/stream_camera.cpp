#include "platform/linux/stream_camera.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "platform/linux/pixel_conversion.hpp"

namespace relnav::platform::linux {
namespace {

constexpr std::uint32_t largest_side_px = 16384;
constexpr int most_waiting = 64;  // frames looked at in one acquire(): more than any driver's buffers
constexpr double ns_per_s = 1e9;

/// Of one lease. The depth that is not fixed by the settings is taken as 16 bits.
std::size_t mono_bytes(const CameraSettings& settings) {
  if (std::max(settings.width_px, settings.height_px) > largest_side_px) return 0;  // refused by check_settings()
  const auto format = format_named(settings.format);
  const auto depth = format ? mono_format(*format) : hal::PixelFormat::mono16;
  return static_cast<std::size_t>(row_bytes(depth, settings.width_px)) * settings.height_px;
}

/// Readers take 16-bit pixels as such.
bool is_aligned(const RawImage& image) {
  if (mono_format(image.format) == hal::PixelFormat::mono8) return true;
  return std::bit_cast<std::uintptr_t>(image.bytes.data()) % 2 == 0 && image.stride_bytes % 2 == 0;
}

std::string ms_text(Duration duration) { return std::to_string(duration.ns / 1'000'000) + " ms"; }

std::string size_text(std::uint32_t width_px, std::uint32_t height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px);
}

}  // namespace

StreamCamera::StreamCamera(CameraDriver& driver, hal::Clock& clock, CameraSettings settings, StreamOptions options)
    : driver_(driver),
      clock_(clock),
      settings_(std::move(settings)),
      options_(options),
      frame_timeout_(options.frame_timeout),
      device_clock_(options.max_clock_drift_ppm),
      leases_(std::max(options.leases, 1U)),
      memory_(leases_.size() * mono_bytes(settings_)) {
  if (frame_timeout_.ns > 0 && settings_.rate_hz > 0.0) {
    frame_timeout_.ns = std::max(frame_timeout_.ns, static_cast<std::int64_t>(3.0 * ns_per_s / settings_.rate_hz));
  }
}

StreamCamera::~StreamCamera() {
  if (driver_is_open_) driver_.close();
}

Status StreamCamera::check_settings() {
  const auto refuse = [this](const std::string& what) {
    problem_ = settings_.device + ": " + what;
    return Status::invalid_argument;
  };
  const std::uint32_t width = settings_.width_px;
  const std::uint32_t height = settings_.height_px;
  if (width == 0 || height == 0 || std::max(width, height) > largest_side_px) {
    return refuse("image size " + size_text(width, height) + ": each side has to be from 1 to " +
                  std::to_string(largest_side_px) + " px");
  }
  if (!settings_.format.empty() && !format_named(settings_.format)) {
    return refuse("there is no pixel format \"" + settings_.format + "\"");
  }
  if (settings_.rate_hz > 0.0 && settings_.exposure_us * settings_.rate_hz > 1e6) {
    return refuse("an exposure of " + std::to_string(settings_.exposure_us) + " us does not fit into a period at " +
                  std::to_string(settings_.rate_hz) + " Hz");
  }
  return Status::ok;
}

Status StreamCamera::start() {
  if (state_ == State::streaming) return Status::ok;
  if (until_next_attempt().ns > 0) return attempt_status_;
  const Status checked = check_settings();
  if (checked != Status::ok) return checked;
  if (loans_ > 0) {
    problem_ = settings_.device + ": not opened again while " + std::to_string(loans_) +
               " images of the former stream have not been given back";
    return Status::no_capacity;
  }
  ++counts_.attempts;
  attempt_status_ = driver_.open(settings_);
  if (attempt_status_ != Status::ok) {
    problem_ = driver_.problem();
    plan_next_attempt();
    return attempt_status_;
  }
  driver_is_open_ = true;
  state_ = State::streaming;
  if (was_lost_) ++counts_.reconnects;
  was_lost_ = has_frames_ = asked_ = has_range_ = false;
  last_sign_ = clock_.now();
  sequence_base_ = next_number_;
  device_clock_.forget();
  return Status::ok;
}

void StreamCamera::plan_next_attempt() {
  std::int64_t pause_ns = options_.shortest_retry.ns;
  for (std::uint32_t k = 0; k < failures_ && pause_ns < options_.longest_retry.ns; ++k) pause_ns *= 2;
  ++failures_;
  next_attempt_ = clock_.now() + Duration{std::min(pause_ns, options_.longest_retry.ns)};
}

Duration StreamCamera::until_next_attempt() const {
  if (state_ == State::streaming) return {};
  return {std::max<std::int64_t>((next_attempt_ - clock_.now()).ns, 0)};
}

Status StreamCamera::stop() {
  state_ = State::closed;
  close_driver_if_unused();
  return Status::ok;
}

void StreamCamera::close_driver_if_unused() {
  if (!driver_is_open_ || loans_ > 0) return;
  former_underruns_ += driver_.underruns();
  driver_.close();
  driver_is_open_ = false;
}

Status StreamCamera::lose(const std::string& problem) {
  problem_ = problem;
  state_ = State::lost;
  was_lost_ = true;
  ++counts_.losses;
  attempt_status_ = Status::device_lost;
  if (has_frames_) {
    next_attempt_ = clock_.now();  // it may be back already
  } else {
    plan_next_attempt();
  }
  close_driver_if_unused();
  return Status::device_lost;
}

Status StreamCamera::state_status() const {
  if (state_ == State::lost) return Status::device_lost;
  return state_ == State::closed ? Status::not_configured : Status::ok;
}

Status StreamCamera::exposure_range(ExposureRange& range) {
  const Status state = state_status();
  if (state != Status::ok) return state;
  if (!has_range_) {
    ExposureRange asked;
    const Status status = driver_.exposure_range(asked);
    if (status != Status::ok) {
      problem_ = driver_.problem();
      return status;
    }
    if (settings_.rate_hz > 0.0) asked.most_us = std::min(asked.most_us, 1e6 / settings_.rate_hz);
    range_ = asked;
    has_range_ = true;
  }
  range = range_;
  return Status::ok;
}

Status StreamCamera::adjust(ExposureValues& values) {
  const Status state = state_status();
  if (state != Status::ok) return state;
  ExposureValues made = values;
  const Status status = driver_.adjust(made);
  if (status != Status::ok) {
    problem_ = driver_.problem();
    return status;
  }
  values = made;
  settings_.exposure_us = made.exposure_us;
  if (made.gain >= 0.0) settings_.gain = made.gain;
  return Status::ok;
}

StreamCounts StreamCamera::counts() const {
  StreamCounts counts = counts_;
  counts.underruns = former_underruns_ + (driver_is_open_ ? driver_.underruns() : 0);
  return counts;
}

StreamCamera::Lease* StreamCamera::free_lease() {
  const auto lease = std::find_if(leases_.begin(), leases_.end(), [](const Lease& l) { return l.name == 0; });
  return lease == leases_.end() ? nullptr : &*lease;
}

std::span<std::uint8_t> StreamCamera::memory_of(const Lease& lease) {
  const std::size_t bytes = memory_.size() / leases_.size();
  return std::span(memory_).subspan(static_cast<std::size_t>(&lease - leases_.data()) * bytes, bytes);
}

Status StreamCamera::acquire(Duration wait, hal::Frame& frame) {
  if (state_ == State::lost) return Status::device_lost;
  if (state_ == State::closed) return Status::not_configured;
  Lease* const lease = free_lease();
  if (lease == nullptr) return Status::no_capacity;
  if (settings_.trigger == Trigger::software && ask_for_frame() != Status::ok) return lose(driver_.problem());

  Candidate candidate;
  Taken taken = take_one(Duration{std::max<std::int64_t>(wait.ns, 0)}, *lease, candidate);
  bool damaged = taken == Taken::damaged;
  if (options_.policy == FramePolicy::newest) {
    for (int k = 1; k < most_waiting && (taken == Taken::good || taken == Taken::damaged); ++k) {
      taken = take_one({}, *lease, candidate);
      damaged = damaged || taken == Taken::damaged;
    }
  }
  // Only what is handed out is converted, if possible: looking at a backlog must not make it longer.
  const bool handed_out = taken != Taken::failed && candidate.exists && hand_out(candidate, *lease, frame);
  if (handed_out) return Status::ok;
  if (taken == Taken::failed || candidate.exists) {
    if (candidate.exists) ++counts_.skipped;
    if (candidate.on_loan) --loans_;  // void with the driver
    return lose(problem_);
  }
  if (damaged) return Status::incomplete;
  return without_frame(wait.ns > 0 ? Status::timeout : Status::no_data);
}

Status StreamCamera::ask_for_frame() {
  const Time now = clock_.now();
  // A request or its answer may get lost: it is repeated before the silence counts as a loss.
  const bool is_due = !asked_ || (frame_timeout_.ns > 0 && (now - asked_at_).ns >= frame_timeout_.ns / 2);
  if (!is_due) return Status::ok;
  if (!asked_) last_sign_ = now;
  asked_ = true;
  asked_at_ = now;
  return driver_.trigger();
}

Status StreamCamera::without_frame(Status status) {
  if (settings_.trigger == Trigger::line) return status;  // nobody knows when the next one is due
  const Duration limit = has_frames_ ? frame_timeout_ : std::max(options_.first_frame_timeout, frame_timeout_);
  if (frame_timeout_.ns <= 0 || clock_.now() - last_sign_ < limit) return status;
  return lose(settings_.device + ": no frame for " + ms_text(limit));
}

StreamCamera::Taken StreamCamera::take_one(Duration wait, const Lease& lease, Candidate& candidate) {
  RawImage image;
  const Status status = driver_.take(wait, image);
  if (status == Status::no_data || status == Status::timeout) return Taken::nothing;
  if (status != Status::ok) {
    problem_ = driver_.problem();
    return Taken::failed;
  }
  last_sign_ = clock_.now();
  has_frames_ = true;
  failures_ = 0;
  asked_ = false;
  if (image.complete && (image.width_px != settings_.width_px || image.height_px != settings_.height_px)) {
    problem_ = settings_.device + ": an image of " + size_text(image.width_px, image.height_px) + " came, " +
               size_text(settings_.width_px, settings_.height_px) + " was asked for";
    return Taken::failed;
  }
  const Status layout = check_layout(image);
  if (!image.complete || layout == Status::incomplete) {
    ++counts_.incomplete;
    // What came of it may be without its number. Where frames are numbered the next whole one shows that this one is missing.
    if (!image.has_sequence) ++next_number_;
    return give_back(image.buffer) ? Taken::damaged : Taken::failed;
  }
  if (layout != Status::ok) {
    problem_ = settings_.device + ": rows of " + std::to_string(image.stride_bytes) + " bytes came, which " +
               std::to_string(image.width_px) + " pixels of " + name_of(image.format) + " do not fit";
    return Taken::failed;
  }
  if (candidate.exists) {
    ++counts_.skipped;
    candidate.exists = false;
    if (candidate.on_loan && !settle(candidate)) return Taken::failed;
  }
  candidate = {.exists = true, .on_loan = true, .image = image, .number = number_of(image)};
  ++loans_;
  // One loan is left for looking at what comes next.
  return loans_ < driver_.max_loans() || copy(candidate, lease) ? Taken::good : Taken::failed;
}

bool StreamCamera::settle(Candidate& candidate) {
  candidate.on_loan = false;
  --loans_;
  return give_back(candidate.image.buffer);
}

bool StreamCamera::copy(Candidate& candidate, const Lease& lease) {
  const RawImage& image = candidate.image;
  if (convert(image, memory_of(lease)) != Status::ok) {
    problem_ =
        settings_.device + ": images came as " + name_of(image.format) + ", " + settings_.format + " was asked for";
    return false;
  }
  return settle(candidate);
}

bool StreamCamera::give_back(std::uint32_t buffer) {
  if (driver_.give_back(buffer) == Status::ok) return true;
  problem_ = driver_.problem();
  return false;
}

std::uint64_t StreamCamera::number_of(const RawImage& image) {
  std::uint64_t number = next_number_;
  if (image.has_sequence) {
    if (sequence_base_ + image.sequence < next_number_) sequence_base_ = next_number_ - image.sequence;  // counts anew
    number = sequence_base_ + image.sequence;
  }
  next_number_ = number + 1;
  return number;
}

void StreamCamera::stamp(const RawImage& image, hal::Frame& frame) {
  frame.exposure = image.exposure;
  if (frame.exposure.ns <= 0) frame.exposure = {static_cast<std::int64_t>(settings_.exposure_us * 1000.0)};
  if (settings_.original_stamps) {
    frame.clock = hal::ClockId::device;
    frame.mid_exposure = frame.first_data = frame.dequeued = image.stamp;
    return;
  }
  const std::int64_t half_ns = frame.exposure.ns / 2;
  Time middle = image.stamp;
  if (image.stamp_meaning == StampMeaning::start_of_exposure) middle.ns += half_ns;
  if (image.stamp_meaning == StampMeaning::end_of_exposure) middle.ns -= half_ns;
  // Data come after the end of the exposure; seen from its middle they cannot be earlier than this.
  if (image.clock != hal::ClockId::monotonic) {
    middle = device_clock_.to_monotonic(middle, Time{image.first_data.ns - half_ns});
  }
  frame.clock = hal::ClockId::monotonic;
  frame.mid_exposure = middle;
  frame.first_data = image.first_data;
  frame.dequeued = image.dequeued;
}

bool StreamCamera::hand_out(Candidate& candidate, Lease& lease, hal::Frame& frame) {
  const RawImage& image = candidate.image;
  const bool can_lend = !options_.always_copy && is_mono(image.format) && is_aligned(image);
  if (candidate.on_loan && !can_lend && !copy(candidate, lease)) return false;
  ++last_lease_;
  if (last_lease_ == 0) ++last_lease_;  // 0 means free
  lease = {.name = last_lease_, .on_loan = candidate.on_loan, .buffer = image.buffer};
  frame.lease = lease.name;
  frame.width_px = image.width_px;
  frame.height_px = image.height_px;
  frame.format = mono_format(image.format);
  frame.pixels = lease.on_loan ? image.bytes.data() : memory_of(lease).data();
  frame.stride_bytes =
      lease.on_loan ? image.stride_bytes : static_cast<std::uint32_t>(row_bytes(frame.format, image.width_px));
  frame.sequence = static_cast<std::uint32_t>(candidate.number);
  stamp(image, frame);
  gain_ = image.gain;
  ++counts_.delivered;
  return true;
}

Status StreamCamera::release(const hal::Frame& frame) {
  const auto lease = std::find_if(leases_.begin(), leases_.end(),
                                  [&](const Lease& l) { return l.name != 0 && l.name == frame.lease; });
  if (lease == leases_.end()) return Status::stale_handle;
  const bool was_on_loan = std::exchange(lease->on_loan, false);
  lease->name = 0;
  if (!was_on_loan) return Status::ok;
  --loans_;
  if (state_ != State::streaming) {
    close_driver_if_unused();
  } else if (!give_back(lease->buffer)) {
    static_cast<void>(lose(problem_));  // the lease is over all the same; acquire() says so
  }
  return Status::ok;
}

}  // namespace relnav::platform::linux
