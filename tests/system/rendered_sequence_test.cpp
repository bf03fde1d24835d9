// A rendered box, turning and approaching, through the whole flight loop: accuracy, repetition bit for bit, no heap.
#include <memory>

#include "fsw/attitude/quaternion.hpp"
#include "tests/support/allocation_trap.hpp"
#include "tests/unit/app/loop_bench.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace {

using namespace relnav;
using test::LoopBench;
using test::period_ns;
using test::RenderedBox;

constexpr double deg = 0.017453292519943295;
constexpr std::uint32_t frame_count = 150;
const RenderedBox box(21, {.v_C = Vec3(0.01, -0.005, -0.03)});

std::vector<RenderedBox::Pixels> render_all() {
  std::vector<RenderedBox::Pixels> all;
  for (std::uint32_t i = 0; i < frame_count; ++i) all.push_back(box.render(0.1 * i, i));
  return all;
}
const std::vector<RenderedBox::Pixels> frames = render_all();

struct Run {
  LoopBench bench;
  double worst_attitude_deg = 0.0;
  double worst_rate_deg_s = 0.0;  ///< in TRACK
  std::uint32_t not_ok = 0;
  std::size_t allocations = 0;
  std::size_t releases = 0;

  void execute() {
    bench.config.navigator.filter.start_frames = 48;
    if (bench.begin() != Status::ok) std::abort();
    for (std::uint32_t i = 0; i < frame_count; ++i) {
      if (bench.camera.push_frame(frames[i], RenderedBox::width_px, RenderedBox::height_px, Time{i * period_ns}, i) !=
          Status::ok) {
        std::abort();
      }
      {
        const test::AllocationTrap trap;
        bench.step();
        allocations += trap.allocations();
        releases += trap.releases();
      }
      judge(0.1 * i);
    }
  }

  void judge(double t_s) {
    const app::StepReport& report = bench.loop.report();
    if (report.status != Status::ok) {
      ++not_ok;
      return;
    }
    // T has the axes of C at the first frame.
    const Mat3 truth = box.R_CB(t_s) * box.R_CB(0.0).transpose();
    const Vec3 error = Quaternion::from_dcm(report.state.R_CT * truth.transpose()).rotation_vector();
    worst_attitude_deg = std::max(worst_attitude_deg, error.norm() / deg);
    if (report.mode != app::Mode::track) return;
    const Vec3 rate_error = report.state.omega_C - test::BoxMotion{}.omega_C;
    worst_rate_deg_s = std::max(worst_rate_deg_s, rate_error.norm() / deg);
  }
};

}  // namespace

TEST_GROUP(RenderedSequence){};

TEST(RenderedSequence, FollowsTheBoxWithoutHeapAndRepeatsBitForBit) {
  const auto first = std::make_unique<Run>();
  const auto second = std::make_unique<Run>();
  first->execute();
  second->execute();
  std::printf("attitude error %.3f deg, rate error %.3f deg/s of %.2f deg turned\n", first->worst_attitude_deg,
              first->worst_rate_deg_s, test::BoxMotion{}.omega_C.norm() * 0.1 * frame_count / deg);
  LONGS_EQUAL(0, first->not_ok);
  LONGS_EQUAL(0, first->allocations);
  LONGS_EQUAL(0, first->releases);
  LONGS_EQUAL(0, first->bench.loop.report().reset_counter);
  CHECK_TRUE(first->bench.loop.mode() == app::Mode::track);
  CHECK_TRUE(first->worst_attitude_deg < 2.5);
  CHECK_TRUE(first->worst_rate_deg_s < 0.3);
  LONGS_EQUAL(0, first->bench.undecodable());
  LONGS_EQUAL(frame_count, first->bench.packets<telemetry::RelStatePacket>().size());
  LONGS_EQUAL(0, first->bench.camera.leases_out());

  const std::vector<std::uint8_t> bytes = first->bench.bytes_sent();
  CHECK_TRUE(bytes.size() > 20'000);
  CHECK_TRUE(bytes == second->bench.bytes_sent());
}

TEST(RenderedSequence, BadFramesInBetweenDoNoHarm) {
  const auto run = std::make_unique<Run>();
  LoopBench& bench = run->bench;
  CHECK_TRUE(bench.begin() == Status::ok);
  const RenderedBox::Pixels black(frames[0].size(), 0);
  const RenderedBox::Pixels white(frames[0].size(), 255);
  std::uint32_t refused = 0;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const std::int64_t time_ns = i * period_ns;
    if (i % 9 == 8) {
      const auto& bad = i / 9 % 3 == 1 ? black : (i / 9 % 3 == 2 ? white : frames[i - 1]);
      CHECK_TRUE(bench.feed(bad, time_ns, i).status == Status::incomplete);
      ++refused;
    } else if (i % 13 == 12) {
      CHECK_TRUE(bench.feed(frames[i], time_ns - 3 * period_ns, i).status == Status::out_of_order);
      ++refused;
    } else {
      CHECK_TRUE(bench.feed(frames[i], time_ns, i).status == Status::ok);
      run->judge(0.1 * i);
    }
  }
  CHECK_TRUE(refused > 15);
  LONGS_EQUAL(0, run->not_ok);
  LONGS_EQUAL(0, bench.loop.report().reset_counter);
  CHECK_TRUE(run->worst_attitude_deg < 2.5);
  LONGS_EQUAL(0, bench.undecodable());
  LONGS_EQUAL(0, bench.camera.leases_out());
}
