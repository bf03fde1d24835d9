// FrameMate: the second camera's frame of the same time, and no lease lost on the way.
#include "fsw/app/frame_mate.hpp"

#include <array>
#include <initializer_list>

#include "platform/host/scripted_camera.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::FrameMate;
using platform::host::ScriptedCamera;

namespace {

constexpr Duration tolerance{1'000'000};
constexpr Duration wait{5'000'000};

constexpr Time at_ms(double ms) { return Time{static_cast<std::int64_t>(ms * 1e6)}; }

}  // namespace

TEST_GROUP(FrameMate) {
  ScriptedCamera camera{2, 64};
  FrameMate mate{&camera};
  std::array<std::uint8_t, 16> pixels{};
  std::uint32_t sequence = 0;
  hal::Frame frame;

  void setup() override { CHECK_TRUE(mate.start() == Status::ok); }
  void script(std::initializer_list<double> times_ms) {
    for (const double ms : times_ms) {
      CHECK_TRUE(camera.push_frame(pixels, 4, 4, at_ms(ms), sequence++) == Status::ok);
    }
  }
  Status acquire(double ms) { return mate.acquire(at_ms(ms), tolerance, wait, frame); }
};

TEST(FrameMate, ExistsWithACamera) {
  CHECK_TRUE(mate.exists());
  CHECK_FALSE(FrameMate(nullptr).exists());
}

TEST(FrameMate, PairsFramesWithinTheTolerance) {
  script({100.0, 199.0, 301.0});
  for (std::uint32_t k = 0; k < 3; ++k) {
    CHECK_TRUE(acquire(100.0 * (k + 1)) == Status::ok);
    LONGS_EQUAL(k, frame.sequence);
    LONGS_EQUAL(1, camera.leases_out());
    CHECK_TRUE(mate.release(frame) == Status::ok);
    LONGS_EQUAL(0, camera.leases_out());
  }
}

TEST(FrameMate, DropsOlderFramesAndGivesTheirLeasesBack) {
  script({70.0, 80.0, 98.999, 100.0, 110.0});
  CHECK_TRUE(acquire(100.0) == Status::ok);
  LONGS_EQUAL(3, frame.sequence);
  LONGS_EQUAL(1, camera.leases_out());
  LONGS_EQUAL(4, camera.frames_handed_out());
}

TEST(FrameMate, KeepsAnEarlyFrameForTheNextOne) {
  script({101.001, 200.0});
  for (int k = 0; k < 3; ++k) {
    CHECK_TRUE(acquire(100.0) == Status::timeout);
    LONGS_EQUAL(1, camera.leases_out());  // it waits; no other is fetched
    LONGS_EQUAL(1, camera.frames_handed_out());
  }
  CHECK_TRUE(acquire(101.0) == Status::ok);
  LONGS_EQUAL(0, frame.sequence);
  CHECK_TRUE(mate.release(frame) == Status::ok);
  CHECK_TRUE(acquire(200.0) == Status::ok);  // it is handed out once
  LONGS_EQUAL(1, frame.sequence);
  LONGS_EQUAL(1, camera.leases_out());
}

TEST(FrameMate, DropsAFrameThatWaitedTooLong) {
  script({150.0, 200.0});
  CHECK_TRUE(acquire(100.0) == Status::timeout);
  CHECK_TRUE(acquire(200.0) == Status::ok);
  LONGS_EQUAL(1, frame.sequence);
  LONGS_EQUAL(1, camera.leases_out());
}

TEST(FrameMate, PassesErrorsOnAndTheWait) {
  CHECK_TRUE(camera.push_status(Status::timeout) == Status::ok);
  CHECK_TRUE(camera.push_status(Status::incomplete) == Status::ok);
  CHECK_TRUE(camera.push_status(Status::device_lost) == Status::ok);
  frame.sequence = 77;
  CHECK_TRUE(acquire(100.0) == Status::timeout);
  CHECK_TRUE(acquire(100.0) == Status::incomplete);
  CHECK_TRUE(acquire(100.0) == Status::device_lost);
  LONGS_EQUAL(77, frame.sequence);
  LONGS_EQUAL(0, camera.leases_out());
  CHECK_TRUE(camera.calls()[1].wait == wait);
}

TEST(FrameMate, PassesARefusedReleaseOn) {
  script({50.0, 100.0});
  camera.fail_releases(Status::device_lost);
  CHECK_TRUE(acquire(100.0) == Status::device_lost);
}

TEST(FrameMate, DropsOnlySoManyInOneCall) {
  for (int k = 0; k < 20; ++k) script({10.0 + k});
  script({100.0});
  CHECK_TRUE(acquire(100.0) == Status::timeout);
  LONGS_EQUAL(16, camera.frames_handed_out());
  LONGS_EQUAL(0, camera.leases_out());
  CHECK_TRUE(acquire(100.0) == Status::ok);
  LONGS_EQUAL(20, frame.sequence);
}

TEST(FrameMate, StopGivesTheWaitingFrameBack) {
  script({150.0, 150.0});
  CHECK_TRUE(acquire(100.0) == Status::timeout);
  LONGS_EQUAL(1, camera.leases_out());
  CHECK_TRUE(mate.stop() == Status::ok);
  LONGS_EQUAL(0, camera.leases_out());
  CHECK_FALSE(camera.streaming());
  // And it is not handed out after a new start.
  CHECK_TRUE(mate.start() == Status::ok);
  CHECK_TRUE(acquire(150.0) == Status::ok);
  LONGS_EQUAL(1, frame.sequence);
  CHECK_TRUE(mate.release(frame) == Status::ok);
  CHECK_TRUE(mate.release(frame) == Status::stale_handle);
}

TEST(FrameMate, StopStopsTheCameraEvenIfItKeepsTheFrame) {
  script({150.0});
  CHECK_TRUE(acquire(100.0) == Status::timeout);
  camera.fail_releases(Status::device_lost);
  CHECK_TRUE(mate.stop() == Status::device_lost);
  CHECK_FALSE(camera.streaming());
}
