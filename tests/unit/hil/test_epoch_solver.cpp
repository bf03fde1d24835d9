#include "hil/solve/epoch_solver.hpp"

#include <cmath>
#include <cstdio>
#include <memory>

#include "hil/evaluate/evaluation.hpp"
#include "hil/evaluate/rotation.hpp"
#include "hil/scenarios/random_scenario.hpp"
#include "hil/scenarios/stereo_scenarios.hpp"
#include "hil/scenarios/table1_scenario.hpp"
#include "hil/scenarios/targets.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;

namespace {

/// Every epoch of a scenario through the solver.
struct SolvedRun {
  Trajectory poses;  ///< with status ok
  std::vector<TimedCovariance> covariances;
  std::vector<Status> statuses;  ///< of every epoch

  [[nodiscard]] Evaluation against(const Trajectory& truth) const {
    return evaluate(truth, poses, &covariances, AlignMode::none);
  }
};

CameraRig rig_of(const Scenario& scenario) { return camera_rig_of(scenario.cameras, {"cam0", "cam1"}); }

SolvedRun solve_all(const Scenario& scenario, const SolveSetup& setup) {
  const CameraRig rig = rig_of(scenario);
  const auto solver = std::make_unique<EpochSolver>(setup, rig, scenario.target);
  SolvedRun run;
  for (const ObservationEpoch& epoch : scenario.observations) {
    const app::StepReport& report =
        solver->solve(epoch.time, pose_observations("scenario", epoch, scenario.target, rig));
    run.statuses.push_back(report.status);
    if (report.status != Status::ok) continue;
    run.poses.push_back({report.state.time, report.state.t_CT, report.state.R_CT});
    run.covariances.push_back({report.state.time, report.state.pose_covariance});
  }
  return run;
}

ScenarioOptions options(double sigma_px, std::size_t count) {
  ScenarioOptions o;
  o.sigma_px = sigma_px;
  o.count = count;
  return o;
}

SolveSetup setup_of(SolveScalar scalar, bool switching) {
  SolveSetup setup;
  setup.scalar = scalar;
  setup.switching = switching;
  return setup;
}

/// RMS error over the mean variance the solver states, an axis.
Vec6 rms_over_sigma(const Evaluation& e, const SolvedRun& run) {
  Vec6 variance = Vec6::Zero();
  for (const TimedCovariance& c : run.covariances) variance += c.P.diagonal() / static_cast<double>(run.poses.size());
  Vec6 rms;
  rms << e.position.rms_axis, e.attitude.rms_axis;
  return rms.cwiseQuotient(variance.cwiseSqrt());
}

/// Epochs without a pose.
struct Gap {
  std::size_t at_half_turn = 0;  ///< within 0.6 deg of 180 deg
  std::size_t elsewhere = 0;
};
Gap gap_of(const Scenario& scenario, const SolvedRun& run) {
  Gap gap;
  for (std::size_t i = 0; i < run.statuses.size(); ++i) {
    if (run.statuses[i] == Status::ok) continue;
    const double angle_deg = rotation_vector(scenario.truth[i].R_CT).norm() * degrees_per_radian;
    ++(angle_deg > 179.4 ? gap.at_half_turn : gap.elsewhere);
  }
  return gap;
}

}  // namespace

TEST_GROUP(EpochSolver){};

// Each pose has nothing to do with the one before; a quarter is a turn by 180 deg.
TEST(EpochSolver, RandomEpochsAreAllRight) {
  const Scenario scenario = random_scenario(RandomTarget::eight_points, options(1.0, 200));
  const SolvedRun run = solve_all(scenario, SolveSetup());
  LONGS_EQUAL(200, run.poses.size());
  const Evaluation e = run.against(scenario.truth);
  LONGS_EQUAL(200, e.epochs.size());
  CHECK(e.attitude.max < 5.0 / degrees_per_radian);
  CHECK(e.nees.has_value());
  DOUBLES_EQUAL(6.0, e.nees->mean, 4.0 * std::sqrt(12.0 / 200.0));
}

