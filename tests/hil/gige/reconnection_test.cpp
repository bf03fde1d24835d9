// A camera that vanishes and comes back, seen through StreamCamera. RELNAV_CYCLES: how often (5).
#include <dirent.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "platform/host/steady_clock.hpp"
#include "platform/linux/aravis_driver.hpp"
#include "platform/linux/stream_camera.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;
using platform::linux::AravisDriver;
using platform::linux::StreamCamera;
using platform::linux::StreamOptions;

namespace {

std::size_t count_entries(const char* path) {
  std::size_t count = 0;
  DIR* const folder = ::opendir(path);
  while (::readdir(folder) != nullptr) ++count;
  ::closedir(folder);
  return count;
}

/// Allocated and not freed.
double heap_mb() {
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) * 1e-6;
}

/// Frames every 10 ms, of the caller's choice when there is a camera at all.
class BlinkingCamera {
 public:
  BlinkingCamera() : server_({served_address, served_serial}, false, {}) {}
  ~BlinkingCamera() { unplug(); }
  void plug() {
    server_.plug(source_.shape());
    sending_ = true;
    thread_ = std::thread([this] {
      while (sending_) {
        const auto image = source_.image(number_);
        hil::ServedFrame frame;
        frame.image = image.get();
        frame.stamp = source_.stamp(number_);
        frame.number = number_++;
        static_cast<void>(server_.write(frame, Duration{10'000'000}));
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    });
  }
  void unplug() {
    sending_ = false;
    if (thread_.joinable()) thread_.join();
    server_.unplug();
  }

 private:
  CountedFrames source_{640, 480, 1'000'000, 100.0};
  std::uint64_t number_ = 0;
  hil::GigeServer server_;
  std::atomic<bool> sending_ = false;
  std::thread thread_;
};

}  // namespace

TEST_GROUP(GigeReconnection) {
  void setup() override { enter_own_network(); }

  platform::host::SteadyClock clock;

  /// As a flight loop: until a frame comes. The longest single call goes into `longest`.
  bool frame_within(StreamCamera & camera, Duration limit, Duration & longest) {
    const Time start = clock.now();
    while (clock.now() - start < limit) {
      const Time before = clock.now();
      hal::Frame frame;
      const Status status = camera.acquire(Duration{20'000'000}, frame);
      if (status == Status::device_lost || status == Status::not_configured) {
        if (camera.start() != Status::ok) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      longest = std::max(longest, clock.now() - before);
      if (status != Status::ok) continue;
      return camera.release(frame) == Status::ok;
    }
    return false;
  }
};

TEST(GigeReconnection, FramesFlowAgainAndNothingLeaks) {
  const char* const text = std::getenv("RELNAV_CYCLES");
  const int cycles = text != nullptr ? std::atoi(text) : 5;
  const std::size_t files_before = count_entries("/proc/self/fd");
  const std::size_t threads_before = count_entries("/proc/self/task");
  Duration worst{};
  Duration longest{};
  const double heap_before_mb = heap_mb();
  {
    BlinkingCamera camera;
    AravisDriver driver;
    StreamOptions options;
    options.frame_timeout = Duration{300'000'000};
    StreamCamera stream(driver, clock, settings_for(640, 480), options);
    camera.plug();
    CHECK_TRUE(frame_within(stream, Duration{5'000'000'000}, longest));
    longest = {};
    for (int i = 0; i < cycles; ++i) {
      camera.unplug();
      static_cast<void>(frame_within(stream, Duration{30'000'000}, longest));  // one may have been on its way
      CHECK_FALSE(frame_within(stream, Duration{600'000'000}, longest));
      camera.plug();
      const Time back = clock.now();
      CHECK_TRUE(frame_within(stream, Duration{5'000'000'000}, longest));
      worst = std::max(worst, clock.now() - back);
      for (int frames = 0; frames < 5; ++frames) CHECK_TRUE(frame_within(stream, Duration{1'000'000'000}, longest));
    }
    CHECK_EQUAL(static_cast<std::uint64_t>(cycles), stream.counts().losses);
    CHECK_EQUAL(static_cast<std::uint64_t>(cycles), stream.counts().reconnects);
    CHECK_TRUE(stream.stop() == Status::ok);
  }
  std::printf(
      "%d times away: frames again after at most %.2f s, no call took longer than %.2f s, heap %.1f -> %.1f MB\n",
      cycles, worst.seconds(), longest.seconds(), heap_before_mb, heap_mb());
  CHECK_TRUE(heap_mb() < heap_before_mb + 4.0);  // a session has 20
  CHECK_TRUE(worst.ns < 2'000'000'000);
  CHECK_EQUAL(files_before, count_entries("/proc/self/fd"));
  CHECK_EQUAL(threads_before, count_entries("/proc/self/task"));
}
