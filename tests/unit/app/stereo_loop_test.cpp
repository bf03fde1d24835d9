// The flight loop with two cameras: either may fail, the other is not harmed, no lease is lost.
#include <memory>

#include "fsw/telemetry/codec.hpp"
#include "tests/unit/app/loop_bench.hpp"
#include "tests/unit/app/spot_motion.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::Mode;
using telemetry::EventId;

TEST_GROUP(StereoLoop) {
  static constexpr int frames = 9;
  std::unique_ptr<test::LoopBench> bench;
  app::FlightLoopConfig config;
  std::array<std::vector<test::SpotImage>, 2> images;  // camera, frame
  std::vector<Vec3> t_CT;                              // true, of each frame
  std::array<std::uint32_t, 2> sequence{};

  void setup() override {
    test::SpotMotion scene;
    scene.rig = test::two_cameras();
    scene.target = test::eight_leds();
    for (int k = 0; k < frames; ++k) {
      scene.render();
      for (std::size_t c = 0; c < 2; ++c) images[c].push_back(scene.images[c]);
      t_CT.push_back(scene.pose.t_CT);
      scene.advance();
    }
    config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
    config.navigation = app::NavigationKind::coop_stereo;
    config.camera = scene.rig[0].model.intrinsics();
    config.second = {scene.rig[1].model.intrinsics(), scene.rig[1].R_KC, scene.rig[1].t_KC, Duration{1'000'000}};
    config.coop.target = scene.target;
    config.event_spacing_frames = 0;
    config.health_every_frames = 1;
    config.camera_silence = Duration{3 * config.acquire_wait.ns};
    set_up();
  }
  void set_up() {
    bench = std::make_unique<test::LoopBench>(true);
    bench->config = config;
    sequence = {};
    CHECK(bench->begin() == Status::ok);
  }
  /// Takes up what the test has changed in the configuration.
  void restart() {
    CHECK(bench->loop.stop() == Status::ok);
    CHECK(bench->begin() == Status::ok);
  }
  /// The test with the first camera, then with the second; no lease is left over.
  template <typename Test>
  void for_either(Test test) {
    for (std::size_t c = 0; c < 2; ++c) {
      set_up();
      test(c);
      CHECK(bench->loop.stop() == Status::ok);
      check_leases();
      LONGS_EQUAL(0, bench->undecodable());
    }
  }
  platform::host::ScriptedCamera& camera(std::size_t c) { return c == 0 ? bench->camera : bench->second; }
  static std::int64_t stamp_ns(int k) { return 1'000'000'000 + k * test::period_ns; }
  void push_image(std::size_t c, const test::SpotImage& image, int k, std::int64_t late_ns = 0) {
    CHECK(camera(c).push_frame(image.pixels(), test::spot_width_px, test::spot_height_px, Time{stamp_ns(k) + late_ns},
                               sequence[c]++) == Status::ok);
  }
  void push(std::size_t c, int k, std::int64_t late_ns = 0) {
    push_image(c, images[c][static_cast<std::size_t>(k)], k, late_ns);
  }
  void push_pair(int k) {
    push(0, k);
    push(1, k);
  }
  void check_pair(int k) {
    push_pair(k);
    check_step(16);
  }
  /// A frame of this camera only.
  void check_lone(std::size_t c, int k) {
    push(c, k);
    check_step(8);
    LONGS_EQUAL(c, bench->loop.report().camera);
  }
  void check_step(int inliers) {
    const app::StepReport& report = bench->step();
    CHECK(report.status == Status::ok);
    LONGS_EQUAL(inliers, report.inliers);
    check_leases();
  }
  void check_leases() {
    LONGS_EQUAL(0, bench->camera.leases_out());
    LONGS_EQUAL(0, bench->second.leases_out());
  }
  static std::int64_t number(std::size_t c) { return static_cast<std::int64_t>(c); }
  static int streaming(std::size_t c) {
    return c == 0 ? telemetry::health::camera_streaming : telemetry::health::second_camera_streaming;
  }
  void check_health_flags(int flags) { LONGS_EQUAL(flags, bench->packets<telemetry::HealthPacket>().back().flags); }
  std::vector<std::int64_t> cameras_of(EventId id) {
    std::vector<std::int64_t> cameras;
    for (const telemetry::EventPacket& p : bench->events(id)) cameras.push_back(p.args[0]);
    return cameras;
  }
};

TEST(StereoLoop, pairs_are_tracked_with_both) {
  for (int k = 0; k < 5; ++k) check_pair(k);
  CHECK(bench->loop.mode() == Mode::track);
  CHECK(bench->events(EventId::pair_incomplete).empty());
  for (const telemetry::RelStatePacket& p : bench->packets<telemetry::RelStatePacket>()) {
    LONGS_EQUAL(0, p.camera);
    LONGS_EQUAL(0, p.valid_flags & telemetry::valid::predicted);
  }
}

// ---- what may happen to either camera ----

TEST(StereoLoop, a_lost_camera_is_started_anew_while_the_other_goes_on) {
  for_either([&](std::size_t lost) {
    for (int k = 0; k < 3; ++k) check_pair(k);
    CHECK(camera(lost).push_status(Status::device_lost) == Status::ok);
    camera(lost).fail_starts(Status::device_lost, 2);
    for (int k = 3; k < 6; ++k) check_lone(1 - lost, k);
    CHECK(bench->loop.mode() == Mode::track);
    CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{number(lost)});
    CHECK(cameras_of(EventId::camera_recovered).empty());
    check_health_flags(telemetry::health::filter_running | streaming(1 - lost));
    check_pair(6);
    CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{number(lost)});
    LONGS_EQUAL(3, bench->events(EventId::camera_recovered)[0].args[1]);  // attempts
    check_health_flags(telemetry::health::filter_running | streaming(0) | streaming(1));
    CHECK(bench->events(EventId::pair_incomplete).empty());  // it was lost, that is told
    LONGS_EQUAL(0, bench->loop.report().reset_counter);
  });
}

