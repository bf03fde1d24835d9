// The flight loop with controls of its cameras' exposures.
#include <algorithm>
#include <memory>

#include "platform/host/scripted_exposure_control.hpp"
#include "tests/support/allocation_trap.hpp"
#include "tests/unit/app/loop_bench.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace {

using namespace relnav;
using platform::host::ScriptedExposureControl;
using telemetry::EventId;
using test::period_ns;
using test::RenderedBox;

/// Rendered once, before the tests; 0.1 s apart.
struct Pictures {
  std::vector<RenderedBox::Pixels> box;
  Pictures() {
    const RenderedBox target(5);
    for (std::uint32_t i = 0; i < 14; ++i) box.push_back(target.render(0.1 * i, i));
  }
};
const Pictures pictures;

struct ExposureBench {
  platform::host::ScriptedCamera camera{2};
  platform::host::ScriptedCamera second{2};
  platform::host::ScriptedClock clock;
  platform::host::ScriptedPacketLink link;
  platform::host::ScriptedWatchdog watchdog;
  std::array<ScriptedExposureControl, 2> controls;
  app::FlightLoop loop;
  app::FlightLoopConfig config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
  std::uint32_t sequence = 0;

  explicit ExposureBench(bool with_controls = true)
      : loop(camera, clock, link, watchdog, &second, peripherals(with_controls)) {
    clock.set_tick({1000});
    config.camera = RenderedBox::camera();
    config.navigator.filter.range_m = 3.0;
    config.exposure.enabled = true;
  }
  app::FlightPeripherals peripherals(bool with_controls) {
    app::FlightPeripherals out;
    if (with_controls) out.exposures = {&controls[0], &controls[1]};
    return out;
  }
  void begin() {
    CHECK_TRUE(loop.configure(config) == Status::ok);
    CHECK_TRUE(loop.start() == Status::ok);
  }
  hal::Frame frame_of(const std::uint8_t* pixels) {
    hal::Frame f;
    f.pixels = pixels;
    f.width_px = f.stride_bytes = RenderedBox::width_px;
    f.height_px = RenderedBox::height_px;
    f.mid_exposure = Time{sequence * period_ns};
    f.sequence = sequence++;
    return f;
  }
  const app::StepReport& feed(const std::uint8_t* pixels) {
    CHECK_TRUE(camera.push_frame(frame_of(pixels)) == Status::ok);
    return loop.step();
  }
  const app::StepReport& feed_box() { return feed(pictures.box[sequence % pictures.box.size()].data()); }
  std::vector<std::uint8_t> bytes_sent() const {
    std::vector<std::uint8_t> all;
    for (std::size_t i = 0; i < link.size(); ++i) {
      const auto packet = link.packet(i);
      all.insert(all.end(), packet.begin(), packet.end());
    }
    return all;
  }
};

}  // namespace

TEST_GROUP(FlightExposure) {
  std::unique_ptr<ExposureBench> owned = std::make_unique<ExposureBench>();
  ExposureBench& bench = *owned;
};

