// Whole runs without images: repeatable, judged against their truth, and lost where there is nothing to see.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "hil/replay/summary.hpp"
#include "hil/replay/telemetry_link.hpp"
#include "hil/simulation/run_verdict.hpp"
#include "hil/simulation/simulation.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "platform/files/text.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::Scratch;

namespace {

/// Keeps what is sent.
class Packets final : public hal::PacketLink {
 public:
  Status send(std::span<const std::uint8_t> packet) override {
    bytes.insert(bytes.end(), packet.begin(), packet.end());
    return Status::ok;
  }
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return 1400; }
  std::vector<std::uint8_t> bytes;
};

struct Flown {
  SimulationScenario scenario;
  ReplayOutcome outcome;
  RunHistory history;
  RunVerdict verdict;
  std::vector<std::uint8_t> telemetry;
  std::uint64_t heartbeats = 0;
};

const std::string scenarios = std::string(RELNAV_SOURCE_DIR) + "/hil/scenarios/";

/// A camera that makes plain images, for what does not depend on what they show.
class PlainMaker final : public ImageMaker {
 public:
  PlainMaker(std::uint32_t width_px, std::uint32_t height_px) : width_px_(width_px), height_px_(height_px) {}
  bool is_inside(const SceneState& state) const override { return state.t_CT.norm() < 1.0; }
  void make(const SceneState&, std::uint32_t frame, const hal::Exposure&, Image& image) override {
    image = {width_px_, height_px_, 1, std::vector<std::uint8_t>(std::size_t{width_px_} * height_px_)};
    image.bytes[frame] = 255;
  }

 private:
  std::uint32_t width_px_, height_px_;
};

Flown fly(const SimulationScenario& scenario) {
  Flown flown;
  flown.scenario = scenario;
  Packets packets;
  const ImageMakerFactory makers = [](const SimulationScenario&, const CameraModel& camera, std::uint64_t) {
    const CameraIntrinsics& k = camera.intrinsics();
    return std::make_unique<PlainMaker>(static_cast<std::uint32_t>(k.width_px),
                                        static_cast<std::uint32_t>(k.height_px));
  };
  Simulation simulation(scenario, makers, false, packets);
  flown.outcome = run_replay(simulation.driver(), simulation.cameras(), nullptr, flown.history,
                             [](std::size_t, std::size_t, const app::StepReport&) { return true; });
  flown.verdict = judge_run(scenario, flown.outcome, flown.history, simulation.plan().truth_at_stamps);
  flown.telemetry = packets.bytes;
  flown.heartbeats = simulation.heartbeats();
  return flown;
}

SimulationScenario scenario_of(const std::string& name, std::uint64_t run = 0) {
  return read_scenario(scenarios + name + ".yaml", {run});
}

}  // namespace

TEST_GROUP(Simulation) { Scratch scratch; };

TEST(Simulation, Table1ReachesTheBoundOnEachAxis) {
  const Flown flown = fly(scenario_of("table1"));
  CHECK_TRUE(flown.verdict.end == RunEnd::tracked);
  LONGS_EQUAL(1201, flown.verdict.poses);
  for (const char* axis : {"x", "y", "z", "rx", "ry", "rz"}) {
    const double ratio = flown.verdict.figures.at(std::string("rms_over_sigma_") + axis);
    CHECK_TRUE(ratio > 0.94 && ratio <= 1.05);
  }
  CHECK_TRUE(flown.verdict.figures.at("nees_mean") > 5.6 && flown.verdict.figures.at("nees_mean") < 6.4);
}

TEST(Simulation, OneSeedOneResultToTheByte) {
  const Flown first = fly(scenario_of("spin_features", 3));
  const Flown again = fly(scenario_of("spin_features", 3));
  const Flown other = fly(scenario_of("spin_features", 4));
  CHECK_TRUE(first.telemetry == again.telemetry);
  CHECK_TRUE(first.telemetry != other.telemetry);
  const std::string a = result_json(first.scenario, {3}, first.verdict, 1.0);
  const std::string b = result_json(again.scenario, {3}, again.verdict, 1.0);
  STRCMP_EQUAL(a.c_str(), b.c_str());
  const auto json = nlohmann::json::parse(a);
  for (const char* key : {"scenario", "scenario_crc", "version", "run", "seed", "outcome", "problem", "frames", "poses",
                          "invalid_flagged_valid", "figures", "nees", "dispersed", "wall_s"})
    CHECK_TRUE(json.contains(key));
}