TEST(StereoLoop, the_target_is_found_by_either_alone) {
  for_either([&](std::size_t lost) {
    camera(lost).fail_starts(Status::device_lost, 100);
    CHECK(camera(lost).push_status(Status::device_lost) == Status::ok);
    for (int k = 0; k < 4; ++k) check_lone(1 - lost, k);
    CHECK(bench->loop.mode() == Mode::track);
    const Vec3 error_m = bench->loop.report().state.t_CT - t_CT[3];  // in the first camera, whichever sees it
    CHECK(error_m.norm() < 0.02);
  });
}

TEST(StereoLoop, each_torn_image_of_a_pair_has_an_event_of_its_own) {
  test::SpotMotion scene;
  scene.rig = test::two_cameras();
  scene.target = test::eight_leds();
  scene.v_C = Vec3(0.4, -0.3, -0.2);
  scene.omega_C = Vec3(0.1, -0.15, 0.2);
  config.event_spacing_frames = 30;
  set_up();
  std::array<test::SpotImage, relnav::config::max_cameras> before;
  for (int k = 0; k < 9; ++k) {
    scene.render();
    const auto whole = scene.images;
    for (std::size_t c = 0; c < 2; ++c) {
      if (k == 6 || k == 7) scene.images[c].take_rows_of(before[c], 240);
      push_image(c, scene.images[c], k);
    }
    before = whole;
    CHECK(bench->step().status == Status::ok);
    scene.advance();
  }
  const auto events = bench->events(EventId::image_torn);
  LONGS_EQUAL(2, events.size());  // of the first torn pair; the second one's are too soon after it
  for (std::size_t c = 0; c < events.size(); ++c) {
    LONGS_EQUAL(c, events[c].args[0]);
    LONGS_EQUAL(6, events[c].frame_sequence);
    CHECK(events[c].args[1] > 180 && events[c].args[1] < 300);
    CHECK(events[c].args[2] >= 2);
  }
}

