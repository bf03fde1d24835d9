// Recorded frames through the whole flight loop, where there are some.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "fsw/app/flight_loop.hpp"
#include "fsw/attitude/quaternion.hpp"
#include "hil/evaluate/evaluation.hpp"
#include "hil/io/euroc.hpp"
#include "hil/io/trajectory.hpp"
#include "hil/replay/replay_camera.hpp"
#include "platform/files/camera_file.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "platform/files/target_file.hpp"
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
  std::vector<hil::TimedCovariance> covariances;  ///< of the estimate
  double rate_error_deg_s = 0.0;                  ///< of omega_C, mean
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
  app::SecondCamera second;  ///< of a pair
  std::vector<hil::ImageEntry> second_entries;
  TargetModel target;  ///< empty: nothing is known about it
  hil::Trajectory truth;

  explicit Recording(const std::string& sequence, const char* truth_file = "truth.tum") : name(sequence) {
    const fs::path place = find_sequence(sequence);
    if (place.empty()) return;
    const std::string camera_folder = (place / "mav0" / "cam0").string();
    const CameraCalibration calibration = read_camera_file(camera_folder + "/sensor.yaml");
    camera = calibration.intrinsics;
    entries = hil::read_image_list(camera_folder);
    if (fs::exists(place / "mav0" / "cam1")) read_second((place / "mav0" / "cam1").string(), calibration);
    if (fs::exists(place / "target.yaml")) target = read_target_file((place / "target.yaml").string());
    truth = hil::read_trajectory((place / truth_file).string());
    found = true;
  }
  bool is_here() const {
    if (!found) std::printf("%s: not here, nothing tested\n", name.c_str());
    return found;
  }

 private:
  void read_second(const std::string& folder, const CameraCalibration& first) {
    const CameraCalibration calibration = read_camera_file(folder + "/sensor.yaml", 1);
    const CameraRig rig = camera_rig_of({first, calibration}, {"cam0", "cam1"});
    second.intrinsics = calibration.intrinsics;
    second.R_C1C0 = rig[1].R_KC;
    second.t_C1C0 = rig[1].t_KC;
    second_entries = hil::read_image_list(folder);
  }
};
const Recording shipped("spin_near");
const Recording near_spin("D_N4");
const Recording far_spin("D_N2");
const Recording near_approach("D_N5");
const Recording far_approach("D_N1");
const Recording hand_held("real_desk", "reference.tum");
const Recording lights_mono("D_C1");
const Recording lights_stereo("D_S1");

/// By central difference of the true attitudes.
Vec3 true_rate_C(const hil::Trajectory& truth, std::size_t k) {
  const std::size_t before = k > 0 ? k - 1 : k;
  const std::size_t after = k + 1 < truth.size() ? k + 1 : k;
  const Vec3 turned = Quaternion::from_dcm(truth[after].R_CT * truth[before].R_CT.transpose()).rotation_vector();
  return turned / (truth[after].time - truth[before].time).seconds();
}

app::FlightLoopConfig noncoop_config(const Recording& recording, MotionKind motion, double range_m) {
  app::FlightLoopConfig config = app::FlightLoopConfig::defaults(motion);
  config.camera = recording.camera;
  config.navigator.filter.range_m = range_m;
  return config;
}

app::FlightLoopConfig coop_config(const Recording& recording) {
  app::FlightLoopConfig config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
  config.navigation =
      recording.second_entries.empty() ? app::NavigationKind::coop_mono : app::NavigationKind::coop_stereo;
  config.camera = recording.camera;
  config.second = recording.second;
  config.coop.target = recording.target;
  return config;
}

hil::ReplayCamera camera_over(const std::vector<hil::ImageEntry>& entries, const CameraIntrinsics& c,
                              hal::Clock& clock) {
  return {entries, static_cast<std::uint32_t>(c.width_px), static_cast<std::uint32_t>(c.height_px), clock};
}

