#include <Eigen/LU>
#include <cmath>

#include "hil/dynamics/eclipse.hpp"
#include "hil/dynamics/motion_file.hpp"
#include "hil/dynamics/relative_motion.hpp"
#include "hil/scenarios/table1_scenario.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::replaced;
using relnav::test::Scratch;

namespace {

MotionSettings motion_of(const std::string& yaml) {
  return read_motion(FileSection("scene.yaml", YAML::Load(yaml)["motion"], "motion", motion_keys()));
}

Time at_s(double seconds) { return Time{std::llround(seconds * 1e9)}; }

std::vector<SceneState> states(const MotionSettings& motion, std::uint64_t seed, const std::vector<double>& times_s) {
  RelativeMotion course(motion, seed);
  std::vector<SceneState> list;
  for (const double t : times_s) list.push_back(course.at(at_s(t)));
  return list;
}

SceneState state(const MotionSettings& motion, double t_s) { return states(motion, 1, {t_s})[0]; }

double angle_deg(const Mat3& R) { return rotation_vector(R).norm() * degrees_per_radian; }

void check_vectors(const Vec3& expected, const Vec3& actual, double tolerance) {
  DOUBLES_EQUAL(0.0, (actual - expected).norm(), tolerance);
}

/// Velocity and rates of the state against central differences of the poses around it.
void check_rates(const MotionSettings& motion, double t_s, double tolerance) {
  const double h = 0.01;
  const std::vector<SceneState> s = states(motion, 1, {t_s - 2 * h, t_s - h, t_s, t_s + h, t_s + 2 * h});
  const auto slope = [&](const auto& of) {  // fourth order
    return ((of(s[0]) - of(s[4]) + 8.0 * (of(s[3]) - of(s[1]))) / (12.0 * h)).eval();
  };
  check_vectors(slope([](const SceneState& x) { return x.t_CT; }), s[2].velocity_C, tolerance);
  const Mat3 R_rate = slope([](const SceneState& x) { return x.R_CT; });
  const Mat3 W = R_rate * s[2].R_CT.transpose();
  check_vectors(Vec3(W(2, 1), W(0, 2), W(1, 0)), s[2].omega_CT_C, tolerance);
}

const char* const spin = R"(motion:
  sun_C: [1, -1, -1]
  target: {rate_deg_s: [0, 2, 0]}
  chaser: {range_m: 8}
)";

const char* const approach = R"(motion:
  target: {angles_deg: [1.6, 1.4, 0.3], stabilised: inertial}
  chaser:
    range_m: 10.5
    legs:
      - hold: {duration_s: 2}
      - close: {to_range_m: 5, duration_s: 60}
)";

const char* const docking = R"(motion:
  orbit: {semi_major_axis_m: 6778137, inclination_deg: 51.6, raan_deg: 30, eccentricity: 0.001, j2: true}
  sun: {right_ascension_deg: 40, declination_deg: 10}
  target: {relative_to: lvlh, angles_deg: [1, -2, 3], stabilised: lvlh}
  chaser:
    direction: -v-bar
    range_m: 100
    jitter: {sigma_deg: 0.05, frequency_hz: 0.1}
    legs:
      - hold: {duration_s: 20}
      - straight: {to_range_m: 40, speed_m_s: 0.6, acceleration_m_s2: 0.05, pace: trapezoid}
      - fly_around: {axis: r-bar, angle_deg: 20, rate_deg_s: 0.5}
      - straight: {to_m: [-20, 0, 0], speed_m_s: 0.4}
      - close: {to_range_m: 3, duration_s: 90}
      - hold: {duration_s: 30}
      - close: {to_range_m: 1, duration_s: 60}
)";

const char* const turning = R"(motion:
  target: {rate_deg_s: [0.2, -0.3, 0.5], stabilised: inertial}
  chaser:
    range_m: 10
    legs:
      - close: {to_range_m: 5, duration_s: 40}
      - hold: {duration_s: 10}
      - close: {to_range_m: 3, duration_s: 20}
)";

const char* const tumble = R"(motion:
  orbit: {}
  target: {rate_deg_s: [1, 5, 2], inertia_kg_m2: [100, 140, 180, 5, -3, 8], torque_noise_Nm_s05: 0.01}
  chaser:
    position_m: [-50, 3, 10]
    legs:
      - drift: {duration_s: 300, velocity_m_s: [0.05, 0, -0.02], acceleration_noise_m_s15: 0.0001}
      - hold: {duration_s: 10}
)";

