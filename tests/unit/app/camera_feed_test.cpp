// CameraFeed: one lease at a time, given back once; lost, silent and greedy cameras are started anew.
#include "fsw/app/camera_feed.hpp"

#include <array>

#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_clock.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::CameraFeed;
using platform::host::CameraCall;
using platform::host::ScriptedCamera;

namespace {
constexpr Duration wait{5'000'000};
}

TEST_GROUP(CameraFeed) {
  ScriptedCamera camera{2, 64};
  platform::host::ScriptedClock clock;
  CameraFeed feed{&camera, clock};
  std::array<std::uint8_t, 16> pixels{};
  std::uint32_t sequence = 0;

  void setup() override {
    app::FrameLimits limits;
    limits.min_contrast = 0;
    limits.refuse_frozen = false;
    feed.configure(limits, Duration{3 * wait.ns}, 4, 4, 8);
    CHECK_TRUE(feed.start() == Status::ok);
  }
  void script(std::int64_t ms, std::uint32_t width_px = 4, std::uint32_t height_px = 4) {
    CHECK_TRUE(camera.push_frame(pixels, width_px, height_px, Time{ms * 1'000'000}, sequence++) == Status::ok);
  }
  const app::FeedOutcome& fetch() {
    feed.begin_step();
    feed.fetch(wait);
    return feed.outcome();
  }
  std::size_t releases() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < camera.calls().size(); ++i) {
      if (camera.calls()[i].kind == CameraCall::Kind::release) ++count;
    }
    return count;
  }
};

TEST(CameraFeed, HoldsOneFrameUntilItIsGivenBack) {
  script(100);
  script(200);
  CHECK_TRUE(fetch().status == Status::ok);
  CHECK_TRUE(feed.has_frame());
  CHECK_TRUE(fetch().status == Status::no_data);  // nothing new: it is held
  LONGS_EQUAL(1, camera.leases_out());
  LONGS_EQUAL(1, camera.frames_handed_out());
  CHECK_TRUE(feed.give_back() == Status::ok);
  LONGS_EQUAL(0, camera.leases_out());
  CHECK_TRUE(fetch().status == Status::ok);
  CHECK_TRUE(feed.frame().mid_exposure == Time{200'000'000});
}

TEST(CameraFeed, ARefusedFrameIsGivenBackAtOnce) {
  script(100, 2, 8);
  const app::FeedOutcome& outcome = fetch();
  CHECK_TRUE(outcome.refused && outcome.received);
  CHECK_TRUE(outcome.status == Status::invalid_argument);
  CHECK_FALSE(feed.has_frame());
  LONGS_EQUAL(0, camera.leases_out());
  LONGS_EQUAL(1, feed.counts().refused);
}

TEST(CameraFeed, CountsFramesThatAreMissing) {
  script(100);
  CHECK_TRUE(fetch().status == Status::ok);
  CHECK_TRUE(feed.give_back() == Status::ok);
  sequence += 3;
  script(500);
  CHECK_TRUE(fetch().check.gap);
  LONGS_EQUAL(3, feed.counts().missing);
}

TEST(CameraFeed, ALostCameraIsStartedOnceInAStep) {
  CHECK_TRUE(camera.push_status(Status::device_lost) == Status::ok);
  camera.fail_starts(Status::device_lost, 2);
  CHECK_TRUE(fetch().lost_for == Status::device_lost);
  CHECK_TRUE(feed.is_lost());
  for (int k = 0; k < 2; ++k) {
    const app::FeedOutcome& outcome = fetch();
    CHECK_TRUE(outcome.status == Status::device_lost);
    CHECK_TRUE(outcome.lost_for == Status::ok);  // told once
    LONGS_EQUAL(0, outcome.attempts);
  }
  script(100);
  LONGS_EQUAL(3, fetch().attempts);
  CHECK_FALSE(feed.is_lost());
  CHECK_TRUE(feed.has_frame());
  LONGS_EQUAL(1, feed.counts().losses);
}

TEST(CameraFeed, SilenceCountsByTheWaits) {
  CHECK_TRUE(fetch().status == Status::timeout);
  CHECK_TRUE(fetch().status == Status::timeout);
  feed.begin_step();
  feed.fetch({}, wait);  // the wait was for another camera
  CHECK_TRUE(feed.outcome().lost_for == Status::timeout);
  CHECK_TRUE(feed.outcome().status == Status::device_lost);
  script(100);
  CHECK_TRUE(fetch().status == Status::ok);
  CHECK_TRUE(feed.silence() == Duration{0});
}

TEST(CameraFeed, AFrameEndsTheSilence) {
  for (int k = 0; k < 5; ++k) {
    CHECK_TRUE(fetch().status == Status::timeout);
    CHECK_TRUE(fetch().status == Status::timeout);
    script(100 * (k + 1));
    CHECK_TRUE(fetch().status == Status::ok);
    CHECK_TRUE(feed.give_back() == Status::ok);
  }
  CHECK_FALSE(feed.is_lost());
}

TEST(CameraFeed, ALeaseThatTheCameraKeepsIsGivenBackOnceMoreBeforeTheNewStart) {
  script(100);
  CHECK_TRUE(fetch().status == Status::ok);
  camera.fail_releases(Status::io_error);
  CHECK_TRUE(feed.give_back() == Status::io_error);
  CHECK_TRUE(feed.is_lost());
  CHECK_FALSE(feed.has_frame());
  LONGS_EQUAL(1, camera.leases_out());
  script(200);
  CHECK_TRUE(fetch().status == Status::ok);
  LONGS_EQUAL(1, camera.leases_out());  // of the new frame
  LONGS_EQUAL(2, releases());
}

TEST(CameraFeed, ALeaseTheCameraDoesNotKnowIsNotOfferedAgain) {
  script(100);
  CHECK_TRUE(fetch().status == Status::ok);
  CHECK_TRUE(camera.release(feed.frame()) == Status::ok);  // behind its back
  CHECK_TRUE(feed.give_back() == Status::stale_handle);
  CHECK_TRUE(feed.is_lost());
  LONGS_EQUAL(2, releases());
  static_cast<void>(fetch());
  LONGS_EQUAL(2, releases());
}

TEST(CameraFeed, StopGivesTheFrameBackAndForgetsIt) {
  script(100);
  script(200);
  CHECK_TRUE(fetch().status == Status::ok);
  CHECK_TRUE(feed.stop() == Status::ok);
  LONGS_EQUAL(0, camera.leases_out());
  CHECK_FALSE(camera.streaming());
  CHECK_FALSE(feed.has_frame());
  CHECK_TRUE(feed.start() == Status::ok);
  CHECK_TRUE(fetch().frame.sequence == 1);
}

TEST(CameraFeed, StopStopsTheCameraEvenIfItKeepsTheFrame) {
  script(100);
  CHECK_TRUE(fetch().status == Status::ok);
  camera.fail_releases(Status::io_error);
  CHECK_TRUE(feed.stop() == Status::io_error);
  CHECK_FALSE(camera.streaming());
  CHECK_FALSE(feed.has_frame());
}

TEST(CameraFeed, ACameraErrorIsAnIncompleteFrame) {
  for (const Status error : {Status::incomplete, Status::io_error}) {
    CHECK_TRUE(camera.push_status(error) == Status::ok);
    const app::FeedOutcome& outcome = fetch();
    CHECK_TRUE(outcome.damaged());
    CHECK_TRUE(outcome.reason == error);
  }
  CHECK_FALSE(feed.is_lost());
}
