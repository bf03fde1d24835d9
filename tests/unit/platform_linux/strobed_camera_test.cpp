#include "platform/linux/strobed_camera.hpp"

#include <CppUTest/TestHarness.h>

#include <array>

#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_gpio_lines.hpp"
#include "platform/linux/gpiod_lines.hpp"
#include "tests/support/fake_gpio_backend.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::hal::Frame;
using relnav::platform::host::GpioCall;
using relnav::platform::host::ScriptedGpioLines;

/// Notes the level of the line while it is waited for a frame.
class WatchingCamera final : public relnav::hal::Camera {
 public:
  explicit WatchingCamera(const ScriptedGpioLines& lines) : lines_(lines) {}
  Status start() override { return Status::ok; }
  Status acquire(Duration, Frame& frame) override {
    lit_ = lines_.level(2);
    if (answer_ == Status::ok) frame.lease = 1;
    return answer_;
  }
  Status release(const Frame&) override { return Status::ok; }
  Status stop() override { return Status::ok; }
  std::uint32_t max_leases() const override { return 2; }

  Status answer_ = Status::ok;
  bool lit_ = false;

 private:
  const ScriptedGpioLines& lines_;
};

}  // namespace

TEST_GROUP(StrobedCamera) {
  ScriptedGpioLines lines{8};
  WatchingCamera inner{lines};
  relnav::platform::linux::StrobedCamera camera{inner, lines, 2};
  Frame frame;
  void setup() override { CHECK_TRUE(lines.request_output(2, false) == Status::ok); }
  std::size_t sets() const {
    std::size_t count = 0;
    for (const GpioCall& call : lines.calls()) count += call.kind == GpioCall::Kind::set ? 1U : 0U;
    return count;
  }
};

TEST(StrobedCamera, LineIsHighWhileItIsWaitedAndLowAfterwards) {
  CHECK_TRUE(camera.start() == Status::ok);
  for (const Status answer : {Status::ok, Status::timeout, Status::incomplete, Status::io_error}) {
    inner.answer_ = answer;
    inner.lit_ = false;
    CHECK_TRUE(camera.acquire({1000}, frame) == answer);
    CHECK_TRUE(inner.lit_);
    CHECK_FALSE(lines.level(2));
  }
  LONGS_EQUAL(8, sets());
  LONGS_EQUAL(0, camera.line_failures());
}

TEST(StrobedCamera, NoLightForAFrameThatCannotBeTaken) {
  CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);  // not started
  LONGS_EQUAL(0, sets());
  CHECK_TRUE(camera.start() == Status::ok);
  for (int i = 0; i < 2; ++i) CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);
  LONGS_EQUAL(4, sets());
  CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);  // all leases out
  LONGS_EQUAL(4, sets());
  CHECK_TRUE(camera.release(frame) == Status::ok);
  CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);
  LONGS_EQUAL(6, sets());
  CHECK_TRUE(camera.stop() == Status::ok);
  CHECK_TRUE(camera.release(frame) == Status::ok);
  CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);
  LONGS_EQUAL(6, sets());
}

TEST(StrobedCamera, AFailingLineIsCountedAndFramesComeAllTheSame) {
  CHECK_TRUE(camera.start() == Status::ok);
  lines.fail_calls(Status::io_error, 1);
  CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);
  LONGS_EQUAL(1, camera.line_failures());
  CHECK_TRUE(camera.line_status() == Status::io_error);
  lines.lose_device();
  CHECK_TRUE(camera.release(frame) == Status::ok);
  CHECK_TRUE(camera.acquire({1000}, frame) == Status::ok);
  LONGS_EQUAL(3, camera.line_failures());
  CHECK_TRUE(camera.line_status() == Status::device_lost);
}

TEST(StrobedCamera, ALostLineIsRequestedAgainNowAndThen) {
  relnav::test::FakeGpioBackend backend{8};
  relnav::platform::linux::GpiodLines real{backend};
  CHECK_TRUE(real.open_path("fake") == Status::ok);
  CHECK_TRUE(real.request_output(2, false) == Status::ok);
  relnav::platform::linux::StrobedCamera strobed{inner, real, 2};
  CHECK_TRUE(strobed.start() == Status::ok);
  inner.answer_ = Status::timeout;
  backend.unplug();
  for (int i = 0; i < 40; ++i)
    CHECK_TRUE(strobed.acquire({1000}, frame) == Status::timeout);  // and one request in vain
  backend.plug();
  LONGS_EQUAL(1, backend.opens());
  for (int i = 0; i < 40; ++i) CHECK_TRUE(strobed.acquire({1000}, frame) == Status::timeout);
  LONGS_EQUAL(2, backend.opens());
  const std::uint64_t failures = strobed.line_failures();
  CHECK_TRUE(strobed.acquire({1000}, frame) == Status::timeout);
  LONGS_EQUAL(failures, strobed.line_failures());
}