const char* const table1 = R"(motion:
  orbit: {semi_major_axis_m: 6721.2e3, inclination_deg: 42.225}
  target: {relative_to: lvlh, stabilised: lvlh, angles_deg: [2, 2, 2], rate_deg_s: [1e-3, 0.08, 1e-3]}
  chaser:
    orbit: {semi_major_axis_m: 6721.2e3, inclination_deg: 42.225005, eccentricity: 1e-7, perigee_time_s: 0.013}
    pointing: lvlh
    angles_deg: [0.1, 0.1, 0.1]
    rate_deg_s: [1e-4, 1e-4, 1e-4]
)";

}  // namespace

TEST_GROUP(DynamicsScenes){};

TEST(DynamicsScenes, ASpinAboutTheCamerasVerticalAxis) {
  const MotionSettings motion = motion_of(spin);
  for (const double t : {0.0, 1.0, 45.0, 150.0}) {
    const SceneState s = state(motion, t);
    check_vectors(Vec3(0.0, 0.0, 8.0), s.t_CT, 1e-12);
    const Mat3 expected = Eigen::AngleAxisd(2.0 * t / degrees_per_radian, Vec3::UnitY()).toRotationMatrix();
    DOUBLES_EQUAL(0.0, (s.R_CT - expected).norm(), 1e-10);
    check_vectors(Vec3(0.0, 2.0 / degrees_per_radian, 0.0), s.omega_CT_C, 1e-12);
    check_vectors(Vec3::Zero(), s.velocity_C, 1e-12);
    check_vectors(Vec3(1.0, -1.0, -1.0).normalized(), s.sun_C, 1e-12);
    DOUBLES_EQUAL(1.0, s.sunlight, 0.0);
  }
}

TEST(DynamicsScenes, AStraightApproachWhoseAttitudeOffsetShrinksToZero) {
  const MotionSettings motion = motion_of(approach);
  const SceneState first = state(motion, 0.0);
  check_vectors(Vec3(0.0, 0.0, 10.5), first.t_CT, 1e-12);
  DOUBLES_EQUAL(0.0, (first.R_CT - rotation_of_angles(Vec3(1.6, 1.4, 0.3))).norm(), 1e-12);
  double angle = angle_deg(first.R_CT);
  for (double t = 3.0; t < 62.5; t += 1.0) {
    const SceneState s = state(motion, t);
    CHECK(angle_deg(s.R_CT) < angle + 1e-9);
    angle = angle_deg(s.R_CT);
    // On the straight line from the first to the last place, in axes that do not turn.
    const Vec3 p_T = -s.R_CT.transpose() * s.t_CT;
    const Vec3 from_T = -first.R_CT.transpose() * first.t_CT;
    const Vec3 along_T = (Vec3(0.0, 0.0, -5.0) - from_T).normalized();
    DOUBLES_EQUAL(0.0, along_T.cross(p_T - from_T).norm(), 1e-12);
    CHECK(std::hypot(s.t_CT.x(), s.t_CT.y()) < 0.02 * s.t_CT.z());
  }
  const SceneState last = state(motion, 62.0);
  check_vectors(Vec3(0.0, 0.0, 5.0), last.t_CT, 1e-12);
  DOUBLES_EQUAL(0.0, angle_deg(last.R_CT), 1e-9);
  check_vectors(Vec3::Zero(), last.velocity_C, 1e-12);
}

TEST(DynamicsScenes, DockingMeetsTheEndsOfItsLegs) {
  const MotionSettings motion = motion_of(replaced(docking, "sigma_deg: 0.05", "sigma_deg: 0"));
  check_vectors(Vec3(0.0, 0.0, 100.0), state(motion, 0.0).t_CT, 1e-6);
  check_vectors(Vec3(0.0, 0.0, 100.0), state(motion, 20.0).t_CT, 1e-6);
  const double line_s = 60.0 / 0.6 + 0.6 / 0.05;
  check_vectors(Vec3(0.0, 0.0, 0.6), -state(motion, 20.0 + 0.5 * line_s).velocity_C, 1e-6);
  const double circle_s = 1.875 * 20.0 / 0.5;
  check_vectors(Vec3(0.0, 0.0, 40.0), state(motion, 20.0 + line_s + circle_s).t_CT, 1e-6);
  const Vec3 corner_L(-40.0 * std::cos(20.0 / degrees_per_radian), -40.0 * std::sin(20.0 / degrees_per_radian), 0.0);
  const double last_line_s = 1.875 * (corner_L - Vec3(-20.0, 0.0, 0.0)).norm() / 0.4;
  const double docking_s = 20.0 + line_s + circle_s + last_line_s;
  check_vectors(Vec3(0.0, 0.0, 20.0), state(motion, docking_s).t_CT, 1e-6);
  for (const double t : {90.0, 100.0, 120.0})
    check_vectors(Vec3(0.0, 0.0, 3.0), state(motion, docking_s + t).t_CT, 1e-6);
  check_vectors(Vec3(0.0, 0.0, 1.0), state(motion, docking_s + 180.0).t_CT, 1e-6);
  DOUBLES_EQUAL(0.0, angle_deg(state(motion, docking_s + 180.0).R_CT), 1e-6);
}

