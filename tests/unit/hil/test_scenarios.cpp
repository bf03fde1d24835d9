#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "hil/dynamics/lvlh.hpp"
#include "hil/evaluate/rotation.hpp"
#include "hil/scenarios/random_scenario.hpp"
#include "hil/scenarios/stereo_scenarios.hpp"
#include "hil/scenarios/table1_scenario.hpp"
#include "hil/scenarios/targets.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "platform/files/target_file.hpp"
#include "platform/files/text.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::Scratch;

namespace {

double angle_deg(const TimedPose& pose) { return rotation_vector(pose.R_CT).norm() * degrees_per_radian; }

ScenarioOptions options(double sigma_px, std::size_t count, std::uint64_t seed = 1) {
  ScenarioOptions o;
  o.sigma_px = sigma_px;
  o.count = count;
  o.seed = seed;
  return o;
}

std::string all_bytes(const std::string& folder, std::size_t cameras) {
  std::string bytes;
  for (const char* name : {"/target.yaml", "/observations.csv", "/truth.tum", "/cam0.yaml"})
    bytes += read_text(folder + name);
  return cameras > 1 ? bytes + read_text(folder + "/cam1.yaml") : bytes;
}

/// RMS of the difference between the pixels and those of the truth, over the noise that is stated.
struct Residuals {
  double rms = 0.0;
  double mean = 0.0;
  std::size_t count = 0;
};

/// Writes the scenario, reads it with the readers of `relnav solve` and compares.
Residuals residuals_of_files(const Scratch& scratch, const Scenario& scenario) {
  write_scenario(scenario, scratch.path(""));
  std::vector<std::string> camera_files;
  for (std::size_t i = 0; i < scenario.cameras.size(); ++i)
    camera_files.push_back(scratch.path("cam" + std::to_string(i) + ".yaml"));
  const CameraRig rig = read_camera_rig(camera_files);
  const TargetModel target = read_target_file(scratch.path("target.yaml"));
  const std::string csv = scratch.path("observations.csv");
  const auto epochs = read_observations(csv);
  const Trajectory truth = read_trajectory(scratch.path("truth.tum"));
  CHECK_EQUAL(scenario.truth.size(), truth.size());
  CHECK_EQUAL(truth.size(), epochs.size());
  Residuals r;
  for (std::size_t i = 0; i < epochs.size(); ++i) {
    CHECK(epochs[i].time == truth[i].time);
    for (const PoseObservation& o : pose_observations(csv, epochs[i], target, rig)) {
      const Vec3 p_C0 = truth[i].R_CT * target.features[o.feature].p_T + truth[i].t_CT;
      Vec2 uv_px;
      CHECK(rig[o.camera].model.project(Vec3(rig[o.camera].R_KC * p_C0 + rig[o.camera].t_KC), uv_px) == Status::ok);
      const Vec2 residual = (o.uv_px - uv_px) / o.sigma_px;
      r.rms += residual.squaredNorm();
      r.mean += residual.sum();
      r.count += 2;
    }
  }
  r.rms = std::sqrt(r.rms / static_cast<double>(r.count));
  r.mean /= static_cast<double>(r.count);
  return r;
}

void check_is_unit_noise(const Residuals& r) {
  const double n = static_cast<double>(r.count);
  DOUBLES_EQUAL(1.0, r.rms, 4.0 / std::sqrt(2.0 * n));
  DOUBLES_EQUAL(0.0, r.mean, 4.0 / std::sqrt(n));
}

}  // namespace

TEST_GROUP(Orbit){};

TEST(Orbit, FollowsKepler) {
  OrbitElements o;
  o.inclination_rad = 0.7;
  o.raan_rad = 0.3;
  o.argument_of_perigee_rad = -0.4;
  o.eccentricity = 0.2;
  o.semi_major_axis_m = 8e6;
  o.perigee_time_s = 100.0;
  const double period_s = 2.0 * pi * std::sqrt(8e6 * 8e6 * 8e6 / 3.986004418e14);
  DOUBLES_EQUAL(6.4e6, orbit_state(o, 100.0).r_I.norm(), 1e-3);
  DOUBLES_EQUAL(9.6e6, orbit_state(o, 100.0 + 0.5 * period_s).r_I.norm(), 1e-3);
  // Two-body acceleration, by central differences.
  const double h = 1.0;
  const Vec3 r = orbit_state(o, 900.0).r_I;
  const Vec3 a = (orbit_state(o, 900.0 + h).r_I - 2.0 * r + orbit_state(o, 900.0 - h).r_I) / (h * h);
  const Vec3 gravity = -3.986004418e14 / std::pow(r.norm(), 3) * r;
  DOUBLES_EQUAL(0.0, (a - gravity).norm(), 1e-5 * gravity.norm());
}

