#include "hil/simulation/simulated_camera.hpp"

#include <algorithm>

#include "hil/serve/image_fault.hpp"

namespace relnav::hil {
namespace {

/// From the end of the exposure to the whole frame in memory.
constexpr Duration readout{2'000'000};
/// What a start in vain takes.
constexpr Duration start_attempt{50'000'000};
constexpr hal::ExposureLimits exposure_limits{Duration{1'000}, Duration{1'000'000'000}, 1.0, 64.0};

}  // namespace

SimulatedCamera::SimulatedCamera(std::vector<PlannedFrame> frames, std::vector<Fault> faults, SimulatedClock& clock,
                                 FrameMaker make, const hal::Exposure& exposure)
    : frames_(std::move(frames)),
      faults_(std::move(faults)),
      clock_(clock),
      make_(std::move(make)),
      exposure_(exposure),
      next_exposure_(exposure),
      back_(clock.simulated()) {}

const Fault* SimulatedCamera::fault_at(FaultKind kind, std::size_t number) const {
  for (const Fault& fault : faults_) {
    if (fault.kind == kind && fault.hits(number)) return &fault;
  }
  return nullptr;
}

Time SimulatedCamera::due(std::size_t number) const {
  return frames_[number].time + Duration{exposure_of(number).time.ns / 2} + readout;
}

const hal::Exposure& SimulatedCamera::exposure_of(std::size_t number) const {
  return number < changed_from_ ? exposure_ : next_exposure_;
}

bool SimulatedCamera::is_away() const { return clock_.simulated() < back_; }

Status SimulatedCamera::start() {
  if (is_away()) {
    clock_.advance_to(clock_.simulated() + start_attempt, clock_.simulated() + start_attempt);
    if (is_away()) return Status::device_lost;
  }
  streaming_ = true;
  lost_ = false;
  changed_from_ = next_;  // it is set up anew before it streams
  // What was exposed while nobody listened is gone.
  while (next_ < frames_.size() && due(next_) < clock_.simulated()) ++next_;
  return Status::ok;
}

Status SimulatedCamera::stop() {
  streaming_ = false;
  return Status::ok;
}

std::size_t SimulatedCamera::frames_done() const {
  const auto out = std::count_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.lease != 0; });
  return next_ - static_cast<std::size_t>(out);
}

Status SimulatedCamera::await_due(std::size_t number, Duration wait) {
  const Time now = clock_.simulated();
  const Time when = due(number);
  const Time next = number + 1 < frames_.size() ? due(number + 1) : when + start_attempt;
  if (when <= now + wait) {
    clock_.advance_to(when, next);
    return Status::ok;
  }
  clock_.advance_to(now + wait, when);
  return wait.ns > 0 ? Status::timeout : Status::no_data;
}

std::shared_ptr<Image> SimulatedCamera::expose(std::size_t number) {
  // A frozen sensor repeats what it gave last, to the byte.
  if (fault_at(FaultKind::frozen, number) != nullptr && shown_) return shown_;
  auto image = std::make_shared<Image>();
  make_(number, exposure_of(number), *image);
  if (fault_at(FaultKind::torn, number) != nullptr && shown_) tear(*image, *shown_);
  if (fault_at(FaultKind::black, number) != nullptr) fill(*image, 0x00);
  if (fault_at(FaultKind::white, number) != nullptr) fill(*image, 0xFF);
  return image;
}

Status SimulatedCamera::acquire(Duration wait, hal::Frame& frame) {
  if (lost_) return Status::device_lost;
  if (!streaming_) return Status::not_configured;
  const auto slot = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.lease == 0; });
  if (slot == slots_.end()) return Status::no_capacity;
  std::size_t number = next_;
  while (number < frames_.size() && fault_at(FaultKind::lost, number) != nullptr) ++number;
  if (number == frames_.size()) {
    next_ = number;
    return Status::no_data;
  }
  const Status there = await_due(number, wait);
  if (there != Status::ok) return there;

  next_ = number + 1;
  const Duration exposed = exposure_of(number).time;
  if (exposure_line_) {
    const Time begin = frames_[number].time + Duration{-exposed.ns / 2};
    exposure_line_(begin, begin + exposed);
  }
  if (const Fault* away = fault_at(FaultKind::unplug, number)) {
    unplug(Duration{static_cast<std::int64_t>(away->amount * 1e6)});
    return Status::device_lost;
  }
  if (fault_at(FaultKind::packets, number) != nullptr) return Status::incomplete;
  try {
    slot->image = expose(number);
  } catch (const std::exception& error) {
    if (problem_.empty()) problem_ = error.what();
    return Status::incomplete;
  }
  shown_ = slot->image;
  last_.time = frames_[number].stamp;
  last_.image = slot->image;
  slot->lease = ++last_lease_;
  const Image& image = *slot->image;
  frame = {};
  frame.pixels = image.bytes.data();
  frame.width_px = image.width_px;
  frame.height_px = image.height_px;
  frame.stride_bytes = image.bytes_per_pixel * image.width_px;
  frame.format = image.bytes_per_pixel == 2 ? hal::PixelFormat::mono16 : hal::PixelFormat::mono8;
  frame.mid_exposure = frame.first_data = frame.dequeued = last_.time;
  frame.clock = exposure_line_ ? clock_.id() : hal::ClockId::device;
  frame.sequence = static_cast<std::uint32_t>(number);
  frame.exposure = exposed;
  frame.lease = slot->lease;
  return Status::ok;
}

Status SimulatedCamera::release(const hal::Frame& frame) {
  if (frame.lease == 0) return Status::stale_handle;
  const auto slot = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.lease == frame.lease; });
  if (slot == slots_.end()) return Status::stale_handle;
  slot->lease = 0;
  return Status::ok;
}

void SimulatedCamera::let_pass() {
  if (streaming_ || next_ == frames_.size()) return;
  const Time when = due(next_);
  clock_.advance_to(when, next_ + 1 < frames_.size() ? due(next_ + 1) : when + start_attempt);
  last_.time = frames_[next_].stamp;
  ++next_;
}

void SimulatedCamera::unplug(Duration away) {
  back_ = clock_.simulated() + away;
  streaming_ = false;
  lost_ = true;
}

Status SimulatedCamera::limits(hal::ExposureLimits& limits) {
  if (lost_) return Status::device_lost;
  if (!streaming_) return Status::not_configured;
  limits = exposure_limits;
  return Status::ok;
}

Status SimulatedCamera::set(const hal::Exposure& wanted, hal::Exposure& applied) {
  if (lost_) return Status::device_lost;
  if (!streaming_) return Status::not_configured;
  const bool inside = wanted.time >= exposure_limits.time_min && wanted.time <= exposure_limits.time_max &&
                      wanted.gain >= exposure_limits.gain_min && wanted.gain <= exposure_limits.gain_max;
  if (!inside) return Status::invalid_argument;
  exposure_ = exposure_of(next_);
  next_exposure_ = wanted;
  changed_from_ = next_ + 1;
  applied = wanted;
  return Status::ok;
}

}  // namespace relnav::hil
