#include "hil/dynamics/motion_file.hpp"
#include "hil/dynamics/relative_motion.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::replaced;

namespace {

const char* const scene = R"(motion:
  orbit:
    semi_major_axis_m: 6778000
    eccentricity: 0.001
    j2: false
  sun: {right_ascension_deg: 40, declination_deg: 10}
  target:
    angles_deg: [1, 2, 3]
    rate_deg_s: [0, 2, 0]
    inertia_kg_m2: [100, 140, 180]
    stabilised: none
  chaser:
    range_m: 50
    direction: -v-bar
    legs:
      - hold: {duration_s: 10}
      - straight: {to_range_m: 20, speed_m_s: 0.5}
      - fly_around: {axis: r-bar, angle_deg: 30, rate_deg_s: 0.5}
      - drift: {duration_s: 10}
)";

std::string refusal(const std::string& yaml) {
  return message_of([&] {
    static_cast<void>(read_motion(FileSection("s.yaml", YAML::Load(yaml)["motion"], "motion", motion_keys())));
  });
}

void check_refused(const std::string& from, const std::string& to, const std::string& where, const std::string& what) {
  const std::string message = refusal(replaced(scene, from, to));
  if (message.find("s.yaml:" + where + ": ") != 0 || message.find(what) == std::string::npos ||
      message.find("(expected ") == std::string::npos) {
    FAIL(("with '" + to + "': '" + message + "' instead of line " + where + ", '" + what + "'").c_str());
  }
}

}  // namespace

TEST_GROUP(DynamicsMotionFile){};

TEST(DynamicsMotionFile, TheSceneThatTheOthersBreakIsTaken) { STRCMP_EQUAL("", refusal(scene).c_str()); }

TEST(DynamicsMotionFile, ImpossibleOrbitsAreNamed) {
  check_refused("eccentricity: 0.001", "eccentricity: 0.95", "4", "motion.orbit.eccentricity is '0.95'");
  check_refused("eccentricity: 0.001", "eccentricity: -0.1", "4", "a number from 0 to 0.9");
  check_refused("eccentricity: 0.001", "eccentricity: 0.1", "3", "the Earth's radius");
  check_refused("6778000", "6378", "3", "an orbit with its perigee");
  check_refused("6778000", "six", "3", "motion.orbit.semi_major_axis_m is 'six'");
  check_refused("j2: false", "j2: 3", "5", "true, false");
  check_refused("eccentricity", "excentricity", "4", "unknown key 'motion.orbit.excentricity'");
}

TEST(DynamicsMotionFile, ImpossibleSunsAreNamed) {
  check_refused("declination_deg: 10", "declination_deg: 100", "6", "a number from -90 to 90");
  check_refused("  sun:", "  sun_I: [1, 0, 0]\n  sun:", "2", "more than one direction of the sun");
  check_refused("sun: {right_ascension_deg: 40, declination_deg: 10}", "sun_C: [0, 0, 0]", "6", "sun_C has no length");
  check_refused("sun: {right_ascension_deg: 40, declination_deg: 10}", "sun_I: [0, 1]", "6", "2 numbers");
}

TEST(DynamicsMotionFile, ImpossibleTargetsAreNamed) {
  check_refused("[100, 140, 180]", "[0, 140, 140]", "10", "moments positive");
  check_refused("[100, 140, 180]", "[-100, 140, 180]", "10", "moments positive");
  check_refused("[100, 140, 180]", "[10, 140, 180]", "10", "none larger than the sum of the other two");
  check_refused("[100, 140, 180]", "[100, 140]", "10", "2 numbers of inertia");
  check_refused("[100, 140, 180]", "[100, 140, 180, 200, 0, 0]", "10", "principal moments");
  check_refused("[100, 140, 180]", "[100, 1, 0, 0, 140, 0, 0, 0, 180]", "10", "not symmetric");
  check_refused("[100, 140, 180]", "[100, 140, .nan]", "10", "a finite number");
  check_refused("stabilised: none", "stabilised: yes", "11", "one of none, inertial, lvlh, camera");
  check_refused("stabilised: none", "stabilised: lvlh", "10", "inertia_kg_m2 of a stabilised target");
  check_refused("rate_deg_s: [0, 2, 0]", "rate_deg_s: [0, 2000, 0]", "9", "from -360 to 360");
  check_refused("angles_deg: [1, 2, 3]", "quaternion_xyzw: [1, 1, 0, 0]", "8", "a quaternion of length 1.41");
  check_refused("angles_deg: [1, 2, 3]", "quaternion_xyzw: [1, 0, 0]", "8", "3 numbers");
  check_refused("angles_deg: [1, 2, 3]", "angles_deg: [1, 2, 3]\n    quaternion_xyzw: [0, 0, 0, 1]", "8",
                "one of them");
}

