#include "hil/dynamics/motion_file.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "hil/dynamics/relative_motion.hpp"

namespace relnav::hil {
namespace motion_file {
namespace {

constexpr double most_m = 1e6;
constexpr double most_s = 1e6;
constexpr Words<bool, 2> relative_words{{{"camera", true}, {"lvlh", false}}};
constexpr Words<bool, 2> pointing_words{{{"target", true}, {"fixed", false}}};
constexpr Words<bool, 2> own_pointing_words{{{"target", false}, {"lvlh", true}}};
constexpr Words<Stabilised, 4> stabilised_words{{{"none", Stabilised::none},
                                                 {"inertial", Stabilised::inertial},
                                                 {"lvlh", Stabilised::lvlh},
                                                 {"camera", Stabilised::camera}}};
constexpr Words<PaceKind, 3> pace_words{
    {{"smooth", PaceKind::smooth}, {"constant", PaceKind::constant}, {"trapezoid", PaceKind::trapezoid}}};

const char* const direction_expectation =
    "v-bar, -v-bar, h-bar, -h-bar, r-bar, -r-bar (with an orbit) or a list of three numbers that are not all zero";

double number(const FileSection& section, const char* key, double low, double high) {
  static_cast<void>(section.require(key, format_text("a number from %g to %g", low, high)));
  return section.number_or(key, low, high, low);
}

/// Unit vector from a word or a list.
Vec3 direction(const FileSection& section, const char* key, bool orbit) {
  const YAML::Node node = section.require(key, direction_expectation);
  if (node.IsScalar()) {
    const bool minus = node.Scalar().rfind("-", 0) == 0;
    const std::string name = node.Scalar().substr(minus ? 1 : 0);
    const double sign = minus ? -1.0 : 1.0;
    if (orbit && name == "v-bar") return sign * Vec3::UnitX();
    if (orbit && name == "h-bar") return sign * Vec3::UnitY();
    if (orbit && name == "r-bar") return sign * Vec3::UnitZ();
    section.fail(node, "direction " + in_quotes(node.Scalar()), direction_expectation);
  }
  const Vec3 v = section.three(key, 1e12);
  if (v.norm() < 1e-9) section.fail(node, std::string(key) + " has no length", direction_expectation);
  return v.normalized();
}

const std::vector<std::string> orbit_keys{"semi_major_axis_m",       "eccentricity",  "inclination_deg", "raan_deg",
                                          "argument_of_perigee_deg", "perigee_time_s"};

OrbitElements read_orbit(const FileSection& section) {
  OrbitElements o;
  o.semi_major_axis_m = section.number_or("semi_major_axis_m", 0.0, 1e9, 6.778e6);
  o.eccentricity = section.number_or("eccentricity", 0.0, 0.9, 0.0);
  o.inclination_rad = section.number_or("inclination_deg", 0.0, 180.0, 0.0) / degrees_per_radian;
  o.raan_rad = section.number_or("raan_deg", -360.0, 360.0, 0.0) / degrees_per_radian;
  o.argument_of_perigee_rad = section.number_or("argument_of_perigee_deg", -360.0, 360.0, 0.0) / degrees_per_radian;
  o.perigee_time_s = section.number_or("perigee_time_s", -1e9, 1e9, 0.0);
  const double perigee_m = o.semi_major_axis_m * (1.0 - o.eccentricity);
  if (perigee_m < earth_radius_m) {
    section.fail(section.has("semi_major_axis_m") ? section.node("semi_major_axis_m") : section.map(),
                 format_text("an orbit with its perigee %.0f m from the Earth's centre", perigee_m),
                 format_text("at least %.0f m, the Earth's radius", earth_radius_m));
  }
  return o;
}

void read_sun(const FileSection& section, MotionSettings& motion) {
  if (static_cast<int>(section.has("sun")) + static_cast<int>(section.has("sun_I")) +
          static_cast<int>(section.has("sun_C")) >
      1) {
    section.fail(section.map(), "more than one direction of the sun", "one of sun, sun_I and sun_C");
  }
  if (section.has("sun_C")) motion.sun_C = direction(section, "sun_C", false);
  if (section.has("sun_I")) motion.sun_I = direction(section, "sun_I", false);
  if (!section.has("sun")) return;
  const FileSection sun = section.section("sun", {"right_ascension_deg", "declination_deg"});
  const double ra = number(sun, "right_ascension_deg", -360.0, 360.0) / degrees_per_radian;
  const double dec = number(sun, "declination_deg", -90.0, 90.0) / degrees_per_radian;
  motion.sun_I = Vec3(std::cos(dec) * std::cos(ra), std::cos(dec) * std::sin(ra), std::sin(dec));
}

Mat3 read_rotation(const FileSection& section) {
  if (!section.has("quaternion_xyzw")) return rotation_of_angles(section.three_or("angles_deg", 360.0, Vec3::Zero()));
  const std::string expectation = "four numbers of a unit quaternion, x y z w";
  if (section.has("angles_deg"))
    section.fail(section.node("angles_deg"), "angles_deg and quaternion_xyzw", "one of them");
  const std::vector<double> q = section.numbers("quaternion_xyzw", expectation);
  if (q.size() != 4) section.fail(section.node("quaternion_xyzw"), std::to_string(q.size()) + " numbers", expectation);
  const Eigen::Quaterniond unit(q[3], q[0], q[1], q[2]);
  if (std::abs(unit.norm() - 1.0) > 1e-3)
    section.fail(section.node("quaternion_xyzw"), format_text("a quaternion of length %g", unit.norm()), expectation);
  return unit.normalized().toRotationMatrix();
}

/// A body exists for an inertia when no principal moment exceeds the sum of the others.
Mat3 read_inertia(const FileSection& section) {
  const char* const key = "inertia_kg_m2";
  const std::string expectation =
      "3 principal moments, 6 (xx yy zz xy xz yz) or 9 numbers of a symmetric matrix, of a body: moments positive, "
      "none "
      "larger than the sum of the other two";
  const std::vector<double> v = section.numbers(key, expectation);
  Mat3 J;
  if (v.size() == 3) {
    J = Vec3(v[0], v[1], v[2]).asDiagonal();
  } else if (v.size() == 6) {
    J << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  } else if (v.size() == 9) {
    J << v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8];
  } else {
    section.fail(section.node(key), std::to_string(v.size()) + " numbers of inertia", expectation);
  }
  if ((J - J.transpose()).norm() > 1e-9 * J.norm()) section.fail(section.node(key), "not symmetric", expectation);
  const Vec3 moments = Eigen::SelfAdjointEigenSolver<Mat3>(J).eigenvalues();
  if (!(moments(0) > 1e-9 * moments(2)) || moments(0) + moments(1) < (1.0 - 1e-9) * moments(2)) {
    section.fail(section.node(key),
                 format_text("principal moments %g, %g, %g kg m^2", moments(0), moments(1), moments(2)), expectation);
  }
  return J;
}

TargetSettings read_target(const FileSection& section, bool orbit) {
  TargetSettings target;
  target.relative_to_camera = section.word_or("relative_to", relative_words, true);
  target.stabilised = section.word_or("stabilised", stabilised_words, Stabilised::none);
  if (!orbit && !target.relative_to_camera)
    section.fail(section.node("relative_to"), "lvlh without an orbit", "camera, or the section motion.orbit");
  if (!orbit && target.stabilised == Stabilised::lvlh)
    section.fail(section.node("stabilised"), "lvlh without an orbit", "none, inertial, camera, or motion.orbit");
  target.R_0T = read_rotation(section);
  if (!target.relative_to_camera) target.R_0T = target.R_0T * forward_in_lvlh();
  target.omega_T = section.three_or("rate_deg_s", 360.0, Vec3::Zero()) / degrees_per_radian;
  for (const char* key : {"inertia_kg_m2", "torque_noise_Nm_s05"}) {
    if (section.has(key) && target.stabilised != Stabilised::none)
      section.fail(section.node(key), std::string(key) + " of a stabilised target", "it with stabilised: none only");
  }
  if (section.has("inertia_kg_m2")) target.inertia_T = read_inertia(section);
  target.torque_density = section.number_or("torque_noise_Nm_s05", 0.0, 1e6, 0.0);
  return target;
}

/// `unit`: of the way, as it stands in the names of the keys.
LegPace read_pace(const FileSection& leg, const std::string& unit) {
  const std::string speed_key = unit == "m" ? "speed_m_s" : "rate_deg_s";
  const std::string acceleration_key = unit == "m" ? "acceleration_m_s2" : "acceleration_deg_s2";
  const double scale = unit == "m" ? 1.0 : 1.0 / degrees_per_radian;
  LegPace pace;
  pace.kind = leg.word_or("pace", pace_words, PaceKind::smooth);
  const bool has_speed = leg.has(speed_key.c_str());
  if (has_speed == leg.has("duration_s"))
    leg.fail(leg.map(), has_speed ? speed_key + " and duration_s" : "no pace",
             "one of " + speed_key + " and duration_s");
  const bool trapezoid = pace.kind == PaceKind::trapezoid;
  if (leg.has(acceleration_key.c_str()) != trapezoid || (trapezoid && !has_speed))
    leg.fail(leg.map(), trapezoid ? "a trapezoid without speed or acceleration" : "an acceleration without a trapezoid",
             "pace: trapezoid with " + speed_key + " and " + acceleration_key);
  if (has_speed) pace.speed = scale * number(leg, speed_key.c_str(), 1e-6, 1e4);
  if (!has_speed) pace.duration_s = number(leg, "duration_s", 1e-3, most_s);
  if (trapezoid) pace.acceleration = scale * number(leg, acceleration_key.c_str(), 1e-9, 1e4);
  return pace;
}

StraightLeg read_straight(const FileSection& leg) {
  StraightLeg straight;
  if (leg.has("to_range_m") == leg.has("to_m"))
    leg.fail(leg.map(), "where the line ends is not said, or said twice", "one of to_range_m and to_m");
  if (leg.has("to_m")) straight.to_L = leg.three("to_m", most_m);
  if (leg.has("to_range_m")) straight.to_range_m = number(leg, "to_range_m", 1e-3, most_m);
  straight.pace = read_pace(leg, "m");
  return straight;
}

FlyAroundLeg read_fly_around(const FileSection& leg, bool orbit) {
  FlyAroundLeg circle;
  circle.axis_L = direction(leg, "axis", orbit);
  circle.angle_rad = number(leg, "angle_deg", -36000.0, 36000.0) / degrees_per_radian;
  circle.pace = read_pace(leg, "deg");
  return circle;
}

CloseLeg read_close(const FileSection& leg) {
  CloseLeg close;
  close.to_range_m = number(leg, "to_range_m", 1e-3, most_m);
  close.pace.kind = leg.word_or("pace", pace_words, PaceKind::smooth);
  if (close.pace.kind == PaceKind::trapezoid)
    leg.fail(leg.node("pace"), "a trapezoid with an alignment", "smooth or constant");
  close.pace.duration_s = number(leg, "duration_s", 1e-3, most_s);
  return close;
}

DriftLeg read_drift(const FileSection& leg) {
  DriftLeg drift;
  drift.duration_s = number(leg, "duration_s", 1e-3, most_s);
  if (leg.has("velocity_m_s")) drift.velocity_L = leg.three("velocity_m_s", 1e3);
  drift.acceleration_density = leg.number_or("acceleration_noise_m_s15", 0.0, 1e3, 0.0);
  return drift;
}

/// A leg is a map with one key, its kind.
Leg read_leg(const FileSection& outer, bool orbit) {
  if (outer.map().size() != 1) outer.fail(outer.map(), "a leg with several kinds", "one of them");
  if (outer.has("hold")) return HoldLeg{number(outer.section("hold", {"duration_s"}), "duration_s", 1e-3, most_s)};
  if (outer.has("straight")) {
    return read_straight(
        outer.section("straight", {"to_range_m", "to_m", "duration_s", "speed_m_s", "acceleration_m_s2", "pace"}));
  }
  if (outer.has("fly_around")) {
    return read_fly_around(
        outer.section("fly_around", {"axis", "angle_deg", "duration_s", "rate_deg_s", "acceleration_deg_s2", "pace"}),
        orbit);
  }
  if (outer.has("close")) return read_close(outer.section("close", {"to_range_m", "duration_s", "pace"}));
  return read_drift(outer.section("drift", {"duration_s", "velocity_m_s", "acceleration_noise_m_s15"}));
}

void read_legs(const FileSection& section, bool orbit, bool target_follows_camera, std::vector<Leg>& legs) {
  const YAML::Node list = section.node("legs");
  if (!list.IsSequence())
    section.fail(list, "motion.chaser.legs is no list", "a list of legs, such as - hold: {duration_s: 10}");
  bool docked = false;
  for (const auto& item : list) {
    const FileSection outer = section.section(item, "legs", {"hold", "straight", "fly_around", "close", "drift"});
    const Leg leg = read_leg(outer, orbit);
    const bool close = std::holds_alternative<CloseLeg>(leg);
    if (close && target_follows_camera)
      outer.fail(item, "a camera that follows a target that follows the camera",
                 "another target.stabilised with close");
    if (docked && !close && !std::holds_alternative<HoldLeg>(leg))
      outer.fail(item, "a leg that leaves the docking axis", "hold or close after close");
    docked = docked || close;
    legs.push_back(leg);
  }
}

void read_start(const FileSection& section, bool orbit, ChaserSettings& chaser) {
  if (section.has("position_m") == section.has("range_m"))
    section.fail(section.map(), "where the camera starts is not said, or said twice", "one of range_m and position_m");
  if (section.has("position_m")) {
    if (section.has("direction"))
      section.fail(section.node("direction"), "direction with position_m", "it with range_m only");
    chaser.start_L = section.three("position_m", most_m);
    if (chaser.start_L.norm() < 1e-3)
      section.fail(section.node("position_m"), "a range of zero", "a range of at least 0.001 m");
    return;
  }
  const Vec3 towards = orbit ? -Vec3::UnitX() : -Vec3::UnitZ();
  chaser.start_L = number(section, "range_m", 1e-3, most_m) *
                   (section.has("direction") ? direction(section, "direction", orbit) : towards);
}

void read_own_orbit(const FileSection& section, ChaserSettings& chaser) {
  for (const char* key : {"range_m", "direction", "position_m", "legs"}) {
    if (section.has(key))
      section.fail(section.node(key), std::string(key) + " with an orbit of the chaser's own", "one of them");
  }
  chaser.orbit = read_orbit(section.section("orbit", orbit_keys));
  chaser.own_frame = section.word_or("pointing", own_pointing_words, false);
  if (section.has("rate_deg_s") && !chaser.own_frame)
    section.fail(section.node("rate_deg_s"), "rate_deg_s of a camera that is aimed", "it with pointing: lvlh only");
  const Mat3 R = read_rotation(section);
  (chaser.own_frame ? chaser.R_LC : chaser.R_PC) = chaser.own_frame ? Mat3(R * forward_in_lvlh()) : R;
  chaser.omega_LC_C = section.three_or("rate_deg_s", 360.0, Vec3::Zero()) / degrees_per_radian;
}

ChaserSettings read_chaser(const FileSection& section, bool orbit, const TargetSettings& target) {
  ChaserSettings chaser;
  chaser.down_L = orbit ? Vec3::UnitZ() : Vec3::UnitY();
  if (section.has("down")) chaser.down_L = direction(section, "down", orbit);
  if (section.has("jitter")) {
    const FileSection jitter = section.section("jitter", {"sigma_deg", "frequency_hz"});
    chaser.jitter.sigma_rad = number(jitter, "sigma_deg", 0.0, 10.0) / degrees_per_radian;
    chaser.jitter.frequency_hz = number(jitter, "frequency_hz", 1e-6, 1e3);
  }
  if (section.has("orbit")) {
    if (!orbit) section.fail(section.node("orbit"), "an orbit of the chaser alone", "motion.orbit as well");
    read_own_orbit(section, chaser);
    return chaser;
  }
  if (section.has("rate_deg_s"))
    section.fail(section.node("rate_deg_s"), "rate_deg_s without an orbit of the chaser's own", "legs instead");
  chaser.follows_target = section.word_or("pointing", pointing_words, true);
  chaser.R_PC = read_rotation(section);
  read_start(section, orbit, chaser);
  if (section.has("legs")) read_legs(section, orbit, target.stabilised == Stabilised::camera, chaser.legs);
  return chaser;
}

/// A leg that takes the camera nearer to the target than both of its ends are leads through it, or past it.
void check_leg(RelativeMotion& course, const Leg& leg, Time begin, Time end) {
  constexpr std::int64_t samples = 64;
  const double start_m = course.at(begin).t_CT.norm();
  double least_m = start_m;
  double last_m = start_m;
  for (std::int64_t i = 1; i < samples; ++i) {
    last_m = course.at(Time{begin.ns + (end.ns - begin.ns) / samples * i}).t_CT.norm();
    least_m = std::min(least_m, last_m);
  }
  const bool free = std::holds_alternative<DriftLeg>(leg);
  if (least_m < 1e-3 || (!free && least_m < 0.9 * std::min(start_m, last_m)))
    throw std::domain_error(format_text("the leg leads past the target at %.3f m", least_m));
}

/// Flies it once: what only the course shows.
void check_course(const FileSection& chaser, const MotionSettings& motion) {
  std::size_t leg = 0;
  bool started = false;
  try {
    RelativeMotion course(motion, 1);
    const SceneState start = course.at(Time{0});
    if (start.t_CT.z() <= 0.0)
      chaser.fail(chaser.map(), format_text("the target is %.3f m behind the camera at the start", -start.t_CT.z()),
                  "a target ahead of it: z_C forward");
    started = true;
    Time begin;
    for (; !motion.chaser.orbit && leg < motion.chaser.legs.size(); ++leg) {
      const Time end = course.profile().leg_end();
      check_leg(course, motion.chaser.legs[leg], begin, end);
      begin = end;
      if (leg + 1 < motion.chaser.legs.size()) static_cast<void>(course.at(end));
    }
  } catch (const std::domain_error& error) {
    const YAML::Node legs = chaser.node("legs");
    chaser.fail(started && legs && legs.size() > leg ? legs[leg] : chaser.map(), error.what(),
                "a way around it, or another `down` (such as h-bar for ways in the plane of the orbit)");
  }
}

}  // namespace
}  // namespace motion_file