TEST(Simulation, ASpinWithoutImagesIsFollowed) {
  const Flown flown = fly(scenario_of("spin_features"));
  CHECK_TRUE(flown.verdict.end == RunEnd::tracked);
  CHECK_TRUE(flown.verdict.figures.at("angle_error_percent") < 1.0);
}

TEST(Simulation, TheCovarianceOfASpinIsHonestFromTheFirstFrameOn) {
  double start = 0.0;
  double track = 0.0;
  std::size_t of_start = 0;
  std::size_t of_track = 0;
  constexpr std::uint64_t runs = relnav::test::campaign(12, 2);
  for (std::uint64_t run = 1; run <= runs; ++run) {
    const SimulationScenario scenario = scenario_of("spin_features", run);
    const Flown flown = fly(scenario);
    const auto evaluation =
        evaluate_run(flown.history, plan_simulation(scenario).truth_at_stamps, alignment_of(flown.history));
    CHECK_TRUE(evaluation.has_value());
    for (const EpochError& epoch : evaluation->epochs) {
      if (!epoch.nees) continue;
      const bool early = (epoch.time - flown.history.frames.front().time).seconds() < 3.0;
      (early ? start : track) += *epoch.nees / 3.0;
      ++(early ? of_start : of_track);
    }
  }
  start /= static_cast<double>(of_start);
  track /= static_cast<double>(of_track);
  std::printf("    spin without images, %d runs: NEES a degree of freedom %.2f in the first 3 s, %.2f after\n",
              static_cast<int>(runs), start, track);
  // 1 is right; the filter's errors last, so that twelve runs scatter by a third.
  CHECK_TRUE(start < relnav::test::campaign(2.0, 4.0) && track < relnav::test::campaign(1.5, 3.0));
}

TEST(Simulation, AWrongPoseCalledValidIsCounted) {
  // A focal length that is 10 % off makes every range wrong, which no covariance knows.
  SimulationScenario scenario = scenario_of("stereo");
  scenario.calibration_error.fu_px = 400.0;
  scenario.calibration_error.fv_px = 400.0;
  const Flown flown = fly(scenario);
  CHECK_TRUE(flown.verdict.end == RunEnd::wrong_pose);
  CHECK_TRUE(flown.verdict.wrong_poses > 40);
  CHECK_TRUE(flown.verdict.problem.find("wrong poses called valid") != std::string::npos);
}

TEST(Simulation, HowARunEndsIsSaidByItsEnd) {
  const SimulationScenario scenario = scenario_of("stereo");
  Flown flown = fly(scenario);
  const Trajectory truth = plan_simulation(scenario).truth_at_stamps;
  const auto end = [&] { return judge_run(scenario, flown.outcome, flown.history, truth).end; };
  CHECK_TRUE(end() == RunEnd::tracked);
  flown.history.frames.back().reset_counter = 1;
  CHECK_TRUE(end() == RunEnd::regained);
  flown.outcome.problem = "the run ended without track";
  CHECK_TRUE(end() == RunEnd::lost);
  flown.outcome.poses = 0;
  CHECK_TRUE(end() == RunEnd::no_pose);
}

TEST(Simulation, StampsScatterAboutTheTrueTimes) {
  SimulationScenario scenario = scenario_of("table1");
  scenario.stamp_jitter_s = 1e-3;
  const SimulationPlan plan = plan_simulation(scenario);
  double square_sum = 0.0;
  for (std::size_t k = 0; k < plan.frames.size(); ++k) {
    const double off_s = (plan.frames[k].stamp - plan.frames[k].time).seconds();
    square_sum += off_s * off_s;
    CHECK_TRUE(plan.truth[k].time == plan.frames[k].time);
    CHECK_TRUE(plan.truth_at_stamps[k].time == plan.frames[k].stamp);
  }
  // 1201 draws: the standard deviation within 4 of its own (2 %).
  DOUBLES_EQUAL(1e-3, std::sqrt(square_sum / static_cast<double>(plan.frames.size())), 8.2e-5);
}

