// Recorded frames through the whole flight loop, where there are some.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "fsw/app/flight_loop.hpp"
#include "fsw/attitude/quaternion.hpp"
#include "hil/evaluate/evaluation.hpp"
#include "hil/io/camera_file.hpp"
#include "hil/io/euroc.hpp"
#include "hil/io/trajectory.hpp"
#include "hil/replay/replay_camera.hpp"
#include "platform/host/scripted_clock.hpp"
#include "platform/host/scripted_packet_link.hpp"
#include "platform/host/scripted_watchdog.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace {

using namespace relnav;
namespace fs = std::filesystem;

constexpr double deg = 0.017453292519943295;

fs::path find_sequence(const std::string& name) {
  const char* shared = std::getenv("RELNAV_SHARED");
  const fs::path source = RELNAV_SOURCE_DIR;
  const fs::path places[] = {fs::path(shared != nullptr ? shared : "") / "data",
                             fs::path(shared != nullptr ? shared : ""), source / ".." / "shared" / "data",
                             source / "hil" / "captures"};
  for (const fs::path& place : places) {
    if (fs::exists(place / name / "mav0" / "cam0" / "data")) return place / name;  // real_desk is shared packed
  }
  return {};
}

struct Outcome {
  std::size_t frames = 0;
  hil::Trajectory estimate;
  double rate_error_deg_s = 0.0;  ///< of omega_C, mean
  std::uint32_t not_ok = 0;
  std::uint32_t resets = 0;
  app::Mode mode = app::Mode::standby;
  std::vector<std::uint8_t> telemetry;
};

/// Read before the tests: yaml-cpp keeps memory, which CppUTest would call a leak.
struct Recording {
  std::string name;
  bool found = false;
  CameraIntrinsics camera;
  std::vector<hil::ImageEntry> entries;
  hil::Trajectory truth;

  explicit Recording(const std::string& sequence, const char* truth_file = "truth.tum") : name(sequence) {
    const fs::path place = find_sequence(sequence);
    if (place.empty()) return;
    const std::string camera_folder = (place / "mav0" / "cam0").string();
    camera = hil::read_camera_file(camera_folder + "/sensor.yaml").intrinsics;
    entries = hil::read_image_list(camera_folder);
    truth = hil::read_trajectory((place / truth_file).string());
    found = true;
  }
  bool is_here() const {
    if (!found) std::printf("%s: not here, nothing tested\n", name.c_str());
    return found;
  }
};
const Recording shipped("spin_near");
const Recording near_spin("D_N4");
const Recording far_spin("D_N2");
const Recording near_approach("D_N5");
const Recording far_approach("D_N1");
const Recording hand_held("real_desk", "reference.tum");

/// By central difference of the true attitudes.
Vec3 true_rate_C(const hil::Trajectory& truth, std::size_t k) {
  const std::size_t before = k > 0 ? k - 1 : k;
  const std::size_t after = k + 1 < truth.size() ? k + 1 : k;
  const Vec3 turned = Quaternion::from_dcm(truth[after].R_CT * truth[before].R_CT.transpose()).rotation_vector();
  return turned / (truth[after].time - truth[before].time).seconds();
}

Outcome replay(const Recording& recording, MotionKind motion, double range_m) {
  const hil::Trajectory& truth = recording.truth;
  platform::host::ScriptedClock clock;
  platform::host::ScriptedPacketLink link(4096);
  platform::host::ScriptedWatchdog watchdog;
  hil::ReplayCamera camera(recording.entries, static_cast<std::uint32_t>(recording.camera.width_px),
                           static_cast<std::uint32_t>(recording.camera.height_px), clock);
  const auto loop = std::make_unique<app::FlightLoop>(camera, clock, link, watchdog);
  app::FlightLoopConfig config = app::FlightLoopConfig::defaults(motion);
  config.camera = recording.camera;
  config.navigator.filter.range_m = range_m;
  CHECK_TRUE(loop->configure(config) == Status::ok);
  CHECK_TRUE(loop->start() == Status::ok);

  Outcome out;
  std::size_t k = 0;
  double rate_error_sum = 0.0;
  double compared = 0.0;
  while (!camera.exhausted()) {
    const app::StepReport& report = loop->step();
    ++out.frames;
    if (report.status != Status::ok) {
      ++out.not_ok;
      continue;
    }
    out.estimate.push_back({report.state.time, report.state.t_CT, report.state.R_CT});
    // TUM stamps are rounded to nanoseconds by way of seconds.
    while (k < truth.size() && truth[k].time.ns < report.state.time.ns - 1000) ++k;
    if (k == truth.size() || truth[k].time.ns > report.state.time.ns + 1000) continue;
    rate_error_sum += (report.state.omega_C - true_rate_C(truth, k)).norm() / deg;
    ++compared;
  }
  out.rate_error_deg_s = rate_error_sum / compared;
  out.resets = loop->report().reset_counter;
  out.mode = loop->mode();
  for (std::size_t i = 0; i < link.size(); ++i) {
    const auto packet = link.packet(i);
    out.telemetry.insert(out.telemetry.end(), packet.begin(), packet.end());
  }
  return out;
}