TEST(StereoLoop, both_lost_both_recovered) {
  for_either([&](std::size_t lost) {
    for (int k = 0; k < 3; ++k) check_pair(k);
    CHECK(camera(lost).push_status(Status::device_lost) == Status::ok);
    camera(lost).fail_starts(Status::device_lost, 2);
    check_lone(1 - lost, 3);
    CHECK(camera(1 - lost).push_status(Status::device_lost) == Status::ok);
    CHECK(bench->step().status == Status::device_lost);
    check_lone(1 - lost, 4);  // back, while the one lost before has failed to start
    check_pair(5);
    CHECK((cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{number(lost), number(1 - lost)}));
    CHECK((cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{number(1 - lost), number(lost)}));
    LONGS_EQUAL(2, bench->packets<telemetry::HealthPacket>().back().camera_losses);
  });
}

TEST(StereoLoop, both_lost_for_long_give_the_estimate_up) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  for (std::size_t c = 0; c < 2; ++c) {
    CHECK(camera(c).push_status(Status::device_lost) == Status::ok);
    camera(c).fail_starts(Status::device_lost, 10);
  }
  for (int k = 0; k < 10; ++k) {
    CHECK(bench->loop.mode() == Mode::track);
    CHECK(bench->step().status == Status::device_lost);
  }
  CHECK(bench->loop.mode() == Mode::lost);
  LONGS_EQUAL(1, bench->loop.report().reset_counter);
  LONGS_EQUAL(1, bench->events(EventId::track_lost).size());
  check_health_flags(0);
  static_cast<void>(bench->step());
  check_pair(5);
}

TEST(StereoLoop, a_missed_late_or_damaged_frame_is_told_and_done_without) {
  for_either([&](std::size_t bad) {
    for (int k = 0; k < 3; ++k) check_pair(k);
    push(1 - bad, 3);
    push(bad, 4);  // that of frame 3 was missed; this one waits
    CHECK(bench->step().status == Status::ok);
    LONGS_EQUAL(8, bench->loop.report().inliers);
    LONGS_EQUAL(1, camera(bad).leases_out());
    LONGS_EQUAL(0, camera(1 - bad).leases_out());
    push(1 - bad, 4);
    check_step(16);
    CHECK(camera(bad).push_status(Status::incomplete) == Status::ok);
    check_lone(1 - bad, 5);
    push(1 - bad, 6);
    push(bad, 6, 1'500'000);  // not of the same time: an epoch of its own
    CHECK(bench->step().status == Status::ok);
    LONGS_EQUAL(8, bench->loop.report().inliers);
    check_step(8);
    LONGS_EQUAL(bad, bench->loop.report().camera);
    check_pair(7);
    const auto incomplete = bench->events(EventId::pair_incomplete);
    LONGS_EQUAL(4, incomplete.size());
    const std::size_t missing[] = {bad, bad, bad, 1 - bad};
    const Status reasons[] = {Status::timeout, Status::incomplete, Status::timeout, Status::timeout};
    const std::int64_t stamps[] = {stamp_ns(3), stamp_ns(5), stamp_ns(6), stamp_ns(6) + 1'500'000};
    for (std::size_t i = 0; i < 4; ++i) {
      LONGS_EQUAL(missing[i], incomplete[i].args[0]);
      CHECK(incomplete[i].args[1] == stamps[i]);
      LONGS_EQUAL(i + 1, incomplete[i].args[2]);
      LONGS_EQUAL(static_cast<int>(reasons[i]), incomplete[i].status);
    }
    CHECK(bench->events(EventId::frame_incomplete).empty());
    CHECK(bench->events(EventId::camera_lost).empty());
    CHECK(bench->packets<telemetry::HealthPacket>().back().frames_incomplete == 4);
  });
}

TEST(StereoLoop, both_damaged_are_no_frame) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  for (std::size_t c = 0; c < 2; ++c) CHECK(camera(c).push_status(Status::incomplete) == Status::ok);
  CHECK(bench->step().status == Status::incomplete);
  LONGS_EQUAL(1, bench->events(EventId::frame_incomplete).size());
  CHECK(bench->events(EventId::pair_incomplete).empty());
  check_pair(3);
}