TEST(Simulation, OutliersAndMissesDoNotBreakTheTrack) {
  SimulationScenario scenario = scenario_of("table1");
  scenario.features.outlier_share = 0.02;
  scenario.features.missed_share = 0.02;
  const Flown flown = fly(scenario);
  std::printf("    table1 with 2 %% outliers and misses: %zu of %zu poses wrong\n", flown.verdict.wrong_poses,
              flown.verdict.poses);
  CHECK_TRUE(flown.verdict.wrong_poses * 50 <= flown.verdict.poses);
}

TEST(Simulation, OutliersOfASurfaceAreMadeAndRefused) {
  const auto inlier_share = [](double outlier_share) {
    SimulationScenario scenario = scenario_of("spin_features");
    scenario.features.outlier_share = outlier_share;
    const Flown flown = fly(scenario);
    CHECK_TRUE(flown.verdict.end == RunEnd::tracked);
    double matched = 0.0;
    double inliers = 0.0;
    for (const FrameRecord& f : flown.history.frames) {
      matched += f.matched;
      inliers += f.inliers;
    }
    return inliers / matched;
  };
  CHECK_TRUE(inlier_share(0.0) > 0.97);
  DOUBLES_EQUAL(0.8, inlier_share(0.2), 0.04);
}

TEST(Simulation, FlyingBlindIsNoPose) {
  const std::string path =
      scratch.write("blind.yaml",
                    "mode: noncoop\nduration_s: 3\nrate_hz: 10\ncamera: {width_px: 320, height_px: "
                    "240, fu_px: 400}\nmotion: {chaser: {range_m: 8}}\n");
  const Flown flown = fly(read_scenario(path));
  CHECK_TRUE(flown.verdict.end == RunEnd::no_pose);
  LONGS_EQUAL(31, flown.verdict.frames);
  CHECK_TRUE(exit_status_of(flown.outcome) == 1);
}

TEST(Simulation, ACameraInsideOfTheTargetIsRefusedWithItsTime) {
  const std::string path =
      scratch.write("in.yaml",
                    "mode: noncoop\nduration_s: 3\nrate_hz: 10\ncamera: {width_px: 320, height_px: "
                    "240, fu_px: 400}\nmotion: {chaser: {range_m: 3, legs: [{straight: {to_range_m: 0.5, "
                    "duration_s: 2, pace: constant}}]}}\n");
  CHECK_MESSAGE_HOLDS(relnav::test::message_of([&] { static_cast<void>(fly(read_scenario(path))); }),
                      "in.yaml: camera 0 is inside of the target's mesh after 1.700 s");
}

TEST(Simulation, FaultsAreTheFirstCamerasAndAreNotRecorded) {
  const std::string path = scratch.write(
      "f.yaml",
      "mode: noncoop\nduration_s: 2\nrate_hz: 10\nstamp_jitter_s: 0.001\ncamera: {width_px: 320, height_px: "
      "240, fu_px: 400}\nmotion: {chaser: {range_m: 8}}\nfaults: [\"lost@5:3\", \"white@12\"]\n");
  const SimulationScenario scenario = read_scenario(path);
  Packets packets;
  Simulation simulation(
      scenario,
      [](const SimulationScenario&, const CameraModel&, std::uint64_t) {
        return std::make_unique<PlainMaker>(320, 240);
      },
      false, packets);
  std::filesystem::create_directories(scratch.path("frames"));
  SimulatedCapture capture(scratch.path("frames"), scenario, simulation.plan());
  simulation.record_into(capture);
  RunHistory history;
  static_cast<void>(run_replay(simulation.driver(), simulation.cameras(), nullptr, history,
                               [](std::size_t, std::size_t, const app::StepReport&) { return true; }));
  LONGS_EQUAL(18, history.frames.size());
  // What was lost on its way was never made; what came white had been exposed.
  const auto lines = read_lines(scratch.path("frames/mav0/cam0/data.csv"));
  LONGS_EQUAL(19, lines.size());
  for (std::size_t k = 0; k < 18; ++k) {
    const PlannedFrame& frame = simulation.plan().frames[k < 5 ? k : k + 3];
    CHECK_TRUE(frame.stamp != frame.time);
    const std::string stamp = std::to_string(frame.stamp.ns);
    CHECK_TRUE(lines[k + 1] == stamp + "," + stamp + ".png");
  }
  const Image white =
      read_png(scratch.path("frames/mav0/cam0/data/" + std::to_string(simulation.plan().frames[12].stamp.ns) + ".png"));
  LONGS_EQUAL(0, white.bytes[0]);
}