/// Of the attitude error since the first frame, and of the mean rate error: of omega_C, and over 1 s of the trajectory.
struct Limits {
  double worst_deg;
  double last_deg;
  double rate_deg_s;
};

void check_recording(const Recording& recording, double range_m, const Limits& limits) {
  if (!recording.is_here()) return;
  const Outcome first = replay(recording, MotionKind::rigid_target, range_m);
  const hil::Evaluation e = hil::evaluate(recording.truth, first.estimate, nullptr, hil::AlignMode::start);
  std::printf(
      "%s: %zu frames, attitude error at most %.3f deg, at the end %.3f deg, rate error %.4f, %.4f deg/s (mean)\n",
      recording.name.c_str(), first.frames, e.attitude.max / deg, e.attitude.last / deg, first.rate_error_deg_s,
      e.rate.mean / deg);
  LONGS_EQUAL(0, first.not_ok);
  LONGS_EQUAL(0, first.resets);
  // The start of a target that looks flat may still be open at the end.
  CHECK_TRUE(first.mode == app::Mode::track || first.mode == app::Mode::acquire);
  CHECK_TRUE(e.attitude.max > 0.0);
  CHECK_TRUE(e.attitude.max <= limits.worst_deg * deg);
  CHECK_TRUE(e.attitude.last <= limits.last_deg * deg);
  CHECK_TRUE(first.rate_error_deg_s <= limits.rate_deg_s);
  CHECK_TRUE(e.rate.mean <= limits.rate_deg_s * deg);
  const Outcome second = replay(recording, MotionKind::rigid_target, range_m);
  CHECK_TRUE(first.telemetry == second.telemetry);
}

}  // namespace

TEST_GROUP(CapturedFrames){void setup() override{IGNORE_ALL_LEAKS_IN_TEST();
}  // yaml-cpp keeps what it once looked up
}
;

// Limits: what was asked for; the rates of the approaches are our own. The shipped capture is the first half of the near spin.
TEST(CapturedFrames, Shipped) { check_recording(shipped, 3.4, {3.0, 1.5, 0.15}); }
TEST(CapturedFrames, NearSpin) { check_recording(near_spin, 3.4, {3.0, 2.09, 0.1}); }
TEST(CapturedFrames, FarSpin) { check_recording(far_spin, 8.0, {4.0, 4.0, 0.15}); }
TEST(CapturedFrames, NearApproach) { check_recording(near_approach, 5.0, {0.8, 0.8, 0.2}); }
TEST(CapturedFrames, FarApproach) { check_recording(far_approach, 10.5, {2.5, 2.5, 0.35}); }
TEST(CapturedFrames, HandHeldCamera) {
  if (!hand_held.is_here()) return;
  const Outcome run = replay(hand_held, MotionKind::camera, 1.0);
  const hil::Evaluation e = hil::evaluate(hand_held.truth, run.estimate, nullptr, hil::AlignMode::sim3);
  std::printf("real_desk: %zu frames, position RMSE %.2f %% of the extent\n", run.frames,
              100.0 * e.position.rms / e.extent);
  LONGS_EQUAL(0, run.not_ok);
  LONGS_EQUAL(0, run.resets);
  CHECK_TRUE(e.position.rms <= 0.017 * e.extent);
}