TEST(StereoLoop, a_frozen_dark_or_wrong_image_is_not_used) {
  for_either([&](std::size_t bad) {
    for (int k = 0; k < 3; ++k) check_pair(k);
    push_image(bad, images[bad][2], 3);
    check_lone(1 - bad, 3);
    LONGS_EQUAL(1, bench->events(EventId::image_frozen).size());
    const test::SpotImage dark;
    push_image(bad, dark, 4);
    check_lone(1 - bad, 4);
    LONGS_EQUAL(1, bench->events(EventId::image_without_contrast).size());
    const std::int64_t late_ns = 200'000;  // its event is about this frame, not about the other's
    CHECK(camera(bad).push_frame(images[bad][5].pixels(), 2 * test::spot_width_px, test::spot_height_px / 2,
                                 Time{stamp_ns(5) + late_ns}, sequence[bad]++) == Status::ok);
    check_lone(1 - bad, 5);
    const auto wrong = bench->events(EventId::frame_refused_size);
    LONGS_EQUAL(1, wrong.size());
    LONGS_EQUAL(test::spot_width_px, wrong[0].args[2]);
    CHECK(wrong[0].time_ns == static_cast<std::uint64_t>(stamp_ns(5) + late_ns));
    LONGS_EQUAL(sequence[bad] - 1, wrong[0].frame_sequence);
    check_pair(6);
    CHECK(bench->events(EventId::pair_incomplete).empty());  // these have events of their own
    LONGS_EQUAL(3, bench->packets<telemetry::HealthPacket>().back().frames_refused);
  });
}

TEST(StereoLoop, a_silent_camera_counts_as_lost) {
  for_either([&](std::size_t silent) {
    for (int k = 0; k < 3; ++k) check_pair(k);
    for (int k = 3; k < 6; ++k) check_lone(1 - silent, k);
    CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{number(silent)});
    CHECK(bench->loop.mode() == Mode::track);
    check_pair(6);
    CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{number(silent)});
  });
}

TEST(StereoLoop, both_silent_for_long_give_the_estimate_up) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  for (int k = 0; k < 2; ++k) CHECK(bench->step().status == Status::timeout);
  CHECK(bench->loop.mode() == Mode::track);
  CHECK(bench->step().status == Status::device_lost);
  CHECK(bench->loop.mode() == Mode::lost);
  CHECK((cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{0, 1}));
  check_pair(3);
}

TEST(StereoLoop, a_camera_that_keeps_its_lease_is_started_anew) {
  for_either([&](std::size_t greedy) {
    for (int k = 0; k < 3; ++k) check_pair(k);
    camera(greedy).fail_releases(Status::io_error);
    push_pair(3);
    CHECK(bench->step().status == Status::ok);
    CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{number(greedy)});
    LONGS_EQUAL(0, camera(1 - greedy).leases_out());
    check_pair(4);
    CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{number(greedy)});
  });
}

TEST(StereoLoop, features_are_those_of_the_camera_that_the_packet_names) {
  for_either([&](std::size_t lone) {
    bench->config.features_every_frames = 1;
    restart();
    for (int k = 0; k < 3; ++k) check_pair(k);
    push(lone, 3);
    check_step(8);
    const auto state = bench->packets<telemetry::RelStatePacket>().back();
    LONGS_EQUAL(lone, state.camera);
    LONGS_EQUAL(sequence[lone] - 1, state.frame_sequence);
    LONGS_EQUAL(100, state.quality);
    LONGS_EQUAL(8, bench->packets<telemetry::FeaturesPacket>().back().features_total);
  });
}

TEST(StereoLoop, a_pose_that_is_predicted_only_says_so) {
  for (int k = 0; k < 4; ++k) check_pair(k);
  const auto flag = [&] {
    return bench->packets<telemetry::RelStatePacket>().back().valid_flags & telemetry::valid::predicted;
  };
  LONGS_EQUAL(0, flag());
  // Bright spots, but none where the markers should be.
  test::SpotImage empty;
  empty.draw(Vec2(20.0, 20.0));
  for (std::size_t c = 0; c < 2; ++c) push_image(c, empty, 4);
  CHECK(bench->step().status == Status::ok);
  CHECK(bench->loop.report().predicted);
  LONGS_EQUAL(telemetry::valid::predicted, flag());
  LONGS_EQUAL(telemetry::valid::pose,
              bench->packets<telemetry::RelStatePacket>().back().valid_flags & telemetry::valid::pose);
  check_pair(5);
  LONGS_EQUAL(0, flag());
}