std::vector<std::string> motion_keys() { return {"orbit", "sun", "sun_I", "sun_C", "target", "chaser"}; }

MotionSettings read_motion(const FileSection& section) {
  using namespace motion_file;
  MotionSettings motion;
  if (section.has("orbit")) {
    std::vector<std::string> keys = orbit_keys;
    keys.emplace_back("j2");
    const FileSection orbit = section.section("orbit", keys);
    motion.orbit = read_orbit(orbit);
    motion.j2 = orbit.yes_no_or("j2", false);
  }
  read_sun(section, motion);
  if (section.has("target")) {
    motion.target = read_target(section.section("target", {"relative_to", "angles_deg", "quaternion_xyzw", "rate_deg_s",
                                                           "stabilised", "inertia_kg_m2", "torque_noise_Nm_s05"}),
                                motion.orbit.has_value());
  }
  static_cast<void>(section.require("chaser", "a section that says where the camera is"));
  const FileSection chaser =
      section.section("chaser", {"range_m", "direction", "position_m", "down", "pointing", "angles_deg",
                                 "quaternion_xyzw", "rate_deg_s", "jitter", "legs", "orbit"});
  motion.chaser = read_chaser(chaser, motion.orbit.has_value(), motion.target);
  check_course(chaser, motion);
  return motion;
}

}  // namespace relnav::hil