TEST(DynamicsScenes, VelocityAndRateAreThoseOfThePoses) {
  for (const double t : {3.0, 30.0, 61.0}) check_rates(motion_of(approach), t, 1e-9);
  for (const double t : {10.0, 25.0, 80.0, 130.02, 170.0, 250.0, 320.0, 430.0, 500.0, 600.0})
    check_rates(motion_of(docking), t, 1e-6);
  for (const double t : {10.0, 25.0, 45.0, 60.0}) check_rates(motion_of(turning), t, 1e-9);
  for (const double t : {10.0, 200.0, 305.0}) check_rates(motion_of(tumble), t, 1e-5);
  for (const double t : {10.0, 2000.0}) check_rates(motion_of(table1), t, 1e-6);
}

TEST(DynamicsScenes, StatesDoNotDependOnTheTimesAskedFor) {
  std::vector<double> dense;
  for (int i = 0; i <= 3300; ++i) dense.push_back(0.1003 * i);
  for (const char* scene : {tumble, docking}) {
    const MotionSettings motion = motion_of(scene);
    const std::vector<SceneState> often = states(motion, 9, dense);
    const SceneState once = states(motion, 9, {dense.back()})[0];
    DOUBLES_EQUAL(0.0, (often.back().t_CT - once.t_CT).norm(), 0.0);
    DOUBLES_EQUAL(0.0, (often.back().R_CT - once.R_CT).norm(), 0.0);
    DOUBLES_EQUAL(0.0, (often.back().omega_CT_C - once.omega_CT_C).norm(), 0.0);
    const SceneState other = states(motion, 10, {dense.back()})[0];
    CHECK((other.R_CI - once.R_CI).norm() > 1e-6);  // drift and jitter
    const Mat3 R_IT = once.R_CI.transpose() * once.R_CT;
    if (scene == tumble) CHECK((other.R_CI.transpose() * other.R_CT - R_IT).norm() > 1e-6);  // torque
  }
}

