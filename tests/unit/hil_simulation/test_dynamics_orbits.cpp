#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "hil/dynamics/eclipse.hpp"
#include "hil/dynamics/free_flight.hpp"
#include "hil/dynamics/lvlh.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;

namespace {

OrbitElements elements(double semi_major_axis_m, double eccentricity) {
  return {0.4, -0.7, 0.9, eccentricity, semi_major_axis_m, 50.0};
}

double mean_motion(double semi_major_axis_m) { return std::sqrt(earth_mu_m3_s2 / std::pow(semi_major_axis_m, 3)); }

Time at_s(double seconds) { return Time{std::llround(seconds * 1e9)}; }

InertialState flown(Gravity gravity, const InertialState& start, double seconds) {
  return FreeFlight(gravity, start, Time{0}, 0.0, 0).at(at_s(seconds));
}

/// Largest distance between integrated and closed form over a period, m.
double largest_kepler_error_m(const OrbitElements& o) {
  FreeFlight flight(Gravity::point_mass, orbit_state(o, 0.0), Time{0}, 0.0, 0);
  const double period_s = 2.0 * pi / mean_motion(o.semi_major_axis_m);
  double largest = 0.0;
  for (double t = 0.0; t <= period_s; t += 7.3)
    largest = std::max(largest, (flight.at(at_s(t)).r_I - orbit_state(o, std::round(t * 1e9) * 1e-9).r_I).norm());
  return largest;
}

/// Error after half an orbit of e = 0.5 in steps of `h`, m.
double step_error_m(double h) {
  const OrbitElements o = elements(1.6e7, 0.5);
  const FreeFlightModel model;
  const InertialState start = orbit_state(o, 0.0);
  Vec6 x = (Vec6() << start.r_I, start.v_I).finished();
  const int steps = static_cast<int>(std::lround(9600.0 / h));
  for (int i = 0; i < steps; ++i)
    x = runge_kutta_7(x, h, [&](const Vec6& at) { return model.rates(at, Vec3::Zero()); });
  return (x.head<3>() - orbit_state(o, 9600.0).r_I).norm();
}

double energy(const InertialState& s) {  // J2's potential: Vallado, section 8.6.1
  const double r = s.r_I.norm();
  const double sine = s.r_I.z() / r;
  return 0.5 * s.v_I.squaredNorm() - earth_mu_m3_s2 / r +
         0.5 * earth_mu_m3_s2 * earth_j2 * std::pow(earth_radius_m / r, 2) / r * (3.0 * sine * sine - 1.0);
}

double node_rad(const InertialState& s) {
  const Vec3 h_I = s.r_I.cross(s.v_I);
  return std::atan2(h_I.x(), -h_I.y());
}

/// Distance between Clohessy-Wiltshire and both orbits, after `seconds`, from `start`.
double linear_error_m(const LocalState& start, double seconds) {
  const OrbitElements o = elements(6.778e6, 0.0);
  const InertialState target = orbit_state(o, 0.0);
  const InertialState chaser = inertial_state(start, target, local_frame(target, Gravity::point_mass));
  const InertialState then = orbit_state(o, seconds);
  const LocalState truth =
      local_state(flown(Gravity::point_mass, chaser, seconds), then, local_frame(then, Gravity::point_mass));
  return (clohessy_wiltshire(start, mean_motion(o.semi_major_axis_m), seconds).p_L - truth.p_L).norm();
}

/// Share of the sun's disc from which no ray to `r_I` meets the Earth, by counting.
double counted_sunlight(const Vec3& r_I, const Vec3& sun_I) {
  const Vec3 to_sun = (sun_distance_m * sun_I - r_I).normalized();
  const Vec3 u = to_sun.unitOrthogonal();
  const Vec3 v = to_sun.cross(u);
  const double radius = std::tan(std::asin(sun_radius_m / (sun_distance_m * sun_I - r_I).norm()));
  int all = 0;
  int free = 0;
  constexpr int n = 200;
  for (int i = -n; i <= n; ++i) {
    for (int k = -n; k <= n; ++k) {
      if (i * i + k * k > n * n) continue;
      const Vec3 ray = (to_sun + radius / n * (i * u + k * v)).normalized();
      const double along = -r_I.dot(ray);
      const bool hit = along > 0.0 && (r_I + along * ray).norm() < earth_radius_m;
      ++all;
      free += hit ? 0 : 1;
    }
  }
  return static_cast<double>(free) / all;
}

}  // namespace