TEST(Simulation, LinesAndTelecommandsReachTheFlight) {
  const std::string path =
      scratch.write("l.yaml",
                    "mode: noncoop\nduration_s: 8\nrate_hz: 10\ncamera: {width_px: 320, height_px: 240, fu_px: 400}\n"
                    "motion: {chaser: {range_m: 8}}\n"
                    "lines: {heartbeat: true, pulse: true, exposure: true, clock_drift_ppb: 20000}\n"
                    "telecommands:\n  - {at_s: 5, command: start}\n  - {at_s: 2.05, command: stop}\n"
                    "  - {at_s: 5.2, command: set_tai, argument: 2000000000}\n");
  const Flown flown = fly(read_scenario(path));
  LONGS_EQUAL(81, flown.history.frames.size());
  std::vector<std::string> times;
  std::string commands;
  for (std::size_t at = 0; at < flown.telemetry.size();) {
    const std::size_t size = flown.telemetry[at + 4] * 256U + flown.telemetry[at + 5] + 7U;
    const std::string text = packet_text(std::span(flown.telemetry).subspan(at, size), telemetry::PacketConfig{});
    if (text.starts_with("TIME")) times.push_back(text);
    if (text.starts_with("TC_ACK") && text.find("stage=done code=ok") != std::string::npos) commands += ".";
    at += size;
  }
  // A pulse a second, by a clock that gains 20 microseconds in each; frames are exposed where their stamps say.
  LONGS_EQUAL(7, times.size());
  CHECK_TRUE(times[4].find("drift_ppb=20000 residual_ns=0") != std::string::npos);
  CHECK_TRUE(times[6].find("exposure_offset_ns=0") != std::string::npos);
  CHECK_TRUE(times[4].find("tai_ns=105000000000 ") != std::string::npos);
  CHECK_TRUE(times[6].find("tai_ns=2000000001000000000 ") != std::string::npos);
  STRCMP_EQUAL("...", commands.c_str());
  // Between stop and start frames go by unseen.
  LONGS_EQUAL(30, std::count_if(flown.history.frames.begin(), flown.history.frames.end(),
                                [](const FrameRecord& f) { return f.mode == app::Mode::standby; }));
  CHECK_TRUE(flown.heartbeats >= 81);
}

TEST(Simulation, AHandOverChangesTheEstimatorAtItsTime) {
  scratch.write("t.yaml",
                "frame: T\nfeatures:\n  - {id: 0, xyz: [0, 0, 0]}\n  - {id: 1, xyz: [1, 0, 0]}\n"
                "  - {id: 2, xyz: [0, 1, 0]}\n  - {id: 3, xyz: [0, 0, 1]}\n");
  const std::string path =
      scratch.write("h.yaml",
                    "mode: noncoop\nduration_s: 3\nrate_hz: 10\ntarget: t.yaml\ncamera: {width_px: "
                    "320, height_px: 240, fu_px: 400}\nmotion: {chaser: {range_m: 8}}\n"
                    "handover: {at_s: 1.5, mode: coop-mono}\n");
  const Flown flown = fly(read_scenario(path));
  // Stopped, and started anew: two changes of mode in the middle of the run.
  const Flown without = fly([&] {
    SimulationScenario s = read_scenario(path);
    s.handover.at_s = -1.0;
    return s;
  }());
  CHECK_TRUE(flown.telemetry.size() != without.telemetry.size());
  LONGS_EQUAL(31, flown.verdict.frames);
}