TEST(Orbit, LocalFramePointsAlongTrackAndDown) {
  OrbitElements o;
  o.semi_major_axis_m = 7e6;
  o.inclination_rad = 1.0;
  const InertialState s = orbit_state(o, 500.0);
  const Mat3 R_IL = local_frame(s, Gravity::point_mass).R_AB;
  const Vec3 track = (orbit_state(o, 500.1).r_I - orbit_state(o, 499.9).r_I).normalized();
  DOUBLES_EQUAL(1.0, R_IL.col(0).dot(track), 1e-9);
  DOUBLES_EQUAL(-1.0, R_IL.col(2).dot(s.r_I.normalized()), 1e-12);
  DOUBLES_EQUAL(0.0, (R_IL * R_IL.transpose() - Mat3::Identity()).norm(), 1e-12);
}

TEST_GROUP(Targets){};

TEST(Targets, VisibleVerticesAreThoseOfFacesTurnedToTheCamera) {
  TimedPose pose;
  pose.t_CT = Vec3(0.0, 0.0, 10.0);  // the camera is on -z of T
  CHECK((visible_cube_vertices(2.0, pose) == std::vector<std::size_t>{0, 1, 2, 3}));
  pose.t_CT = Vec3(-2.0, 0.0, 10.0);  // and beyond +x
  CHECK((visible_cube_vertices(2.0, pose) == std::vector<std::size_t>{0, 1, 2, 3, 5, 7}));
  pose.t_CT = Vec3(-2.0, -2.0, 10.0);  // and beyond +y: all but the far corner
  CHECK((visible_cube_vertices(2.0, pose) == std::vector<std::size_t>{0, 1, 2, 3, 5, 6, 7}));
  pose.t_CT = Vec3(-0.9, 0.0, 10.0);
  CHECK_EQUAL(4U, visible_cube_vertices(2.0, pose).size());
}

TEST_GROUP(Table1Scenario) { Scratch scratch; };

TEST(Table1Scenario, AttitudePassesHalfATurnAtThePapersTime) {
  double largest_deg = 0.0;
  std::int64_t at_ns = 0;
  for (std::int64_t ns = 2'200'000'000'000; ns <= 2'260'000'000'000; ns += 10'000'000) {
    const double deg = angle_deg(table1_pose(Time{ns}));
    if (deg > largest_deg) {
      largest_deg = deg;
      at_ns = ns;
    }
  }
  DOUBLES_EQUAL(2228.6, static_cast<double>(at_ns) * 1e-9, 0.05);
  CHECK(largest_deg > 179.99);
}

TEST(Table1Scenario, RangeStaysInItsBandAndTheCubeInTheImage) {
  const Scenario scenario = table1_scenario(options(1.0, 0));
  CHECK_EQUAL(1201U, scenario.truth.size());
  CHECK(scenario.truth.back().time.ns == 6'000'000'000'000);
  double least = 1e9;
  double largest = 0.0;
  for (const TimedPose& pose : scenario.truth) {
    least = std::min(least, pose.t_CT.norm());
    largest = std::max(largest, pose.t_CT.norm());
  }
  DOUBLES_EQUAL(98.77, least, 0.02);
  DOUBLES_EQUAL(101.46, largest, 0.02);
  CHECK_EQUAL(1201U, scenario.observations.size());
  for (std::size_t i = 0; i < scenario.truth.size(); ++i) {
    CHECK_EQUAL(visible_cube_vertices(2.0, scenario.truth[i]).size(), scenario.observations[i].rows.size());
  }
}