// What telemetry says made the pose.
TEST(EpochSolver, TheEstimatorIsNamedByItsMethod) {
  using telemetry::Estimator;
  const Scenario mono = random_scenario(RandomTarget::eight_points, options(1.0, 1));
  const Scenario stereo = stereo_pose_scenario(options(1.0, 1));
  const auto estimator_of = [](const Scenario& scenario, CooperativeMethod method) {
    SolveSetup setup;
    setup.config.method = method;
    const CameraRig rig = rig_of(scenario);
    const auto solver = std::make_unique<EpochSolver>(setup, rig, scenario.target);
    const ObservationEpoch& epoch = scenario.observations[0];
    const app::StepReport& report =
        solver->solve(epoch.time, pose_observations("scenario", epoch, scenario.target, rig));
    CHECK(report.status == Status::ok);
    return report.estimator;
  };
  CHECK(estimator_of(mono, CooperativeMethod::least_squares) == Estimator::mono_least_squares);
  CHECK(estimator_of(stereo, CooperativeMethod::least_squares) == Estimator::stereo_least_squares);
  CHECK(estimator_of(stereo, CooperativeMethod::motor) == Estimator::motor);
  CHECK(estimator_of(stereo, CooperativeMethod::orthogonal) == Estimator::orthogonal);
}

// Noise of 1 and 2 px at 4.2 m, and poses from 3 to 10 m.
TEST(EpochSolver, ClosedFormsStateAnHonestCovariance) {
  const Scenario noise = stereo_noise_scenario(options(2.0, 100));
  const Scenario pose = stereo_pose_scenario(options(1.0, 20));
  for (const CooperativeMethod method : {CooperativeMethod::motor, CooperativeMethod::orthogonal}) {
    for (const Scenario* scenario : {&noise, &pose}) {
      SolveSetup setup;
      setup.config.method = method;
      SolvedRun run = solve_all(*scenario, setup);
      LONGS_EQUAL(scenario->truth.size(), run.poses.size());
      if (scenario == &noise) {  // the first hundred are without noise
        run.poses.erase(run.poses.begin(), run.poses.begin() + 100);
        run.covariances.erase(run.covariances.begin(), run.covariances.begin() + 100);
      }
      const Evaluation e = run.against(scenario->truth);
      std::printf("%s, stereo-%s: NEES %.2f\n", method == CooperativeMethod::motor ? "motor" : "orthogonal",
                  scenario == &noise ? "noise" : "pose", e.nees->mean);
      DOUBLES_EQUAL(6.0, e.nees->mean, 4.0 * std::sqrt(12.0 / static_cast<double>(run.poses.size())));
    }
  }
}

/// Largest distance from the same in double, in sigma.
double distance_from_double(const Scenario& scenario, SolveSetup setup) {
  const SolvedRun narrow = solve_all(scenario, setup);
  setup.scalar = SolveScalar::in_double;
  const SolvedRun in_double = solve_all(scenario, setup);
  CHECK(narrow.statuses == in_double.statuses);
  double largest = 0.0;
  for (std::size_t i = 0; i < in_double.poses.size(); ++i) {
    Vec6 d;
    d << narrow.poses[i].t_CT - in_double.poses[i].t_CT,
        rotation_vector(narrow.poses[i].R_CT * in_double.poses[i].R_CT.transpose());
    largest = std::max(largest, std::sqrt(test::mahalanobis_squared(d, in_double.covariances[i].P)));
  }
  return largest;
}

// The papers' scenarios; the issue asks for 0.01 sigma at most, better 0.001.
TEST(EpochSolver, NarrowArithmeticAgreesWithDouble) {
  const struct {
    const char* name;
    Scenario scenario;
    CooperativeMethod method;
  } cases[] = {{"table1", table1_scenario(options(1.0, 300)), CooperativeMethod::least_squares},
               {"stereo-pose, ml", stereo_pose_scenario(options(1.0, 10)), CooperativeMethod::least_squares},
               {"stereo-pose, motor", stereo_pose_scenario(options(1.0, 10)), CooperativeMethod::motor}};
  for (const auto& c : cases) {
    SolveSetup setup;
    setup.config.method = c.method;
    setup.scalar = SolveScalar::in_float;
    const double in_float = distance_from_double(c.scenario, setup);
    setup.scalar = SolveScalar::in_fixed;
    const double in_fixed = distance_from_double(c.scenario, setup);
    std::printf("%s: float %.1e, Q16.47 %.1e sigma from double\n", c.name, in_float, in_fixed);
    CHECK_TEXT(in_float < 0.01, c.name);
    CHECK_TEXT(in_fixed < 1e-5, c.name);
    CHECK_TEXT(in_float > 1e-6 && in_fixed > 0.0, c.name);  // it is that arithmetic
  }
}

