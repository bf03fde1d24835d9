#include "hil/serve/frame_player.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "hil/serve/image_fault.hpp"

namespace relnav::hil {
namespace {

using PlayerClock = std::chrono::steady_clock;
constexpr std::chrono::nanoseconds slice = std::chrono::milliseconds(100);
/// A frame that nobody took so long is unseen. Less would lose frames on a machine that is busy for a moment.
constexpr std::chrono::nanoseconds most_late = std::chrono::seconds(1);

bool sleep_until(PlayerClock::time_point when, const std::function<bool()>& stop) {
  while (!stop()) {
    const auto left = when - PlayerClock::now();
    if (left <= left.zero()) return true;
    std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(left, slice));
  }
  return false;
}

template <typename Change>
std::shared_ptr<const Image> changed(const Image& image, Change change) {
  auto copy = std::make_shared<Image>(image);
  change(*copy);
  return copy;
}

}  // namespace

FramePlayer::FramePlayer(FrameSource& source, PlayerSettings settings)
    : source_(source), settings_(std::move(settings)) {
  const std::size_t count = source_.count();
  const std::int64_t span = (source_.stamp(count - 1) - source_.stamp(0)).ns;
  constexpr std::int64_t usual_step_ns = 100'000'000;
  loop_ns_ = span + (count > 1 ? span / static_cast<std::int64_t>(count - 1) : usual_step_ns);
}

std::int64_t FramePlayer::capture_ns(std::uint64_t number) const {
  const std::uint64_t count = source_.count();
  return source_.stamp(static_cast<std::size_t>(number % count)).ns +
         static_cast<std::int64_t>(number / count) * loop_ns_;
}

const Fault* FramePlayer::fault_at(FaultKind kind, std::uint64_t number) const {
  for (const Fault& fault : settings_.faults) {
    if (fault.kind == kind && fault.hits(number)) return &fault;
  }
  return nullptr;
}

std::shared_ptr<const Image> FramePlayer::image_before(std::uint64_t number, std::uint64_t steps) {
  return source_.image(static_cast<std::size_t>((number - std::min(number, steps)) % source_.count()));
}

FramePlayer::Content FramePlayer::content_of(std::uint64_t number) {
  Content content;
  content.image = source_.image(static_cast<std::size_t>(number % source_.count()));
  if (const Fault* frozen = fault_at(FaultKind::frozen, number))
    content.image = image_before(number, number - frozen->frame + 1);
  if (fault_at(FaultKind::torn, number) != nullptr)
    content.image = changed(*content.image, [&](Image& image) { tear(image, *image_before(number, 1)); });
  if (fault_at(FaultKind::black, number) != nullptr)
    content.image = changed(*content.image, [](Image& image) { fill(image, 0x00); });
  if (fault_at(FaultKind::white, number) != nullptr)
    content.image = changed(*content.image, [](Image& image) { fill(image, 0xFF); });
  ServedFrame& frame = content.frame;
  frame.image = content.image.get();
  frame.number = number;
  frame.stamp = {capture_ns(number)};
  for (const Fault& fault : settings_.faults) {
    if (fault.kind == FaultKind::time_jump && number >= fault.frame)
      frame.stamp = frame.stamp + Duration{static_cast<std::int64_t>(fault.amount * 1e9)};
  }
  frame.lost = fault_at(FaultKind::lost, number) != nullptr;
  if (const Fault* packets = fault_at(FaultKind::packets, number))
    frame.packets_lost_per_mille = static_cast<std::uint32_t>(packets->amount);
  return content;
}

PlayedFrames FramePlayer::play(FrameSink& sink, const std::function<bool()>& stop, const std::function<void()>& ready) {
  PlayedFrames played;
  const bool lock_step = settings_.speed <= 0.0;
  bool begun = false;
  PlayerClock::time_point start;
  const auto due = [&](std::uint64_t number) {
    const auto since_first = static_cast<double>(capture_ns(number) - capture_ns(0));
    return start + std::chrono::nanoseconds(static_cast<std::int64_t>(since_first / settings_.speed));
  };
  sink.plug(source_.shape());
  if (ready) ready();
  PlayerClock::time_point back;  // since when the camera is there
  for (std::uint64_t number = 0; !stop() && (settings_.loop || number < source_.count()); ++number) {
    if (const Fault* away = fault_at(FaultKind::unplug, number)) {
      sink.unplug();
      const auto pause = std::chrono::nanoseconds(static_cast<std::int64_t>(away->amount * 1e6));
      if (!sleep_until(PlayerClock::now() + pause, stop)) return played;
      sink.plug(source_.shape());
      if (ready) ready();
      back = PlayerClock::now();
    }
    if (begun && !lock_step && due(number) < back) {
      ++played.unseen;
      continue;
    }
    if (begun && !lock_step && PlayerClock::now() > due(number) + most_late) {
      ++played.unseen;  // not even decoded: a machine that decodes too slowly shows fewer frames, not none
      continue;
    }
    const Content content = content_of(number);
    if (begun && !lock_step && !sleep_until(due(number), stop)) break;
    bool taken = false;
    bool offered = false;
    while (!taken && !stop()) {
      std::chrono::nanoseconds wait = slice;
      if (begun && !lock_step) {
        wait = std::max<std::chrono::nanoseconds>(due(number) + most_late - PlayerClock::now(), wait.zero());
        if (offered && wait == wait.zero()) break;
      }
      offered = true;
      taken = sink.write(content.frame, Duration{std::min(wait, slice).count()});
    }
    if (!taken && stop()) break;
    if (!taken)
      ++played.unseen;
    else if (content.frame.lost)
      ++played.lost;
    else
      ++played.sent;
    if (taken && !begun) {
      begun = true;
      if (!lock_step) start = PlayerClock::now() - (due(number) - start);
    }
  }
  sink.unplug();
  return played;
}

}  // namespace relnav::hil