TEST(Table1Scenario, BoundOfThePoseIsThatOfAnIndependentReproduction) {
  const Scenario scenario = table1_scenario(options(1.0, 0));
  const CameraRig rig = camera_rig_of(scenario.cameras, {"cam0.yaml"});
  Vec6 variance = Vec6::Zero();
  for (std::size_t i = 0; i < scenario.truth.size(); ++i) {
    Mat6 information = Mat6::Zero();
    for (const ObservationRow& row : scenario.observations[i].rows) {
      const Vec3 p_R = scenario.truth[i].R_CT * scenario.target.features[row.feature_id].p_T;
      Vec2 uv_px;
      Mat23 J_uv_p;
      CHECK(rig[0].model.project(Vec3(p_R + scenario.truth[i].t_CT), uv_px, J_uv_p) == Status::ok);
      Mat<2, 6> J;
      J << J_uv_p, -J_uv_p * cross_matrix(p_R);
      information += J.transpose() * J;
    }
    variance += information.inverse().diagonal() / static_cast<double>(scenario.truth.size());
  }
  // cooperative-mono.md, column CRLB, in body axes there: X_B = z_C, Y_B = x_C, Z_B = y_C.
  const Vec6 sigma = variance.cwiseSqrt();
  DOUBLES_EQUAL(0.093, sigma(2), 0.001);
  DOUBLES_EQUAL(0.0016, sigma(0), 0.0001);
  DOUBLES_EQUAL(0.0015, sigma(1), 0.0001);
  DOUBLES_EQUAL(0.054, sigma(5) * degrees_per_radian, 0.001);
  DOUBLES_EQUAL(0.084, sigma(3) * degrees_per_radian, 0.001);
  DOUBLES_EQUAL(0.083, sigma(4) * degrees_per_radian, 0.001);
}

TEST(Table1Scenario, FilesReadBackWithTheNoiseThatIsStated) {
  check_is_unit_noise(residuals_of_files(scratch, table1_scenario(options(0.5, 300))));
}

TEST(Table1Scenario, WithoutNoisePixelsAreThoseOfTheTruth) {
  const Scenario scenario = table1_scenario(options(0.0, 50));
  CHECK(residuals_of_files(scratch, scenario).rms * noise_free_sigma_px < 1e-5);
  DOUBLES_EQUAL(noise_free_sigma_px, scenario.observations[0].rows[0].sigma_px, 0.0);
}

TEST(Table1Scenario, SameSeedSameBytes) {
  const auto bytes = [&](std::uint64_t seed) {
    write_scenario(table1_scenario(options(1.0, 20, seed)), scratch.path(""));
    return all_bytes(scratch.path(""), 1);
  };
  const std::string first = bytes(1);
  CHECK(first == bytes(1));
  CHECK(first != bytes(2));
}

TEST_GROUP(StereoScenarios) { Scratch scratch; };

TEST(StereoScenarios, NoiseIsSwept) {
  const Scenario scenario = stereo_noise_scenario(options(2.0, 30));
  CHECK_EQUAL(9U * 30U, scenario.truth.size());
  for (int step = 0; step <= stereo_noise_steps; ++step) {
    const ObservationEpoch& epoch = scenario.observations[static_cast<std::size_t>(30 * step)];
    CHECK_EQUAL(8U, epoch.rows.size());
    DOUBLES_EQUAL(step == 0 ? noise_free_sigma_px : 0.25 * step, epoch.rows[7].sigma_px, 1e-12);
  }
  Scenario noisy = scenario;  // the levels with noise alone
  noisy.truth.erase(noisy.truth.begin(), noisy.truth.begin() + 30);
  noisy.observations.erase(noisy.observations.begin(), noisy.observations.begin() + 30);
  check_is_unit_noise(residuals_of_files(scratch, noisy));
}

TEST(StereoScenarios, PoseIsSweptWithAllOfTheTargetInBothImages) {
  const Scenario scenario = stereo_pose_scenario(options(1.0, 2));
  CHECK_EQUAL(2U * (3U * 17U + 15U), scenario.truth.size());
  for (const ObservationEpoch& epoch : scenario.observations) CHECK_EQUAL(8U, epoch.rows.size());
  DOUBLES_EQUAL(-40.0, rotation_vector(scenario.truth[0].R_CT).x() * degrees_per_radian, 1e-9);
  DOUBLES_EQUAL(40.0, rotation_vector(scenario.truth[2 * 17 * 3 - 1].R_CT).z() * degrees_per_radian, 1e-9);
  DOUBLES_EQUAL(3.0, scenario.truth[2 * 17 * 3].t_CT.z(), 1e-12);
  DOUBLES_EQUAL(10.0, scenario.truth.back().t_CT.z(), 1e-12);
  check_is_unit_noise(residuals_of_files(scratch, scenario));
}

