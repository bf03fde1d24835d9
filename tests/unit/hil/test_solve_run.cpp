#include "hil/solve/solve_run.hpp"

#include "hil/evaluate/rotation.hpp"
#include "hil/replay/run_folder.hpp"
#include "hil/replay/telemetry_link.hpp"
#include "hil/scenarios/scenario.hpp"
#include "hil/scenarios/targets.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;

namespace {

constexpr double sigma_px = 0.3;

/// A square before one camera; each epoch is one second after the one before.
class SquareScenario {
 public:
  SquareScenario() {
    scenario_.cameras = {forward_camera(1000.0, 1000.0, 1024, 1024)};
    scenario_.target = square_target(0.5);
  }
  /// All four corners, tilted by 0.7 rad.
  ObservationEpoch& add(double range_m) {
    ScenarioRecorder recorder(scenario_, 1);
    TimedPose pose;
    pose.time = Time{static_cast<std::int64_t>(scenario_.truth.size()) * 1'000'000'000};
    pose.t_CT = Vec3(0.0, 0.0, range_m);
    pose.R_CT = rotation_exp(Vec3(0.7, 0.0, 0.0));
    recorder.add(pose, all_features(scenario_.target), sigma_px);
    return scenario_.observations.back();
  }
  [[nodiscard]] const Scenario& scenario() const { return scenario_; }

 private:
  Scenario scenario_;
};

struct SolvedFiles {
  std::vector<std::string> packets;  ///< as text
  std::vector<std::string> events;
  RunHistory history;
  ReplayOutcome outcome;
};

SolvedFiles solve(const Scenario& scenario) {
  const test::Scratch scratch;
  SolvedFiles solved;
  TelemetryLink link;
  link.open(scratch.path("telemetry.bin"), [&](std::span<const std::uint8_t> packet) {
    const std::string event = event_log_line(packet, telemetry::PacketConfig{});
    if (!event.empty()) solved.events.push_back(event);
    solved.packets.push_back(packet_text(packet, telemetry::PacketConfig{}));
  });
  RunFiles files(scratch.path(""));
  solved.outcome =
      run_solve(SolveSetup(), camera_rig_of(scenario.cameras, {"cam0"}), scenario.target, "observations.csv",
                scenario.observations, link, files, solved.history, [](auto, auto, const auto&) { return true; });
  return solved;
}

bool holds(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

}  // namespace

TEST_GROUP(SolveRun){};

TEST(SolveRun, AnEpochWithoutAPoseSaysWhyInItsEvent) {
  SquareScenario square;
  square.add(40.0);  // two minima, no epoch before
  square.add(4.0);
  square.add(4.0).rows.resize(2);             // too few
  ObservationEpoch& mixed = square.add(4.0);  // no square at all
  mixed.rows[0].uv_px += Vec2(60.0, 0.0);
  ObservationEpoch& point = square.add(4.0);  // all in one place
  for (ObservationRow& row : point.rows) row.uv_px = Vec2(500.0, 500.0);
  square.add(4.0);
  const SolvedFiles solved = solve(square.scenario());

  LONGS_EQUAL(2, solved.outcome.poses);
  LONGS_EQUAL(6, solved.history.frames.size());
  LONGS_EQUAL(4, solved.events.size());
  CHECK_TEXT(holds(solved.events[0], "pose_ambiguous status=ambiguous spots=4"), solved.events[0].c_str());
  CHECK_TEXT(holds(solved.events[1], "too_few_features status=too_few_features features=2 needed=3"),
             solved.events[1].c_str());
  CHECK_TEXT(holds(solved.events[2], "update_refused status=inconsistent test_ratio_1e3="), solved.events[2].c_str());
  CHECK_TEXT(holds(solved.events[2], "matched=4 inliers=0"), solved.events[2].c_str());
  CHECK_TEXT(!holds(solved.events[2], "test_ratio_1e3=0 "), solved.events[2].c_str());
  CHECK_TEXT(holds(solved.events[3], "numerical_fault status="), solved.events[3].c_str());
  const Status expected[] = {Status::ambiguous, Status::ok, Status::too_few_features, Status::inconsistent};
  for (std::size_t i = 0; i < 4; ++i) CHECK(solved.history.frames[i].status == expected[i]);
  CHECK(solved.history.frames[5].has_pose);
}