// The epoch before leads to the pose; that its chi-square is too large must not be the end of it.
TEST(EpochSolver, NarrowArithmeticLeavesAGrossErrorOut) {
  Scenario scenario = stereo_pose_scenario(options(1.0, 1));
  scenario.observations[3].rows[2].uv_px.x() += 60.0;
  for (const SolveScalar scalar : {SolveScalar::in_float, SolveScalar::in_fixed}) {
    CHECK(distance_from_double(scenario, setup_of(scalar, true)) < 0.01);
    CHECK(solve_all(scenario, setup_of(scalar, true)).statuses[3] == Status::ok);
  }
}

// Four markers in a square seen from the front by one camera: tilted one way or the other, the pixels are alike.
TEST(EpochSolver, AmbiguousSquareGivesNoValidPose) {
  Scenario scenario;
  scenario.cameras = {forward_camera(1000.0, 1000.0, 1024, 1024)};
  scenario.target = square_target(0.5);
  ScenarioRecorder recorder(scenario, 1);
  TimedPose pose;
  pose.t_CT = Vec3(0.0, 0.0, 40.0);
  pose.R_CT = rotation_exp(Vec3(0.3, 0.0, 0.0));
  recorder.add(pose, all_features(scenario.target), 0.3);
  const SolvedRun run = solve_all(scenario, SolveSetup());
  LONGS_EQUAL(0, run.poses.size());
  LONGS_EQUAL(static_cast<int>(Status::ambiguous), static_cast<int>(run.statuses[0]));
}

TEST(EpochSolver, Table1ReachesTheBoundAndHasNoGapAtHalfATurn) {
  const Scenario scenario = table1_scenario(options(1.0, 0));
  const SolvedRun run = solve_all(scenario, SolveSetup());
  LONGS_EQUAL(table1_epochs, run.poses.size());
  const Evaluation e = run.against(scenario.truth);
  LONGS_EQUAL(0, e.missing.size());
  const Vec6 ratio = rms_over_sigma(e, run);
  std::printf("table1: RMS over sigma %.3f %.3f %.3f, %.3f %.3f %.3f, NEES %.3f\n", ratio(0), ratio(1), ratio(2),
              ratio(3), ratio(4), ratio(5), e.nees->mean);
  const double band = 4.0 / std::sqrt(2.0 * static_cast<double>(table1_epochs));  // of an RMS, 4 sigma
  for (int k = 0; k < 6; ++k) DOUBLES_EQUAL(1.0, ratio(k), band);
  DOUBLES_EQUAL(6.0, e.nees->mean, 4.0 * std::sqrt(12.0 / static_cast<double>(table1_epochs)));
  // The column CRLB of the reproduction: across, across, along.
  DOUBLES_EQUAL(0.0016, e.position.rms_axis.x(), 0.0002);
  DOUBLES_EQUAL(0.0015, e.position.rms_axis.y(), 0.0002);
  DOUBLES_EQUAL(0.093, e.position.rms_axis.z(), 0.008);
}

// What MSR is for: g has no bound near 180 deg. Double bears it, fixed point does not.
TEST(EpochSolver, WithoutSwitchingFixedPointLosesTheHalfTurn) {
  const Scenario scenario = table1_scenario(options(1.0, 600));
  LONGS_EQUAL(600, solve_all(scenario, setup_of(SolveScalar::in_double, false)).poses.size());
  LONGS_EQUAL(600, solve_all(scenario, setup_of(SolveScalar::in_fixed, true)).poses.size());
  const Gap gap = gap_of(scenario, solve_all(scenario, setup_of(SolveScalar::in_fixed, false)));
  std::printf("table1 in fixed point without switching: %zu epochs lost at 180 deg, %zu elsewhere\n", gap.at_half_turn,
              gap.elsewhere);
  LONGS_EQUAL(3, gap.at_half_turn);  // all there are: an epoch is 0.4 deg
  LONGS_EQUAL(0, gap.elsewhere);
}
