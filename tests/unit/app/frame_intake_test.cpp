// FrameIntake: which frames belong together, whichever camera is early, late, lost or silent. Every test runs with the cameras in
// both orders.
#include "fsw/app/frame_intake.hpp"

#include <array>
#include <initializer_list>
#include <memory>

#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_clock.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::FrameEpoch;
using app::FrameIntake;
using platform::host::ScriptedCamera;

namespace {

constexpr Duration tolerance{1'000'000};
constexpr Duration wait{5'000'000};

constexpr Time at_ms(double ms) { return Time{static_cast<std::int64_t>(ms * 1e6)}; }

/// The intake between two cameras; `one` and `other` are the first and the second, or the other way round.
struct Pair {
  std::array<ScriptedCamera, 2> cameras{ScriptedCamera{2, 256}, ScriptedCamera{2, 256}};
  platform::host::ScriptedClock clock;
  FrameIntake intake{cameras[0], &cameras[1], clock};
  std::size_t one;
  std::size_t other;
  std::array<std::uint8_t, 16> pixels{};
  std::array<std::uint32_t, 2> sequence{};
  FrameEpoch epoch;

  explicit Pair(std::size_t first) : one(first), other(1 - first) {
    intake.configure({2, wait, tolerance, Duration{30'000'000'000}});
    app::FrameLimits limits;
    limits.min_contrast = 0;
    limits.refuse_frozen = false;
    for (std::size_t c = 0; c < 2; ++c) intake.feed(c).configure(limits, Duration{4 * wait.ns}, 4, 4, 8);
    std::size_t camera = 0;
    CHECK_TRUE(intake.start(camera) == Status::ok);
  }
  ~Pair() {
    CHECK_TRUE(intake.stop() == Status::ok);
    for (const ScriptedCamera& camera : cameras) LONGS_EQUAL(0, camera.leases_out());
  }
  void script(std::size_t c, std::initializer_list<double> times_ms) {
    for (const double ms : times_ms)
      CHECK_TRUE(cameras[c].push_frame(pixels, 4, 4, at_ms(ms), sequence[c]++) == Status::ok);
  }
  /// Gathers, notes which cameras gave an image, gives back.
  Status gather() {
    epoch = intake.gather();
    for (std::size_t c = 0; c < 2; ++c) CHECK_TRUE(intake.give_back(c) == Status::ok);
    return epoch.status;
  }
  bool has_image(std::size_t c) const { return !std::holds_alternative<std::monostate>(epoch.images[c]); }
  void check_pair(double ms) {
    CHECK_TRUE(gather() == Status::ok);
    CHECK_TRUE(has_image(0) && has_image(1));
    LONGS_EQUAL(FrameEpoch::no_camera, epoch.missing);
    LONGS_EQUAL(0, epoch.camera);
    CHECK_TRUE(epoch.stamp.time == at_ms(ms));
    check_leases(0, 0);
  }
  void check_lone(std::size_t c, double ms) {
    CHECK_TRUE(gather() == Status::ok);
    CHECK_TRUE(has_image(c));
    CHECK_FALSE(has_image(1 - c));
    LONGS_EQUAL(c, epoch.camera);
    CHECK_TRUE(epoch.stamp.time == at_ms(ms));
  }
  void check_missing(std::size_t c, Status reason) {
    LONGS_EQUAL(c, epoch.missing);
    CHECK_TRUE(epoch.missing_reason == reason);
  }
  void check_leases(std::uint32_t of_one, std::uint32_t of_other) {
    LONGS_EQUAL(of_one, cameras[one].leases_out());
    LONGS_EQUAL(of_other, cameras[other].leases_out());
  }
};

template <typename Test>
void both_ways(Test test) {
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}}) {
    const auto pair = std::make_unique<Pair>(first);
    test(*pair);
  }
}

}  // namespace

TEST_GROUP(FrameIntake){};

TEST(FrameIntake, PairsFramesWithinTheTolerance) {
  both_ways([](Pair& p) {
    p.script(0, {100.0, 200.0, 300.0});
    p.script(1, {100.0, 199.0, 301.0});
    for (const double ms : {100.0, 200.0, 300.0}) p.check_pair(ms);
    LONGS_EQUAL(0, p.intake.incomplete());
  });
}