TEST_GROUP(DynamicsOrbits){};

TEST(DynamicsOrbits, IntegratedIsKeplersClosedForm) {
  CHECK(largest_kepler_error_m(elements(6.778e6, 0.0)) < 2e-6);
  CHECK(largest_kepler_error_m(elements(2.6e7, 0.7)) < 5e-5);
}

TEST(DynamicsOrbits, VelocityOfTheClosedFormIsItsRate) {
  const OrbitElements o = elements(2.6e7, 0.7);
  for (const double t : {0.0, 900.0, 20000.0}) {
    const Vec3 v = ((orbit_state(o, t + 1.0).r_I - orbit_state(o, t - 1.0).r_I) * 8.0 -
                    (orbit_state(o, t + 2.0).r_I - orbit_state(o, t - 2.0).r_I)) /
                   12.0;
    DOUBLES_EQUAL(0.0, (v - orbit_state(o, t).v_I).norm(), 1e-6);
  }
}

TEST(DynamicsOrbits, TheIntegratorIsOfOrderSeven) {
  const double ratio = step_error_m(160.0) / step_error_m(80.0);
  CHECK(ratio > 90.0 && ratio < 200.0);  // 2^7 = 128 in the limit; order 6 would give 64
}

TEST(DynamicsOrbits, OblatenessTurnsTheNodeAtTheSecularRate) {
  // Kaula, Theory of Satellite Geodesy, 1966, eq. 3.74; the mean axis differs from the osculating one by the order of J2.
  const OrbitElements o = elements(7.0e6, 0.001);
  const InertialState start = orbit_state(o, 0.0);
  const double p = o.semi_major_axis_m * (1.0 - o.eccentricity * o.eccentricity);
  const double rate = -1.5 * earth_j2 * mean_motion(o.semi_major_axis_m) * std::pow(earth_radius_m / p, 2) *
                      std::cos(o.inclination_rad);
  const double orbits_s = 30.0 * 2.0 * pi / mean_motion(o.semi_major_axis_m);
  const double turned = node_rad(flown(Gravity::oblate, start, orbits_s)) - node_rad(start);
  DOUBLES_EQUAL(1.0, turned / (rate * orbits_s), 0.0015);
  DOUBLES_EQUAL(0.0, node_rad(flown(Gravity::point_mass, start, orbits_s)) - node_rad(start), 1e-11);
}

TEST(DynamicsOrbits, OblatenessKeepsEnergyAndMomentumAboutTheAxis) {
  const InertialState start = orbit_state(elements(9e6, 0.2), 0.0);
  const InertialState end = flown(Gravity::oblate, start, 86400.0);
  DOUBLES_EQUAL(1.0, energy(end) / energy(start), 1e-12);
  DOUBLES_EQUAL(1.0, end.r_I.cross(end.v_I).z() / start.r_I.cross(start.v_I).z(), 1e-12);
  CHECK(std::abs(end.r_I.cross(end.v_I).x() / start.r_I.cross(start.v_I).x() - 1.0) > 1e-3);
}

TEST(DynamicsOrbits, TheLocalFrameTurnsAsItsAxesDo) {
  for (const Gravity gravity : {Gravity::point_mass, Gravity::oblate}) {
    const InertialState start = orbit_state(elements(7.5e6, 0.1), 0.0);
    for (const double t : {100.0, 1500.0, 4000.0}) {
      const double h = 0.5;
      const auto R = [&](double dt) { return local_frame(flown(gravity, start, t + dt), gravity).R_AB; };
      const Mat3 slope = (R(-2 * h) - R(2 * h) + 8.0 * (R(h) - R(-h))) / (12.0 * h);
      const Mat3 W = slope * R(0.0).transpose();
      const Vec3 omega_I = local_frame(flown(gravity, start, t), gravity).omega_AB_A;
      DOUBLES_EQUAL(0.0, (Vec3(W(2, 1), W(0, 2), W(1, 0)) - omega_I).norm(), 1e-13);
    }
  }
}

