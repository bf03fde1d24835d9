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
  std::unique_ptr<test::LoopBench> bench = std::make_unique<test::LoopBench>(true);
  std::array<std::vector<test::SpotImage>, 2> images;  // camera, frame
  std::array<std::uint32_t, 2> sequence{};

  void setup() override {
    test::SpotMotion scene;
    scene.rig = test::two_cameras();
    scene.target = test::eight_leds();
    for (int k = 0; k < frames; ++k) {
      scene.render();
      for (std::size_t c = 0; c < 2; ++c) images[c].push_back(scene.images[c]);
      scene.advance();
    }
    app::FlightLoopConfig& config = bench->config;
    config.navigation = app::NavigationKind::coop_stereo;
    config.camera = scene.rig[0].model.intrinsics();
    config.second = {scene.rig[1].model.intrinsics(), scene.rig[1].R_KC, scene.rig[1].t_KC, Duration{1'000'000}};
    config.coop.target = scene.target;
    config.event_spacing_frames = 0;
    config.camera_silence = Duration{3 * config.acquire_wait.ns};
    CHECK(bench->begin() == Status::ok);
  }
  platform::host::ScriptedCamera& camera(std::size_t c) { return c == 0 ? bench->camera : bench->second; }
  void push(std::size_t c, int k, std::int64_t late_ns = 0) {
    const Time time{1'000'000'000 + k * test::period_ns + late_ns};
    CHECK(camera(c).push_frame(images[c][static_cast<std::size_t>(k)].pixels(), test::spot_width_px,
                               test::spot_height_px, time, sequence[c]++) == Status::ok);
  }
  void push_pair(int k) {
    push(0, k);
    push(1, k);
  }
  void check_pair(int k) {
    push_pair(k);
    check_step(16);
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
  std::vector<std::int64_t> cameras_of(EventId id) {
    std::vector<std::int64_t> cameras;
    for (const telemetry::EventPacket& p : bench->events(id)) cameras.push_back(p.args[0]);
    return cameras;
  }
};

TEST(StereoLoop, pairs_are_tracked_with_both) {
  for (int k = 0; k < 5; ++k) check_pair(k);
  CHECK(bench->loop.mode() == Mode::track);
  CHECK(bench->events(EventId::frame_incomplete).empty());
}

TEST(StereoLoop, a_lost_second_camera_is_started_anew_while_the_first_goes_on) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  CHECK(bench->second.push_status(Status::device_lost) == Status::ok);
  bench->second.fail_starts(Status::device_lost, 2);
  for (int k = 3; k < 6; ++k) {
    push(0, k);
    check_step(8);
  }
  CHECK(bench->loop.mode() == Mode::track);
  CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{1});
  CHECK(cameras_of(EventId::camera_recovered).empty());
  check_pair(6);
  CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{1});
  LONGS_EQUAL(3, bench->events(EventId::camera_recovered)[0].args[1]);  // attempts
  const auto health = bench->packets<telemetry::HealthPacket>();
  LONGS_EQUAL(1, health.size());  // of the first frame
  check_pair(7);
}

TEST(StereoLoop, a_lost_first_camera_is_started_anew_and_pairs_go_on) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  CHECK(bench->camera.push_status(Status::device_lost) == Status::ok);
  bench->camera.fail_starts(Status::device_lost, 1);
  for (int k = 0; k < 2; ++k) CHECK(bench->step().status == Status::device_lost);
  push(1, 3);  // taken while the first was away
  check_pair(4);
  CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{0});
  CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{0});
  LONGS_EQUAL(0, bench->loop.report().reset_counter);
}

TEST(StereoLoop, both_lost_both_recovered) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  CHECK(bench->second.push_status(Status::device_lost) == Status::ok);
  bench->second.fail_starts(Status::device_lost, 1);
  push(0, 3);
  check_step(8);
  CHECK(bench->camera.push_status(Status::device_lost) == Status::ok);
  CHECK(bench->step().status == Status::device_lost);
  push(0, 4);
  check_step(8);  // the first is back, the second has failed to start
  check_pair(5);
  CHECK((cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{1, 0}));
  CHECK((cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{0, 1}));
}

TEST(StereoLoop, a_missed_or_damaged_frame_of_the_second_is_told_and_done_without) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  push(0, 3);
  push(1, 4);  // that of frame 3 was missed; this one waits
  const app::StepReport& report = bench->step();
  CHECK(report.status == Status::ok);
  LONGS_EQUAL(8, report.inliers);
  LONGS_EQUAL(1, bench->second.leases_out());
  push(0, 4);
  check_step(16);
  push(0, 5);
  CHECK(bench->second.push_status(Status::incomplete) == Status::ok);
  check_step(8);
  LONGS_EQUAL(2, bench->events(EventId::frame_incomplete).size());
  push(0, 6);
  push(1, 6, 1'500'000);  // not of the same time
  CHECK(bench->step().status == Status::ok);
  LONGS_EQUAL(8, bench->loop.report().inliers);
  check_pair(7);
  CHECK(bench->events(EventId::camera_lost).empty());
}

TEST(StereoLoop, a_frozen_or_dark_second_image_is_not_used) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  push(0, 3);
  const Time time{1'000'000'000 + 3 * test::period_ns};
  CHECK(bench->second.push_frame(images[1][2].pixels(), test::spot_width_px, test::spot_height_px, time,
                                 sequence[1]++) == Status::ok);
  check_step(8);
  LONGS_EQUAL(1, bench->events(EventId::image_frozen).size());
  const test::SpotImage dark;
  push(0, 4);
  CHECK(bench->second.push_frame(dark.pixels(), test::spot_width_px, test::spot_height_px,
                                 time + Duration{test::period_ns}, sequence[1]++) == Status::ok);
  check_step(8);
  LONGS_EQUAL(1, bench->events(EventId::image_without_contrast).size());
}

TEST(StereoLoop, a_silent_second_camera_counts_as_lost) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  for (int k = 3; k < 6; ++k) {
    push(0, k);
    check_step(8);
  }
  CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{1});
  check_pair(6);
  CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{1});
}

TEST(StereoLoop, a_second_camera_that_keeps_its_lease_is_started_anew) {
  for (int k = 0; k < 3; ++k) check_pair(k);
  bench->second.fail_releases(Status::io_error);
  push_pair(3);
  CHECK(bench->step().status == Status::ok);
  CHECK(cameras_of(EventId::camera_lost) == std::vector<std::int64_t>{1});
  LONGS_EQUAL(0, bench->camera.leases_out());
  push_pair(4);
  CHECK(bench->step().status == Status::ok);
  LONGS_EQUAL(16, bench->loop.report().inliers);
  CHECK(cameras_of(EventId::camera_recovered) == std::vector<std::int64_t>{1});
}

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