TEST(DynamicsMotionFile, ImpossibleStartsAreNamed) {
  check_refused("range_m: 50", "range_m: 0", "13", "motion.chaser.range_m is '0'");
  check_refused("range_m: 50", "position_m: [0, 0, 0]", "14", "direction with position_m");
  check_refused("range_m: 50\n    direction: -v-bar", "position_m: [0, 0, 0]", "13", "a range of zero");
  check_refused("    range_m: 50\n", "", "13", "where the camera starts is not said");
  check_refused("direction: -v-bar", "direction: w-bar", "14", "v-bar, -v-bar");
  check_refused("direction: -v-bar", "direction: [0, 0, 0]", "14", "direction has no length");
  check_refused("direction: -v-bar", "direction: r-bar", "13", "the line of sight runs along `down`");
  check_refused("direction: -v-bar", "angles_deg: [0, 120, 0]", "13", "behind the camera at the start");
  check_refused("direction: -v-bar", "rate_deg_s: [0, 1, 0]", "14", "without an orbit of the chaser's own");
  check_refused("direction: -v-bar", "jitter: {sigma_deg: -1, frequency_hz: 1}", "14", "a number from 0 to 10");
}

TEST(DynamicsMotionFile, ImpossibleLegsAreNamed) {
  check_refused("hold: {duration_s: 10}", "hold: {duration_s: -10}", "16", "hold.duration_s is '-10'");
  check_refused("hold: {duration_s: 10}", "hold: {}", "16", "missing key");
  check_refused("hold: {duration_s: 10}", "wait: {duration_s: 10}", "16", "unknown key 'motion.chaser.legs.wait'");
  check_refused("hold: {duration_s: 10}", "hold", "16", "holds no keys");
  check_refused("to_range_m: 20", "to_range_m: 0", "17", "a number from 0.001");
  check_refused("to_range_m: 20", "to_range_m: 20, to_m: [1, 2, 3]", "17", "one of to_range_m and to_m");
  check_refused("to_range_m: 20", "to_m: [30, 1, 0]", "17", "the leg leads past the target");
  check_refused("speed_m_s: 0.5", "speed_m_s: 0", "17", "straight.speed_m_s is '0'");
  check_refused("speed_m_s: 0.5", "speed_m_s: 0.5, duration_s: 5", "17", "one of speed_m_s and duration_s");
  check_refused("speed_m_s: 0.5", "speed_m_s: 0.5, pace: trapezoid", "17", "a trapezoid without speed or acceleration");
  check_refused("speed_m_s: 0.5", "speed_m_s: 0.5, acceleration_m_s2: 1", "17", "an acceleration without a trapezoid");
  check_refused("axis: r-bar", "axis: [0, 0, 0]", "18", "axis has no length");
  check_refused("axis: r-bar, angle_deg: 30", "axis: h-bar, angle_deg: 180", "18",
                "the line of sight runs along `down`");
  check_refused("- drift: {duration_s: 10}", "- close: {to_range_m: 1, duration_s: 10}\n      - drift: {duration_s: 1}",
                "20", "a leg that leaves the docking axis");
}

TEST(DynamicsMotionFile, WithoutAnOrbitNothingRefersToOne) {
  const auto refused = [](const std::string& target, const std::string& chaser, const std::string& what) {
    const std::string message = refusal("motion:\n  target: {" + target + "}\n  chaser: {" + chaser + "}\n");
    if (message.find(what) == std::string::npos) FAIL(message.c_str());
  };
  STRCMP_EQUAL("", refusal("motion:\n  chaser: {range_m: 3}\n").c_str());
  refused("relative_to: lvlh", "range_m: 3", "s.yaml:2: lvlh without an orbit");
  refused("stabilised: lvlh", "range_m: 3", "s.yaml:2: lvlh without an orbit");
  refused("rate_deg_s: [0, 0, 0]", "range_m: 3, direction: v-bar", "s.yaml:3: direction 'v-bar'");
  refused("rate_deg_s: [0, 0, 0]", "orbit: {}", "an orbit of the chaser alone");
  refused("stabilised: camera", "range_m: 3, legs: [close: {to_range_m: 1, duration_s: 3}]",
          "a camera that follows a target that follows the camera");
  refused("rate_deg_s: [0, 0, 0]", "range_m: 3, legs: 3", "s.yaml:3: motion.chaser.legs is no list");
  refused("angles_deg: [0, 150, 0]", "range_m: 3, legs: [close: {to_range_m: 2, duration_s: 30}]", "leads past");
  CHECK(refusal("motion: {}\n").find("missing key 'motion.chaser'") != std::string::npos);
}

TEST(DynamicsMotionFile, TimesAreNotNegativeAndDoNotGoBack) {
  // A target and legs that are functions of time alone would go back with no complaint of their own.
  const std::string yaml = "motion:\n  target: {stabilised: inertial}\n  chaser: {range_m: 3}\n";
  RelativeMotion course(read_motion(FileSection("s.yaml", YAML::Load(yaml)["motion"], "motion", motion_keys())), 1);
  CHECK(message_of([&] { static_cast<void>(course.at(Time{-1})); }) == "dynamics: time goes back");
  static_cast<void>(course.at(Time{5'000'000'000}));
  CHECK(message_of([&] { static_cast<void>(course.at(Time{4'999'999'999})); }) == "dynamics: time goes back");
}