Outcome replay(const Recording& recording, const app::FlightLoopConfig& config) {
  const hil::Trajectory& truth = recording.truth;
  platform::host::ScriptedClock clock;
  platform::host::ScriptedPacketLink link(4096);
  platform::host::ScriptedWatchdog watchdog;
  hil::ReplayCamera camera = camera_over(recording.entries, recording.camera, clock);
  std::optional<hil::ReplayCamera> second;
  if (config.navigation == app::NavigationKind::coop_stereo)
    second.emplace(camera_over(recording.second_entries, recording.second.intrinsics, clock));
  const auto loop = std::make_unique<app::FlightLoop>(camera, clock, link, watchdog, second ? &*second : nullptr);
  CHECK_TRUE(loop->configure(config) == Status::ok);
  CHECK_TRUE(loop->start() == Status::ok);

  Outcome out;
  std::size_t k = 0;
  double rate_error_sum = 0.0;
  double compared = 0.0;
  while (!camera.finished() || (second && !second->finished())) {
    const app::StepReport& report = loop->step();
    ++out.frames;
    if (report.status != Status::ok) {
      ++out.not_ok;
      continue;
    }
    out.estimate.push_back({report.state.time, report.state.t_CT, report.state.R_CT});
    out.covariances.push_back({report.state.time, report.state.pose_covariance});
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
  const app::FlightLoopConfig config = noncoop_config(recording, MotionKind::rigid_target, range_m);
  const Outcome first = replay(recording, config);
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
  const Outcome second = replay(recording, config);
  CHECK_TRUE(first.telemetry == second.telemetry);
}

/// Position over the range of the epoch, RMS.
double relative_position_rms(const hil::Evaluation& e, const hil::Trajectory& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < e.epochs.size(); ++i)
    sum += e.epochs[i].position.squaredNorm() / truth[e.association.pairs[i].truth].t_CT.squaredNorm();
  return std::sqrt(sum / static_cast<double>(e.epochs.size()));
}

/// Known light spots: nothing is told but the target, the cameras and that the target's axes are roughly the camera's.
void check_cooperative(const Recording& recording) {
  if (!recording.is_here()) return;
  const app::FlightLoopConfig config = coop_config(recording);
  const Outcome first = replay(recording, config);
  LONGS_EQUAL(recording.entries.size(), first.frames);
  CHECK_TRUE(first.not_ok <= 2);  // the third frame has a pose at the latest
  const std::size_t poses = recording.truth.size() - static_cast<std::size_t>(first.not_ok);
  LONGS_EQUAL(0, first.resets);
  CHECK_TRUE(first.mode == app::Mode::track);
  const hil::Evaluation e = hil::evaluate(recording.truth, first.estimate, &first.covariances, hil::AlignMode::none);
  LONGS_EQUAL(poses, e.epochs.size());
  const double relative = relative_position_rms(e, recording.truth);
  std::printf("%s: %zu frames, position RMS %.4f %% of the range, attitude RMS %.3f deg, NEES %.2f\n",
              recording.name.c_str(), first.frames, 100.0 * relative, e.attitude.rms / deg, e.nees->mean);
  CHECK_TRUE(relative > 0.0 && relative <= 0.003);
  CHECK_TRUE(e.attitude.rms <= 0.5 * deg);
  LONGS_EQUAL(poses, e.nees->epochs);
  CHECK_TRUE(e.nees->mean >= 3.0 && e.nees->mean <= 9.0);
  const Outcome second = replay(recording, config);
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
  const Outcome run = replay(hand_held, noncoop_config(hand_held, MotionKind::camera, 1.0));
  const hil::Evaluation e = hil::evaluate(hand_held.truth, run.estimate, nullptr, hil::AlignMode::sim3);
  std::printf("real_desk: %zu frames, position RMSE %.2f %% of the extent\n", run.frames,
              100.0 * e.position.rms / e.extent);
  LONGS_EQUAL(0, run.not_ok);
  LONGS_EQUAL(0, run.resets);
  CHECK_TRUE(e.position.rms <= 0.017 * e.extent);
}
TEST(CapturedFrames, LightSpotsOneCamera) { check_cooperative(lights_mono); }
TEST(CapturedFrames, LightSpotsTwoCameras) { check_cooperative(lights_stereo); }