TEST(DynamicsOrbits, RelativeStatesComeBack) {
  const InertialState target = orbit_state(elements(7e6, 0.05), 300.0);
  const Turning il = local_frame(target, Gravity::oblate);
  const LocalState there{Vec3(-100.0, 5.0, 30.0), Vec3(0.1, -0.2, 0.3)};
  const LocalState back = local_state(inertial_state(there, target, il), target, il);
  DOUBLES_EQUAL(0.0, (back.p_L - there.p_L).norm(), 5e-9);
  DOUBLES_EQUAL(0.0, (back.v_L - there.v_L).norm(), 1e-11);
}

TEST(DynamicsOrbits, ClohessyWiltshireErrsWithTheSquareOfTheRange) {
  const double half_orbit_s = pi / mean_motion(6.778e6);
  const LocalState start{Vec3(-100.0, 20.0, 30.0), Vec3(0.02, 0.01, -0.03)};
  const LocalState twice{2.0 * start.p_L, 2.0 * start.v_L};
  const double error_m = linear_error_m(start, half_orbit_s);
  CHECK(error_m < 0.02);
  DOUBLES_EQUAL(4.0, linear_error_m(twice, half_orbit_s) / error_m, 0.01);
}

TEST(DynamicsOrbits, ClohessyWiltshireVelocityIsItsRate) {
  const LocalState start{Vec3(-100.0, 20.0, 30.0), Vec3(0.02, 0.01, -0.03)};
  const double n = mean_motion(6.778e6);
  const Vec3 slope = (clohessy_wiltshire(start, n, 701.0).p_L - clohessy_wiltshire(start, n, 699.0).p_L) / 2.0;
  DOUBLES_EQUAL(0.0, (slope - clohessy_wiltshire(start, n, 700.0).v_L).norm(), 1e-6);
}

TEST_GROUP(DynamicsEclipse){};

TEST(DynamicsEclipse, IsThatOfRaysFromTheSunsDisc) {
  const Vec3 sun_I = Vec3(1.0, 0.2, -0.1).normalized();
  const Vec3 side_I = sun_I.unitOrthogonal();
  const double behind_m = 2.5e6;
  for (double off_m = 6.33e6; off_m < 6.41e6; off_m += 5e3) {
    const Vec3 r_I = -behind_m * sun_I + off_m * side_I;
    DOUBLES_EQUAL(counted_sunlight(r_I, sun_I), sunlight_at(r_I, sun_I), 2e-3);  // flat discs there
  }
}

TEST(DynamicsEclipse, EntryOfALowOrbitIsThatOfTheCylinderWithinThePenumbra) {
  // Orbit in the plane of the sun: it meets the cylinder of the Earth's radius at asin(R / r) before the middle.
  const double r = 6.778e6;
  const double n = mean_motion(r);
  const OrbitElements o{0.0, 0.0, 0.0, 0.0, r, 0.0};
  const Vec3 sun_I = Vec3::UnitX();
  const double cylinder_s = (pi - std::asin(earth_radius_m / r)) / n;
  double last_full_s = 0.0;
  double first_dark_s = 0.0;
  double half_s = 0.0;
  for (double t = 1500.0; t < 2500.0 && first_dark_s == 0.0; t += 0.05) {
    const double sunlight = sunlight_at(orbit_state(o, t).r_I, sun_I);
    if (sunlight == 1.0) last_full_s = t;
    if (sunlight > 0.5) half_s = t;
    if (sunlight == 0.0) first_dark_s = t;
  }
  DOUBLES_EQUAL(cylinder_s, half_s, 0.2);
  // The sun's angle, crossed at n sin of the angle between the Earth's limb and the orbit.
  const double width_s = 2.0 * std::asin(sun_radius_m / sun_distance_m) / n;
  DOUBLES_EQUAL(width_s, first_dark_s - last_full_s, 0.3);
  DOUBLES_EQUAL(0.0, sunlight_at(Vec3(-r, 0.0, 0.0), sun_I), 0.0);
  DOUBLES_EQUAL(1.0, sunlight_at(Vec3(r, 0.0, 0.0), sun_I), 0.0);
}

TEST(DynamicsEclipse, BeyondTheUmbraARingIsLeft) {
  const double r_m = 3e9;
  const double sun = std::asin(sun_radius_m / (sun_distance_m + r_m));
  const double earth = std::asin(earth_radius_m / r_m);
  DOUBLES_EQUAL(1.0 - earth * earth / (sun * sun), sunlight_at(Vec3(-r_m, 0.0, 0.0), Vec3::UnitX()), 1e-12);
}