TEST(FrameIntake, ALaterFrameWaitsOnItsLease) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0, 200.0, 300.0});
    p.script(p.other, {300.0});
    p.check_lone(p.one, 100.0);
    p.check_missing(p.other, Status::timeout);
    p.check_leases(0, 1);
    p.check_lone(p.one, 200.0);
    p.check_leases(0, 1);
    LONGS_EQUAL(1, p.cameras[p.other].frames_handed_out());
    p.check_pair(300.0);
    LONGS_EQUAL(2, p.intake.incomplete());
  });
}

TEST(FrameIntake, UnpairedFramesAreEpochsInTheirOrder) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0, 200.0});
    p.script(p.other, {150.0, 250.0});
    p.check_lone(p.one, 100.0);
    p.check_missing(p.other, Status::timeout);
    p.check_lone(p.other, 150.0);
    p.check_missing(p.one, Status::timeout);
    p.check_lone(p.one, 200.0);
    p.check_lone(p.other, 250.0);
  });
}

TEST(FrameIntake, AFrameThatComesAfterItsTimeIsDropped) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0, 200.0, 300.0});
    CHECK_TRUE(p.cameras[p.other].push_delay(Duration{2 * wait.ns + 1}) == Status::ok);
    p.script(p.other, {100.0, 200.0, 300.0});
    p.check_lone(p.one, 100.0);
    p.check_missing(p.other, Status::timeout);
    CHECK_TRUE(p.gather() == Status::ok);
    CHECK_TRUE(p.epoch.stamp.time == at_ms(200.0));
    p.check_pair(300.0);
    LONGS_EQUAL(3, p.cameras[p.other].frames_handed_out());
  });
}

TEST(FrameIntake, WaitsForTheMateOfAFrameThatCameDuringTheWait) {
  both_ways([](Pair& p) {
    CHECK_TRUE(p.cameras[p.one].push_delay(Duration{wait.ns + 1000}) == Status::ok);
    p.script(p.one, {100.0});
    p.script(p.other, {100.0});
    static_cast<void>(p.gather());
    if (p.one == 0) {  // asked first: there is a second wait for it
      CHECK_TRUE(p.has_image(0) && p.has_image(1));
    } else {
      CHECK_TRUE(p.has_image(p.other));
      p.check_missing(p.one, Status::timeout);
    }
  });
}

TEST(FrameIntake, OneLostTheOtherGoesOn) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0});
    p.script(p.other, {100.0, 200.0, 300.0, 400.0});
    p.check_pair(100.0);
    CHECK_TRUE(p.cameras[p.one].push_status(Status::device_lost) == Status::ok);
    p.cameras[p.one].fail_starts(Status::device_lost, 2);
    for (const double ms : {200.0, 300.0, 400.0}) {
      p.check_lone(p.other, ms);
      LONGS_EQUAL(FrameEpoch::no_camera, p.epoch.missing);  // lost, not missing
    }
    p.script(p.one, {500.0});
    p.script(p.other, {500.0});
    p.check_pair(500.0);
    LONGS_EQUAL(3, p.intake.feed(p.one).outcome().attempts);
  });
}

TEST(FrameIntake, BothLostIsDeviceLost) {
  both_ways([](Pair& p) {
    for (ScriptedCamera& camera : p.cameras) {
      CHECK_TRUE(camera.push_status(Status::device_lost) == Status::ok);
      camera.fail_starts(Status::io_error, 1);
    }
    for (int k = 0; k < 2; ++k) {
      CHECK_TRUE(p.gather() == Status::device_lost);
      LONGS_EQUAL(0, p.epoch.waited.ns);
    }
    p.script(0, {100.0});
    p.script(1, {100.0});
    p.check_pair(100.0);
  });
}

TEST(FrameIntake, ADamagedFrameLeavesTheOtherAlone) {
  both_ways([](Pair& p) {
    p.script(p.other, {100.0});
    CHECK_TRUE(p.cameras[p.one].push_status(Status::io_error) == Status::ok);
    p.check_lone(p.other, 100.0);
    p.check_missing(p.one, Status::io_error);
    for (ScriptedCamera& camera : p.cameras) CHECK_TRUE(camera.push_status(Status::incomplete) == Status::ok);
    CHECK_TRUE(p.gather() == Status::incomplete);
    CHECK_TRUE(p.epoch.damaged);
    LONGS_EQUAL(3, p.intake.incomplete());
  });
}

