#include <array>
#include <cstdint>
#include <vector>

#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_clock.hpp"
#include "tests/contract/camera_contract.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::platform::host::CameraCall;
using relnav::platform::host::ScriptedCamera;
using relnav::platform::host::ScriptedClock;

class ScriptedCameraHarness {
 public:
  ScriptedCameraHarness() : camera_(3, 64) {
    for (std::size_t i = 0; i < images_.size(); ++i) images_[i].fill(static_cast<std::uint8_t>(i));
    camera_.attach_clock(clock_);
  }
  relnav::hal::Camera& camera() { return camera_; }
  ScriptedCamera& script() { return camera_; }
  ScriptedClock& clock() { return clock_; }

  bool offer_frame() {
    ++sequence_;
    return camera_.push_frame(images_[sequence_ % images_.size()], 4, 4, Time{1000 * std::int64_t{sequence_}},
                              sequence_) == Status::ok;
  }
  bool offer_damaged_frame() {
    ++sequence_;
    return camera_.push_status(Status::incomplete) == Status::ok;
  }
  bool lose_device() {
    camera_.fail_starts(Status::device_lost);
    return camera_.push_status(Status::device_lost) == Status::ok;
  }
  void restore_device() {}
  Duration wait() const { return {1'000'000}; }
  Time now() const { return clock_.peek(); }
  Duration slack() const { return {0}; }

 private:
  std::array<std::array<std::uint8_t, 16>, 64> images_{};
  ScriptedClock clock_;
  ScriptedCamera camera_;
  std::uint32_t sequence_ = 0;
};

}  // namespace

RELNAV_CAMERA_CONTRACT(ScriptedCameraContract, ScriptedCameraHarness)

// What the script promises beyond the contract.
TEST_GROUP(ScriptedCamera) {
  ScriptedCameraHarness harness;
  relnav::hal::Frame frame;
  void setup() override { CHECK_TRUE(harness.camera().start() == Status::ok); }
};

TEST(ScriptedCamera, AnswersInTheOrderOfTheScript) {
  CHECK_TRUE(harness.script().push_status(Status::io_error) == Status::ok);
  CHECK_TRUE(harness.offer_frame());
  CHECK_TRUE(harness.script().push_status(Status::timeout) == Status::ok);
  CHECK_TRUE(harness.camera().acquire({}, frame) == Status::io_error);
  CHECK_TRUE(harness.camera().acquire({}, frame) == Status::ok);
  CHECK_TRUE(harness.camera().acquire({}, frame) == Status::timeout);
  CHECK_TRUE(harness.camera().acquire({}, frame) == Status::no_data);
  LONGS_EQUAL(0, harness.script().script_left());
}

TEST(ScriptedCamera, DelayIsUsedUpByWaiting) {
  CHECK_TRUE(harness.script().push_delay({250}) == Status::ok);
  CHECK_TRUE(harness.offer_frame());
  CHECK_TRUE(harness.camera().acquire({0}, frame) == Status::no_data);
  CHECK_TRUE(harness.camera().acquire({100}, frame) == Status::timeout);
  CHECK_TRUE(harness.camera().acquire({100}, frame) == Status::timeout);
  CHECK_TRUE(harness.camera().acquire({100}, frame) == Status::ok);
  CHECK_TRUE(harness.clock().peek().ns == 250);
}

TEST(ScriptedCamera, RecordsCallsAndAccountsForLeases) {
  CHECK_TRUE(harness.offer_frame());
  CHECK_TRUE(harness.camera().acquire({100}, frame) == Status::ok);
  LONGS_EQUAL(1, harness.script().leases_out());
  harness.script().fail_releases(Status::io_error);
  CHECK_TRUE(harness.camera().release(frame) == Status::io_error);
  LONGS_EQUAL(1, harness.script().leases_out());
  CHECK_TRUE(harness.camera().release(frame) == Status::ok);
  LONGS_EQUAL(0, harness.script().leases_out());
  LONGS_EQUAL(1, harness.script().frames_handed_out());
  const auto& calls = harness.script().calls();
  LONGS_EQUAL(4, calls.size());
  CHECK_TRUE(calls[0].kind == CameraCall::Kind::start);
  CHECK_TRUE(calls[1].kind == CameraCall::Kind::acquire);
  CHECK_TRUE(calls[1].wait.ns == 100);
  LONGS_EQUAL(1, calls[1].sequence);
  CHECK_TRUE(calls[2].kind == CameraCall::Kind::release);
  CHECK_TRUE(calls[2].answer == Status::io_error);
  CHECK_TRUE(calls[3].lease == calls[1].lease);
}

TEST(ScriptedCamera, FullScriptRefuses) {
  ScriptedCamera small(1, 1);
  CHECK_TRUE(small.push_status(Status::timeout) == Status::ok);
  CHECK_TRUE(small.push_status(Status::timeout) == Status::no_capacity);
  CHECK_TRUE(small.push_status(Status::ok) == Status::invalid_argument);
  CHECK_TRUE(small.push_delay({-1}) == Status::invalid_argument);
  CHECK_TRUE(small.push_frame({}, 4, 4, Time{0}, 0) == Status::invalid_argument);
}
