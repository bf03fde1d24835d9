#include "hil/capture/capture_run.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

namespace relnav::hil {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr Duration longest_wait{100'000'000};

class CaptureRun {
 public:
  CaptureRun(platform::linux::StreamCamera& camera, FrameRecorder& recorder, const CaptureLimits& limits,
             const std::function<bool(const CaptureCounts&)>& go_on)
      : camera_(camera), recorder_(recorder), limits_(limits), go_on_(go_on) {}

  CaptureOutcome run() {
    while (outcome_.problem.empty() && wants_more() && go_on_(outcome_.counts)) step();
    recorder_.finish();
    outcome_.counts.underruns = camera_.counts().underruns;
    give_back_all();
    if (camera_.stop() != Status::ok && outcome_.problem.empty()) outcome_.problem = camera_.problem();
    if (recorder_.has_failed()) outcome_.problem = recorder_.problem();
    outcome_.counts.streaming = {std::chrono::duration_cast<std::chrono::nanoseconds>(last_ - first_).count()};
    return outcome_;
  }

 private:
  [[nodiscard]] bool wants_more() const {
    return !recorder_.has_failed() && (limits_.frames == 0 || offered_ < limits_.frames);
  }

  /// Status of release(): what is wrong with the device is told by the next acquire().
  void give_back_all() {
    while (const auto frame = recorder_.take_back()) static_cast<void>(camera_.release(*frame));
  }

  void step() {
    give_back_all();
    hal::Frame frame;
    switch (camera_.acquire(longest_wait, frame)) {
      case Status::ok: take(frame); break;
      case Status::incomplete: ++outcome_.counts.incomplete; break;
      case Status::timeout:
      case Status::no_data: break;
      default: ++outcome_.counts.camera_losses; reopen();
    }
  }

  void reopen() {
    const bool open = open_camera(camera_, limits_.patience, [this] {
      give_back_all();  // it is not opened again while images of its former stream are out
      return go_on_(outcome_.counts);
    });
    if (!open) outcome_.problem = camera_.problem();
  }

  void take(const hal::Frame& frame) {
    CaptureCounts& counts = outcome_.counts;
    last_ = SteadyClock::now();
    if (counts.received++ == 0) first_ = last_;
    numbers_ = frame.sequence + std::uint64_t{1};
    counts.missing = numbers_ - std::min(numbers_, counts.received + counts.incomplete);
    if (recorder_.offer(frame, camera_.gain())) {
      ++offered_;
      return;
    }
    if (!recorder_.has_failed()) counts.without_room.push_back(frame.sequence);
    static_cast<void>(camera_.release(frame));
  }

  platform::linux::StreamCamera& camera_;
  FrameRecorder& recorder_;
  const CaptureLimits& limits_;
  const std::function<bool(const CaptureCounts&)>& go_on_;
  CaptureOutcome outcome_;
  std::uint64_t offered_ = 0;
  std::uint64_t numbers_ = 0;  ///< that the camera has given out
  SteadyClock::time_point first_;
  SteadyClock::time_point last_;
};

}  // namespace

bool open_camera(platform::linux::StreamCamera& camera, Duration patience, const std::function<bool()>& go_on) {
  const auto end = SteadyClock::now() + std::chrono::nanoseconds(patience.ns);
  while (go_on()) {
    const Status status = camera.start();
    if (status == Status::ok) return true;
    if (status == Status::invalid_argument || status == Status::unsupported || SteadyClock::now() > end) break;
    const Duration pause{std::clamp<std::int64_t>(camera.until_next_attempt().ns, 5'000'000, longest_wait.ns)};
    std::this_thread::sleep_for(std::chrono::nanoseconds(pause.ns));
  }
  return false;
}

CaptureOutcome run_capture(platform::linux::StreamCamera& camera, FrameRecorder& recorder, const CaptureLimits& limits,
                           const std::function<bool(const CaptureCounts&)>& go_on) {
  return CaptureRun(camera, recorder, limits, go_on).run();
}

std::string ranges_text(const std::vector<std::uint32_t>& numbers) {
  constexpr int most_ranges = 10;
  std::string text;
  int ranges = 0;
  for (std::size_t begin = 0; begin < numbers.size();) {
    std::size_t end = begin + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    if (++ranges > most_ranges) return text + ", ...";
    if (!text.empty()) text += ", ";
    text += std::to_string(numbers[begin]);
    if (end - begin > 1) text += "-" + std::to_string(numbers[end - 1]);
    begin = end;
  }
  return text;
}

}  // namespace relnav::hil