TEST(FrameIntake, ARefusedFrameLeavesTheOtherAlone) {
  both_ways([](Pair& p) {
    p.script(p.other, {100.0});
    CHECK_TRUE(p.cameras[p.one].push_frame(p.pixels, 2, 8, at_ms(100.0), 0) == Status::ok);
    p.check_lone(p.other, 100.0);
    LONGS_EQUAL(FrameEpoch::no_camera, p.epoch.missing);  // refused, not missing
    CHECK_TRUE(p.cameras[p.one].push_frame(p.pixels, 2, 8, at_ms(200.0), 1) == Status::ok);
    CHECK_TRUE(p.gather() == Status::invalid_argument);
    CHECK_TRUE(p.epoch.refused);
  });
}

TEST(FrameIntake, ASilentCameraIsAskedLastAndLostByItself) {
  both_ways([](Pair& p) {
    for (int k = 1; !p.intake.feed(p.one).is_lost(); ++k) {
      const std::size_t asked = p.cameras[p.one].calls().size();
      p.script(p.other, {100.0 * k});
      p.check_lone(p.other, 100.0 * k);
      // Once it has been silent it is asked after the other, and only once.
      if (k > 1) LONGS_EQUAL(asked + 1, p.cameras[p.one].calls().size());
      CHECK_TRUE(k < 5);
    }
    CHECK_FALSE(p.intake.feed(p.other).is_lost());
  });
}

TEST(FrameIntake, BothSilentAreLostAfterTheSameTime) {
  both_ways([](Pair& p) {
    for (int k = 0; k < 4; ++k) {
      CHECK_FALSE(p.intake.feed(0).is_lost() || p.intake.feed(1).is_lost());
      CHECK_TRUE(p.gather() == (k < 3 ? Status::timeout : Status::device_lost));
      CHECK_TRUE(p.epoch.waited == wait);
    }
    CHECK_TRUE(p.intake.feed(0).is_lost() && p.intake.feed(1).is_lost());
  });
}

TEST(FrameIntake, AGapOfOneCameraIsNoRestart) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0, 35'000.0, 70'000.0});
    p.script(p.other, {100.0, 20'000.0, 35'000.0, 70'000.0});
    p.check_pair(100.0);
    p.check_lone(p.other, 20'000.0);
    CHECK_FALSE(p.epoch.restart);
    p.check_pair(35'000.0);
    CHECK_FALSE(p.epoch.restart);
    p.check_pair(70'000.0);
    CHECK_TRUE(p.epoch.restart);
  });
}

TEST(FrameIntake, OneStampFarAheadDoesNotKeepTheCameraOut) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0, 4'000'000.0});
    p.script(p.other, {100.0});
    p.check_pair(100.0);
    for (int k = 2; k < 12; ++k) {
      p.script(p.other, {100.0 * k});
      p.check_lone(p.other, 100.0 * k);
    }
    p.check_leases(0, 0);
    p.script(p.one, {1200.0, 1300.0});
    p.script(p.other, {1200.0, 1300.0});
    p.check_lone(p.other, 1200.0);  // the first one back shows where its clock stands
    p.check_pair(1300.0);
  });
}

TEST(FrameIntake, TakesANewTimeBaseOfBoth) {
  both_ways([](Pair& p) {
    p.script(0, {5000.0});
    p.script(1, {5000.0});
    p.check_pair(5000.0);
    p.intake.accept_new_time_base();
    p.script(0, {10.0, 20.0});
    p.script(1, {10.0, 20.0});
    CHECK_TRUE(p.gather() == Status::out_of_order);  // earlier than the one received before
    p.check_pair(20.0);
  });
}

TEST(FrameIntake, AStartThatFailsStopsWhatHasStarted) {
  const auto p = std::make_unique<Pair>(std::size_t{0});
  CHECK_TRUE(p->intake.stop() == Status::ok);
  p->cameras[1].fail_starts(Status::io_error);
  std::size_t camera = 0;
  CHECK_TRUE(p->intake.start(camera) == Status::io_error);
  LONGS_EQUAL(1, camera);
  CHECK_FALSE(p->cameras[0].streaming());
}

TEST(FrameIntake, StopGivesBackTheFrameThatWaits) {
  both_ways([](Pair& p) {
    p.script(p.one, {100.0});
    p.script(p.other, {200.0});
    p.check_lone(p.one, 100.0);
    p.check_leases(0, 1);
    CHECK_TRUE(p.intake.stop() == Status::ok);
    p.check_leases(0, 0);
  });
}