TEST(FlightExposure, FramesAreMeasuredAndTheCameraIsTold) {
  bench.config.exposure.target_level = 100;
  bench.begin();
  const app::StepReport* report = &bench.feed_box();
  CHECK_TRUE(report->exposures[0].measured);
  CHECK_TRUE(report->exposures[0].changed);
  CHECK_TRUE(report->exposures[0].status == Status::ok);
  LONGS_EQUAL(1'000'000, report->exposures[0].exposure.time.ns);
  for (int i = 0; i < 4; ++i) report = &bench.feed_box();
  CHECK_TRUE(report->exposures[0].judged);
  CHECK_TRUE(report->exposures[0].brightness.level > 130);
  CHECK_TRUE(bench.controls[0].applied().time.ns < 800'000);
  LONGS_EQUAL(0, bench.controls[1].calls().size());  // of a camera that is not flown
}

TEST(FlightExposure, WhatIsWhiteAllOverIsRefusedButSeen) {
  const RenderedBox::Pixels white(RenderedBox::width_px * RenderedBox::height_px, 255);
  bench.begin();
  for (int i = 0; i < 9; ++i) {
    const app::StepReport& report = bench.feed(white.data());
    CHECK_TRUE(report.status == Status::incomplete);
    CHECK_TRUE(report.exposures[0].measured);
  }
  LONGS_EQUAL(62'500, bench.controls[0].applied().time.ns);  // 1 ms / 4 / 4
}

TEST(FlightExposure, FrozenAndUnusableFramesAreNotHeldAgainstIt) {
  bench.begin();
  static_cast<void>(bench.feed_box());
  const std::uint8_t* const box = pictures.box[0].data();
  static_cast<void>(bench.feed(box));
  CHECK_FALSE(bench.feed(box).exposures[0].measured);  // frozen
  hal::Frame small = bench.frame_of(box);
  small.width_px = 100;
  CHECK_TRUE(bench.camera.push_frame(small) == Status::ok);
  CHECK_FALSE(bench.loop.step().exposures[0].measured);
  hal::Frame old = bench.frame_of(box);
  old.mid_exposure = Time{0};
  CHECK_TRUE(bench.camera.push_frame(old) == Status::ok);
  CHECK_FALSE(bench.loop.step().exposures[0].measured);
  CHECK_FALSE(bench.loop.step().exposures[0].measured);  // no frame at all
}

TEST(FlightExposure, StandsStillInStandby) {
  bench.begin();
  static_cast<void>(bench.feed_box());
  CHECK_TRUE(bench.loop.stop() == Status::ok);
  CHECK_FALSE(bench.loop.step().exposures[0].measured);
  LONGS_EQUAL(1, bench.controls[0].calls().size());
}

TEST(FlightExposure, KeepsItsExposureFromStopToStart) {
  bench.config.exposure.target_level = 100;
  bench.begin();
  for (int i = 0; i < 6; ++i) static_cast<void>(bench.feed_box());
  const hal::Exposure before = bench.controls[0].applied();
  CHECK_TRUE(bench.loop.stop() == Status::ok);
  CHECK_TRUE(bench.loop.start() == Status::ok);
  const std::size_t calls = bench.controls[0].calls().size();
  static_cast<void>(bench.feed_box());
  LONGS_EQUAL(calls, bench.controls[0].calls().size());
  CHECK_TRUE(bench.loop.report().exposures[0].exposure == before);
}

TEST(FlightExposure, EachCameraOfAPairHasItsOwn) {
  bench.config.navigation = app::NavigationKind::coop_stereo;
  bench.config.second.intrinsics = bench.config.camera;
  bench.config.second.t_C1C0 = Vec3(-0.5, 0.0, 0.0);
  for (std::uint16_t id = 0; id < 4; ++id) {
    CHECK_TRUE(bench.config.coop.target.features.push_back({id, Vec3(id % 2, id / 2, 0.1 * id), Vec3::Zero()}) ==
               Status::ok);
  }
  bench.begin();
  std::vector<RenderedBox::Pixels> dim = pictures.box;
  for (auto& picture : dim) {
    for (std::uint8_t& level : picture) level = static_cast<std::uint8_t>(level / 2);
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    hal::Frame right = bench.frame_of(dim[i].data());
    right.sequence = i;
    CHECK_TRUE(bench.second.push_frame(right) == Status::ok);
    --bench.sequence;
    static_cast<void>(bench.feed_box());
  }
  const app::StepReport& report = bench.loop.report();
  CHECK_TRUE(report.exposures[0].measured && report.exposures[1].measured);
  CHECK_TRUE(report.exposures[0].brightness.level > report.exposures[1].brightness.level + 40);
  CHECK_TRUE(bench.controls[1].applied().time > bench.controls[0].applied().time);
}

TEST(FlightExposure, DeepPixelsAreMeasuredByTheirOwnScale) {
  bench.config.navigation = app::NavigationKind::coop_mono;
  bench.config.coop.sensor_bits = 12;
  for (std::uint16_t id = 0; id < 4; ++id) {
    CHECK_TRUE(bench.config.coop.target.features.push_back({id, Vec3(id % 2, id / 2, 0.1 * id), Vec3::Zero()}) ==
               Status::ok);
  }
  bench.begin();
  std::vector<std::uint16_t> deep(pictures.box[0].size());
  std::copy(pictures.box[0].begin(), pictures.box[0].end(), deep.begin());
  for (std::uint16_t& level : deep) level = static_cast<std::uint16_t>(16U * level);
  const void* const bytes = deep.data();
  hal::Frame frame = bench.frame_of(static_cast<const std::uint8_t*>(bytes));
  frame.format = hal::PixelFormat::mono16;
  frame.stride_bytes *= 2;
  CHECK_TRUE(bench.camera.push_frame(frame) == Status::ok);
  const vision::Brightness seen = bench.loop.step().exposures[0].brightness;
  const vision::Brightness expected = vision::measure_brightness(
      vision::ImageView{pictures.box[0].data(), RenderedBox::width_px, RenderedBox::height_px, RenderedBox::width_px},
      8, bench.config.exposure.brightness);
  LONGS_EQUAL(expected.level, seen.level);
  LONGS_EQUAL(expected.bright, seen.bright);
}

TEST(FlightExposure, ACameraThatDoesNotObeyIsReported) {
  bench.controls[0].state = Status::unsupported;
  bench.begin();
  const app::StepReport& report = bench.feed_box();
  CHECK_TRUE(report.exposures[0].status == Status::unsupported);
  CHECK_TRUE(report.processed);  // and flown on
}

TEST(FlightExposure, ConfigurationsOutsideTheirDomainAreRefused) {
  bench.config.exposure.dead_band = 0.9;
  CHECK_TRUE(bench.loop.configure(bench.config) == Status::invalid_argument);
}

TEST(FlightExposure, WithoutControlOrSwitchedOffNothingIsDifferent) {
  const auto fly = [](bool with_controls, bool enabled) {
    auto flown = std::make_unique<ExposureBench>(with_controls);
    flown->config.exposure.enabled = enabled;
    flown->begin();
    for (int i = 0; i < 12; ++i) {
      const bool measured = flown->feed_box().exposures[0].measured;
      CHECK_TRUE(measured == (with_controls && enabled));
    }
    CHECK_TRUE((flown->controls[0].calls().size() > 0) == (with_controls && enabled));
    return flown->bytes_sent();
  };
  const auto off = fly(false, false);
  CHECK_TRUE(off.size() > 500);
  CHECK_TRUE(off == fly(false, true));
  CHECK_TRUE(off == fly(true, false));
  CHECK_TRUE(off == fly(true, true));  // packets know nothing of it
}

TEST(FlightExposure, TakesNoHeap) {
  bench.config.exposure.target_level = 100;
  bench.begin();
  for (int i = 0; i < 8; ++i) {
    CHECK_TRUE(bench.camera.push_frame(bench.frame_of(pictures.box[static_cast<std::size_t>(i)].data())) == Status::ok);
  }
  std::size_t allocations = 0;
  {
    test::AllocationTrap trap;
    for (int i = 0; i < 8; ++i) static_cast<void>(bench.loop.step());
    allocations = trap.allocations();
  }
  LONGS_EQUAL(0, allocations);
  CHECK_TRUE(bench.controls[0].calls().size() >= 2);
}