TEST(DynamicsScenes, Table1IsThatOfTheScenario) {
  RelativeMotion course(motion_of(table1), 1);
  for (int i = 0; i <= 1200; ++i) {
    const Time time{i * 5'000'000'000LL};
    const TimedPose expected = table1_pose(time);
    const SceneState s = course.at(time);
    check_vectors(expected.t_CT, s.t_CT, 1e-10);
    DOUBLES_EQUAL(0.0, (expected.R_CT - s.R_CT).norm(), 1e-12);
  }
}

TEST(DynamicsScenes, AnApproachFromAboveHasTheEarthBehindTheTarget) {
  const MotionSettings motion = motion_of(R"(motion:
  orbit: {semi_major_axis_m: 6.8e6}
  sun_C: [0, -1, 0]
  target: {relative_to: lvlh, stabilised: lvlh}
  chaser: {range_m: 30, direction: -r-bar, down: -v-bar}
)");
  const SceneState first = state(motion, 0.0);
  for (const double t : {0.0, 700.0, 2000.0}) {
    const SceneState s = state(motion, t);
    check_vectors(Vec3(0.0, 0.0, 30.0), s.t_CT, 1e-8);
    check_vectors(Vec3(0.0, 0.0, 6.8e6 + 30.0), s.earth_C, 1e-3);
    check_vectors(first.R_CI.transpose() * Vec3(0.0, -1.0, 0.0), s.R_CI.transpose() * s.sun_C, 1e-12);
    // z_T ahead along V-bar, which is up in the image; y_T down to the Earth.
    check_vectors(Vec3(0.0, -1.0, 0.0), s.R_CT.col(2), 1e-9);
    check_vectors(Vec3(0.0, 0.0, 1.0), s.R_CT.col(1), 1e-9);
  }
}

TEST(DynamicsScenes, TheTargetPassesIntoShadow) {
  const MotionSettings motion = motion_of(R"(motion:
  orbit: {semi_major_axis_m: 6778137, inclination_deg: 20}
  sun: {right_ascension_deg: 10, declination_deg: 5}
  chaser: {range_m: 20}
)");
  const Vec3 sun_I(std::cos(5.0 / degrees_per_radian) * std::cos(10.0 / degrees_per_radian),
                   std::cos(5.0 / degrees_per_radian) * std::sin(10.0 / degrees_per_radian),
                   std::sin(5.0 / degrees_per_radian));
  int dark = 0;
  int half = 0;
  int bright = 0;
  RelativeMotion course(motion, 1);
  for (int i = 0; i < 5560; ++i) {
    const SceneState s = course.at(at_s(i));
    DOUBLES_EQUAL(sunlight_at(orbit_state(*motion.orbit, i).r_I, sun_I), s.sunlight, 1e-9);
    check_vectors(s.R_CI * sun_I, s.sun_C, 1e-12);
    ++(s.sunlight == 0.0 ? dark : s.sunlight == 1.0 ? bright : half);
  }
  CHECK(dark > 2000 && dark < 2200);
  CHECK(half > 10 && half < 30);
}

TEST(DynamicsScenes, ADriftIsThatOfClohessyAndWiltshire) {
  const MotionSettings motion = motion_of(R"(motion:
  orbit: {semi_major_axis_m: 6778137}
  chaser:
    position_m: [-100, 20, 30]
    legs:
      - drift: {duration_s: 600, velocity_m_s: [0.02, 0.01, -0.03]}
      - hold: {duration_s: 10}
)");
  const LocalState start{Vec3(-100.0, 20.0, 30.0), Vec3(0.02, 0.01, -0.03)};
  const double n = std::sqrt(earth_mu_m3_s2 / std::pow(6778137.0, 3));
  const LocalState expected = clohessy_wiltshire(start, n, 600.0);
  for (const double t : {600.0, 605.0, 700.0}) DOUBLES_EQUAL(expected.p_L.norm(), state(motion, t).t_CT.norm(), 2e-3);
  DOUBLES_EQUAL(clohessy_wiltshire(start, n, 300.0).p_L.norm(), state(motion, 300.0).t_CT.norm(), 1e-3);
}

TEST(DynamicsScenes, WithoutAnOrbitADriftIsAStraightLine) {
  const MotionSettings motion = motion_of(R"(motion:
  chaser:
    range_m: 10
    pointing: fixed
    angles_deg: [0, 5, 0]
    legs:
      - straight: {to_m: [0, 0, -8], speed_m_s: 0.1, pace: constant}
      - drift: {duration_s: 20}
)");
  for (const double t : {0.0, 10.0, 20.0, 35.0}) {
    const SceneState s = state(motion, t);
    const Mat3 R_FC = rotation_of_angles(Vec3(0.0, 5.0, 0.0));
    check_vectors(R_FC.transpose() * Vec3(0.0, 0.0, 10.0 - 0.1 * t), s.t_CT, 1e-9);  // with the speed of the line
    check_vectors(R_FC.transpose() * Vec3(0.0, 0.0, -0.1), s.velocity_C, 1e-9);
    DOUBLES_EQUAL(0.0, (s.R_CI - R_FC.transpose()).norm(), 1e-12);
    CHECK(s.earth_C.z() < -1e11);
  }
}

TEST(DynamicsScenes, ATargetIsStabilisedAgainstWhatIsNamed) {
  const auto flown = [](const std::string& target) {
    return states(
        motion_of("motion:\n  orbit: {j2: true, inclination_deg: 50}\n  target: {" + target +
                  "}\n  chaser: {range_m: 20, legs: [fly_around: {axis: r-bar, angle_deg: 90, duration_s: 90}]}\n"),
        1, {0.0, 40.0, 120.0});
  };
  const Mat3 angles = rotation_of_angles(Vec3(10.0, 20.0, 30.0));
  for (const SceneState& s : flown("angles_deg: [10, 20, 30], stabilised: camera"))
    DOUBLES_EQUAL(0.0, (s.R_CT - angles).norm(), 1e-12);
  const auto still = flown("angles_deg: [10, 20, 30], stabilised: inertial");
  for (const SceneState& s : still)
    DOUBLES_EQUAL(0.0, (s.R_CI.transpose() * s.R_CT - still[0].R_CI.transpose() * angles).norm(), 1e-12);
  const auto local = flown("relative_to: lvlh, angles_deg: [10, 20, 30], stabilised: camera");
  DOUBLES_EQUAL(0.0, (local[0].R_CT - local[2].R_CT).norm(), 1e-12);
  // The camera stands on -V-bar there, with its down on R-bar: x is H-bar, y R-bar, z V-bar.
  DOUBLES_EQUAL(0.0, (forward_in_lvlh() * local[0].R_CT - angles * forward_in_lvlh()).norm(), 1e-12);
}

TEST(DynamicsScenes, ACameraOnItsOwnOrbitFollowsTheTarget) {
  const MotionSettings motion =
      motion_of(replaced(replaced(table1, "pointing: lvlh", "pointing: target"), "rate_deg_s: [1e-4, 1e-4, 1e-4]", ""));
  for (const double t : {0.0, 500.0, 3000.0}) {
    const Vec3 t_CT = rotation_of_angles(Vec3(0.1, 0.1, 0.1)) * state(motion, t).t_CT;
    DOUBLES_EQUAL(0.0, std::hypot(t_CT.x(), t_CT.y()), 1e-6);
    DOUBLES_EQUAL(table1_pose(at_s(t)).t_CT.norm(), t_CT.z(), 1e-6);
  }
}
