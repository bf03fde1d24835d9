// The simulated camera and clock behind the HAL: the contracts that every camera, exposure control and clock keeps, and faults.
#include <algorithm>
#include <set>
#include <stdexcept>

#include "hil/simulation/simulated_camera.hpp"
#include "tests/contract/camera_contract.hpp"
#include "tests/contract/clock_contract.hpp"
#include "tests/contract/exposure_control_contract.hpp"

namespace {

using namespace relnav;
using namespace relnav::hil;

constexpr std::int64_t period_ns = 100'000'000;
constexpr Time start_time{1'000'000'000};
constexpr hal::Exposure usual{Duration{2'000'000}, 1.0};

std::vector<PlannedFrame> planned(std::size_t count) {
  std::vector<PlannedFrame> frames;
  for (std::size_t k = 0; k < count; ++k) {
    const Time time = start_time + Duration{static_cast<std::int64_t>(k) * period_ns};
    frames.push_back({time, time});
  }
  return frames;
}

Image plain_image(std::uint8_t value) { return {4, 4, 1, std::vector<std::uint8_t>(16, value)}; }

/// A camera whose frames show their number; those in `damaged` cannot be made.
struct Rig {
  explicit Rig(std::vector<Fault> faults = {})
      : camera(
            planned(200), std::move(faults), clock,
            [this](std::size_t number, const hal::Exposure&, Image& image) {
              if (damaged.contains(number)) throw std::runtime_error("damaged");
              image = plain_image(static_cast<std::uint8_t>(number));
            },
            usual) {}
  SimulatedClock clock{start_time + Duration{-period_ns / 2}, false};
  std::set<std::size_t> damaged;
  SimulatedCamera camera;
};

class SimulatedCameraHarness {
 public:
  hal::Camera& camera() { return rig_.camera; }
  /// Simulated time goes on until shortly before the frame is there.
  bool offer_frame() {
    offered_ = std::max(offered_, rig_.camera.frames_done());
    const Time there = start_time + Duration{static_cast<std::int64_t>(offered_++) * period_ns + 3'000'000};
    rig_.clock.advance_to(there + Duration{-wait().ns / 2}, there);
    return true;
  }
  bool offer_damaged_frame() {
    rig_.damaged.insert(std::max(offered_, rig_.camera.frames_done()));
    return offer_frame();
  }
  bool lose_device() {
    rig_.camera.unplug(Duration{3'600'000'000'000});
    return true;
  }
  void restore_device() { rig_.camera.unplug(Duration{0}); }
  Duration wait() const { return {1'000'000}; }
  Time now() const { return rig_.clock.simulated(); }
  Duration slack() const { return {0}; }

 private:
  Rig rig_;
  std::size_t offered_ = 0;
};

class SimulatedExposureHarness {
 public:
  hal::ExposureControl& control() { return rig_.camera; }
  Status start() { return rig_.camera.start(); }
  bool lose_device() {
    rig_.camera.unplug(Duration{3'600'000'000'000});
    return true;
  }
  void restore_device() { rig_.camera.unplug(Duration{0}); }
  bool refuse_next() { return false; }
  Duration next_exposure() {
    hal::Frame frame;
    CHECK_TRUE(rig_.camera.acquire(Duration{10'000'000'000}, frame) == Status::ok);
    CHECK_TRUE(rig_.camera.release(frame) == Status::ok);
    return frame.exposure;
  }
  hal::Exposure in_device() { return rig_.camera.commanded(); }
  Time now() const { return rig_.clock.simulated(); }
  Duration slack() const { return {0}; }

 private:
  Rig rig_;
};

struct SimulatedClockHarness {
  SimulatedClock simulated{start_time, false};
  hal::Clock& clock() { return simulated; }
  void pass_time() {
    simulated.advance_to(simulated.simulated() + Duration{1000}, simulated.simulated() + Duration{2000});
  }
};

/// Takes the next frame.
Status take(SimulatedCamera& camera, hal::Frame& frame) {
  const Status status = camera.acquire(Duration{10 * period_ns}, frame);
  if (status == Status::ok) CHECK_TRUE(camera.release(frame) == Status::ok);
  return status;
}

}  // namespace

RELNAV_CAMERA_CONTRACT(SimulatedCameraContract, SimulatedCameraHarness)
RELNAV_EXPOSURE_CONTROL_CONTRACT(SimulatedExposureContract, SimulatedExposureHarness)
RELNAV_CLOCK_CONTRACT(SimulatedClockContract, SimulatedClockHarness)

TEST_GROUP(SimulatedCamera){};

TEST(SimulatedCamera, AFrameComesWhenItHasBeenExposedAndReadOut) {
  Rig rig;
  hal::Frame frame;
  CHECK_TRUE(rig.camera.start() == Status::ok);
  CHECK_TRUE(rig.camera.acquire(Duration{0}, frame) == Status::no_data);
  CHECK_TRUE(rig.camera.acquire(Duration{1'000'000}, frame) == Status::timeout);
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  CHECK_TRUE(frame.mid_exposure == start_time);
  CHECK_TRUE(rig.clock.simulated() == start_time + Duration{usual.time.ns / 2 + 2'000'000});
  CHECK_TRUE(rig.clock.now() < start_time + Duration{period_ns + 3'000'000});
}

TEST(SimulatedCamera, FaultsDoWhatTheySay) {
  Rig rig({{FaultKind::lost, 1, 2, 0.0},
           {FaultKind::frozen, 4, 2, 0.0},
           {FaultKind::torn, 7, 1, 0.0},
           {FaultKind::black, 9, 1, 0.0},
           {FaultKind::white, 10, 1, 0.0},
           {FaultKind::packets, 11, 1, 20.0}});
  hal::Frame frame;
  CHECK_TRUE(rig.camera.start() == Status::ok);
  std::vector<std::pair<unsigned, unsigned>> seen;  // number, upper left pixel
  std::vector<unsigned> last_pixel;
  int incomplete = 0;
  while (rig.camera.frames_done() < 13) {
    const Status status = take(rig.camera, frame);
    if (status == Status::incomplete) {
      ++incomplete;
      continue;
    }
    CHECK_TRUE(status == Status::ok);
    seen.emplace_back(frame.sequence, frame.pixels[0]);
    last_pixel.push_back(frame.pixels[15]);
  }
  const std::vector<std::pair<unsigned, unsigned>> expected{{0, 0}, {3, 3}, {4, 3}, {5, 3},    {6, 6},
                                                            {7, 7}, {8, 8}, {9, 0}, {10, 255}, {12, 12}};
  CHECK_TRUE(seen == expected);
  LONGS_EQUAL(6, last_pixel[5]);  // torn: below, the image before
  LONGS_EQUAL(1, incomplete);
}

TEST(SimulatedCamera, UnpluggedItIsAwayForItsTimeAndFramesOfThatTimeAreGone) {
  Rig rig({{FaultKind::unplug, 2, 1, 450.0}});
  hal::Frame frame;
  CHECK_TRUE(rig.camera.start() == Status::ok);
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  CHECK_TRUE(take(rig.camera, frame) == Status::device_lost);
  const Time lost = rig.clock.simulated();
  int attempts = 0;
  while (rig.camera.start() != Status::ok && attempts < 100) ++attempts;
  CHECK_TRUE(attempts > 0 && attempts < 100);
  CHECK_TRUE(rig.clock.simulated() >= lost + Duration{450'000'000});
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  LONGS_EQUAL(7, frame.sequence);  // 2 to 6 were exposed while it was away
}

TEST(SimulatedCamera, AnExposureIsInForceFromTheFrameAfterTheNext) {
  Rig rig;
  hal::Frame frame;
  CHECK_TRUE(rig.camera.start() == Status::ok);
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  hal::Exposure applied;
  CHECK_TRUE(rig.camera.set({Duration{5'000'000}, 2.0}, applied) == Status::ok);
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  CHECK_TRUE(frame.exposure == usual.time);
  CHECK_TRUE(take(rig.camera, frame) == Status::ok);
  CHECK_TRUE(frame.exposure == Duration{5'000'000});
}