TEST(StereoScenarios, CamerasAndLinesAreThePapers) {
  const Scenario scenario = stereo_noise_scenario(options(1.0, 1));
  DOUBLES_EQUAL(4137.8, scenario.cameras[0].intrinsics.fu, 0.1);
  DOUBLES_EQUAL(4147.2, scenario.cameras[1].intrinsics.fv, 0.1);
  const CameraRig rig = camera_rig_of(scenario.cameras, {"a", "b"});
  DOUBLES_EQUAL(0.0, (rig[1].t_KC - Vec3(-1.0, 0.0, 0.0)).norm(), 1e-12);
  CHECK_EQUAL(3U, scenario.target.lines.size());
  const auto p = [&](std::size_t i) { return scenario.target.features[i].p_T; };
  DOUBLES_EQUAL(1.0, (p(2) - p(0)).x(), 1e-12);  // x toward C
  DOUBLES_EQUAL(1.0, (p(3) - p(1)).y(), 1e-12);  // y toward D
}

TEST(StereoScenarios, SecondCameraOfAnotherScenarioIsRemoved) {
  write_scenario(stereo_noise_scenario(options(1.0, 1)), scratch.path(""));
  CHECK(std::filesystem::exists(scratch.path("cam1.yaml")));
  write_scenario(table1_scenario(options(1.0, 1)), scratch.path(""));
  CHECK(!std::filesystem::exists(scratch.path("cam1.yaml")));
}

TEST_GROUP(RandomScenario) { Scratch scratch; };

TEST(RandomScenario, AQuarterTurnsByHalfATurnAndTheRestCoversTheRotations) {
  const Scenario scenario = random_scenario(RandomTarget::eight_points, options(1.0, 2000));
  CHECK_EQUAL(2000U, scenario.truth.size());
  Vec3 axes = Vec3::Zero();
  int below_half = 0;
  for (std::size_t i = 0; i < scenario.truth.size(); ++i) {
    const TimedPose& pose = scenario.truth[i];
    CHECK_EQUAL(8U, scenario.observations[i].rows.size());
    CHECK(pose.t_CT.z() >= 6.0 && pose.t_CT.z() <= 7.5);
    if (i % 4 == 3) {
      DOUBLES_EQUAL(180.0, angle_deg(pose), 1e-6);
      DOUBLES_EQUAL(-1.0, pose.R_CT.trace(), 1e-14);
      axes += (pose.R_CT.diagonal() + Vec3::Ones()) / 2.0;  // squares of the axis
    } else {
      below_half += angle_deg(pose) < 90.0 ? 1 : 0;
    }
  }
  for (int k = 0; k < 3; ++k) DOUBLES_EQUAL(1.0 / 3.0, axes(k) / 500.0, 0.06);
  // Angles of even rotations have the density (1 - cos) / pi: 0.1817 below 90 deg.
  DOUBLES_EQUAL(0.1817, below_half / 1500.0, 0.04);
}

TEST(RandomScenario, FilesReadBackForBothTargets) {
  check_is_unit_noise(residuals_of_files(scratch, random_scenario(RandomTarget::eight_points, options(1.0, 200))));
  const Scenario cube = random_scenario(RandomTarget::cube, options(1.0, 200));
  check_is_unit_noise(residuals_of_files(scratch, cube));
  std::size_t least = 8;
  std::size_t most = 0;
  for (const ObservationEpoch& epoch : cube.observations) {
    least = std::min(least, epoch.rows.size());
    most = std::max(most, epoch.rows.size());
  }
  CHECK_EQUAL(4U, least);
  CHECK_EQUAL(7U, most);
}

TEST(RandomScenario, SameSeedSameBytes) {
  const auto bytes = [&](std::uint64_t seed) {
    write_scenario(random_scenario(RandomTarget::cube, options(1.0, 20, seed)), scratch.path(""));
    return all_bytes(scratch.path(""), 1);
  };
  const std::string first = bytes(7);
  CHECK(first == bytes(7));
  CHECK(first != bytes(8));
}