TEST(StereoLoop, stop_gives_back_the_frame_that_waits) {
  for_either([&](std::size_t late) {
    push(1 - late, 0);
    push(late, 1);
    CHECK(bench->step().status == Status::ok);
    LONGS_EQUAL(1, camera(late).leases_out());
    CHECK(bench->loop.stop() == Status::ok);
    check_leases();
  });
}

// ---- start, calibration, pixels ----

TEST(StereoLoop, a_second_camera_that_does_not_start_stops_the_first) {
  CHECK(bench->loop.stop() == Status::ok);
  bench->second.fail_starts(Status::device_lost);
  CHECK(bench->loop.start() == Status::device_lost);
  CHECK(bench->loop.mode() == Mode::standby);
  CHECK_FALSE(bench->camera.streaming());
  CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{1});
  CHECK(bench->loop.start() == Status::ok);
  check_pair(0);
}

TEST(StereoLoop, a_wrong_calibration_ends_in_lost_and_gives_no_pose) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  test::SpotMotion knocked;
  knocked.rig = test::two_cameras();
  knocked.rig[1].R_KC = exp_so3(Vec3(0.0018, 0.0, 0.0)) * knocked.rig[1].R_KC;  // a tenth of a degree, 1.2 px
  knocked.target = test::eight_leds();
  for (int k = 0; k < 3; ++k) knocked.advance();
  std::vector<test::SpotImage> seen(2 * 6);
  for (int k = 3; k < 9; ++k, knocked.advance()) {
    knocked.render();
    const Time time{1'000'000'000 + k * test::period_ns};
    for (std::size_t c = 0; c < 2; ++c) {
      test::SpotImage& image = seen[2 * static_cast<std::size_t>(k - 3) + c];
      image = knocked.images[c];
      CHECK(camera(c).push_frame(image.pixels(), test::spot_width_px, test::spot_height_px, time, sequence[c]++) ==
            Status::ok);
    }
    static_cast<void>(bench->step());
    LONGS_EQUAL(0, bench->loop.report().inliers);
  }
  const auto alarms = bench->events(EventId::update_refused);
  CHECK(!alarms.empty());
  LONGS_EQUAL(static_cast<int>(Status::inconsistent), alarms[0].status);
  CHECK(bench->loop.mode() == Mode::lost);
}

TEST(StereoLoop, frames_of_sixteen_bits_are_taken_if_rows_and_contrast_are_right) {
  const std::vector<std::uint16_t> deep = images[0][0].deeper(16);
  hal::Frame frame;
  frame.pixels = reinterpret_cast<const std::uint8_t*>(deep.data());
  frame.width_px = test::spot_width_px;
  frame.height_px = test::spot_height_px;
  frame.stride_bytes = 2 * test::spot_width_px;
  frame.format = hal::PixelFormat::mono16;
  frame.mid_exposure = Time{1'000'000'000};
  push(1, 0);  // the second one has 8
  CHECK(bench->camera.push_frame(frame) == Status::ok);
  check_step(16);

  const auto check_refused = [&](const hal::Frame& bad, EventId event) {
    CHECK(bench->camera.push_frame(bad) == Status::ok);
    CHECK(bench->step().status != Status::ok);
    LONGS_EQUAL(1, bench->events(event).size());
  };
  hal::Frame odd = frame;
  odd.stride_bytes += 1;
  check_refused(odd, EventId::frame_refused_size);
  hal::Frame flat = frame;
  const std::vector<std::uint16_t> levels(deep.size(), 40'000);
  flat.pixels = reinterpret_cast<const std::uint8_t*>(levels.data());
  flat.mid_exposure = Time{1'100'000'000};
  check_refused(flat, EventId::image_without_contrast);
}
