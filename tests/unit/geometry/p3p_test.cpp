#include "fsw/geometry/p3p.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/attitude/so3.hpp"
#include "fsw/base/generator.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

Vec3 in_cube(Generator& g) {
  const double x = g.uniform() - 0.5;
  const double y = g.uniform() - 0.5;
  const double z = g.uniform() - 0.5;
  return 2.0 * Vec3(x, y, z);
}

/// Rays of the points, in the given pose.
std::array<Vec3, 3> rays_of(const std::array<Vec3, 3>& p_T, const Pose& pose) {
  std::array<Vec3, 3> rays;
  for (std::size_t i = 0; i < 3; ++i) rays[i] = (pose.R_CT * p_T[i] + pose.t_CT).normalized();
  return rays;
}

/// Distance of the nearest solution from the pose; negative: none.
double nearest(const std::array<Vec3, 3>& p_T, const Pose& pose, double& worst_ray) {
  P3pPoints points;
  if (make_p3p_points(p_T, points) != Status::ok) return -1.0;
  const std::array<Vec3, 3> rays = rays_of(p_T, pose);
  std::array<Pose, 4> found;
  const int count = solve_p3p(points, rays, found);
  double best = -1.0;
  worst_ray = 0.0;
  for (int k = 0; k < count; ++k) {
    const Pose& f = found[static_cast<std::size_t>(k)];
    const double d = (f.R_CT - pose.R_CT).norm() + (f.t_CT - pose.t_CT).norm() / pose.t_CT.norm();
    if (best < 0.0 || d < best) best = d;
    const std::array<Vec3, 3> again = rays_of(p_T, f);
    for (std::size_t i = 0; i < 3; ++i) worst_ray = std::max(worst_ray, (again[i] - rays[i]).norm());
  }
  return best;
}

/// A point or direction on a small grid: many of them coincide, are parallel or at right angles.
Vec3 on_grid(Generator& g) {
  Vec3 v;
  for (int k = 0; k < 3; ++k) v(k) = static_cast<double>(g.below(5)) - 2.0;
  return v;
}

/// That whatever is found is a pose under which the points are seen along the directions. Returns how many there are.
int check_what_is_found(const std::array<Vec3, 3>& p_T, const std::array<Vec3, 3>& directions) {
  P3pPoints points;
  if (make_p3p_points(p_T, points) != Status::ok) return 0;
  std::array<Vec3, 3> rays;
  for (std::size_t i = 0; i < 3; ++i) rays[i] = directions[i].normalized();
  std::array<Pose, 4> found;
  const int count = solve_p3p(points, rays, found);
  for (int k = 0; k < count; ++k) {
    const Pose& f = found[static_cast<std::size_t>(k)];
    CHECK((f.R_CT * f.R_CT.transpose() - Mat3::Identity()).norm() < 1e-6);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p_C = f.R_CT * p_T[i] + f.t_CT;
      const double along = p_C.dot(rays[i]);
      CHECK(along > -1e-6);
      CHECK((p_C - along * rays[i]).norm() < 1e-6);
    }
  }
  return count;
}

}  // namespace

TEST_GROUP(P3p){};

TEST(P3p, finds_the_pose_among_its_solutions) {
  Generator g(11);
  int missed = 0, bad = 0;
  const int runs = 20000;
  for (int k = 0; k < runs; ++k) {
    const std::array<Vec3, 3> p_T{in_cube(g), in_cube(g), in_cube(g)};
    const double range = 2.5 + 20.0 * g.uniform();
    const Mat3 R_CT = exp_so3(3.0 * in_cube(g));
    const double y = 0.5 * (g.uniform() - 0.5);
    const double x = 0.5 * (g.uniform() - 0.5);
    const Pose pose{R_CT, range * Vec3(x, y, 1.0)};
    double worst_ray = 0.0;
    const double d = nearest(p_T, pose, worst_ray);
    if (d < 0.0 || d > 1e-4) ++missed;
    if (worst_ray > 1e-6) ++bad;
  }
  // Exceptions: double solutions, where the problem itself is ill-conditioned.
  CHECK_TRUE_TEXT(missed <= runs / 1000, StringFromFormat("missed %d", missed).asCharString());
  CHECK_TRUE_TEXT(bad <= runs / 1000, StringFromFormat("bad %d", bad).asCharString());
}

TEST(P3p, solves_symmetric_triangles) {
  // Isosceles and equilateral, seen head on and tilted: coefficients of the cubic vanish.
  const double h = std::sqrt(0.75);
  const std::array<std::array<Vec3, 3>, 3> triangles{
      {{Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0)},
       {Vec3(-0.5, 0.0, 0.0), Vec3(0.5, 0.0, 0.0), Vec3(0.0, h, 0.0)},
       {Vec3(-0.35, -0.35, -0.9), Vec3(0.35, -0.35, -0.9), Vec3(0.35, 0.35, -0.9)}}};
  for (const auto& p_T : triangles) {
    for (const Vec3& phi : {Vec3(0.3, 0.1, 0.0), Vec3(0.0, 0.4, 1.0), Vec3(-0.2, 0.3, 2.0)}) {
      double worst_ray = 0.0;
      const double d = nearest(p_T, {exp_so3(phi), Vec3(0.4, -0.1, 6.0)}, worst_ray);
      CHECK(d >= 0.0 && d < 1e-5);
      CHECK(worst_ray < 1e-7);
    }
  }
}

TEST(P3p, refuses_collinear_points) {
  P3pPoints points;
  CHECK(make_p3p_points({Vec3(0.0, 0.0, 0.0), Vec3(1.0, 1.0, 0.0), Vec3(3.0, 3.0, 1e-4)}, points) ==
        Status::rank_deficient);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK(make_p3p_points({Vec3(0.0, 0.0, 0.0), Vec3(1.0, bad, 0.0), Vec3(3.0, 3.0, 1.0)}, points) ==
          Status::not_finite);
  }
  CHECK(make_p3p_points({Vec3(0.0, 0.0, 0.0), Vec3(1.0, 1.0, 0.0), Vec3(3.0, 3.0, 1.0)}, points) == Status::ok);
}

TEST(P3p, impossible_angles_have_no_solution_or_one_that_fits) {
  // A needle of a triangle cannot be seen as three rays at right angles from its far side.
  P3pPoints points;
  CHECK(make_p3p_points({Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), Vec3(0.5, 0.01, 0.0)}, points) == Status::ok);
  std::array<Pose, 4> found;
  const std::array<Vec3, 3> rays{Vec3(0.0, 0.0, 1.0), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0)};
  LONGS_EQUAL(0, solve_p3p(points, rays, found));
}

TEST(P3p, whatever_is_found_for_any_rays_is_a_solution) {
  Generator g(17);
  int found = 0;
  for (int k = 0; k < 40000; ++k) {
    const auto draw = [&](bool grid) { return grid ? on_grid(g) : in_cube(g); };
    const bool points = k % 2 == 0;
    const bool rays = k % 3 == 0;
    const std::array<Vec3, 3> p_T{draw(points), draw(points), draw(points)};
    const std::array<Vec3, 3> directions{draw(rays), draw(rays), draw(rays)};
    if (std::all_of(directions.begin(), directions.end(), [](const Vec3& d) { return d.norm() > 0.1; })) {
      found += check_what_is_found(p_T, directions);
    }
  }
  CHECK(found > 2000);
}

TEST(P3p, where_a_division_would_be_by_zero_nothing_false_is_found) {
  // Found by a search over such grids. The cubic has a double root; the quadratic is x^2; a distance is infinite; the polishing
  // steps have no direction; the eigenvalues are of one size.
  struct Case {
    std::array<Vec3, 3> p_T, directions;
  };
  const std::array<Case, 8> cases{
      {{{Vec3(1, 0, 0), Vec3(1, 1, 1), Vec3(2, 0, 1)}, {Vec3(2, 2, -2), Vec3(1, -2, -1), Vec3(0, 0, -2)}},
       {{Vec3(0, 2, 1), Vec3(2, 0, 1), Vec3(0, 0, -1)}, {Vec3(-1, -1, -1), Vec3(-1, 2, -1), Vec3(1, 0, 0)}},
       {{Vec3(2, 0, 1), Vec3(-1, 0, 0), Vec3(-2, -1, 2)}, {Vec3(0, 0, -1), Vec3(2, -1, -2), Vec3(2, -1, 0)}},
       {{Vec3(1, 2, -1), Vec3(-2, -2, 0), Vec3(-2, 2, -1)}, {Vec3(-1, -1, -1), Vec3(2, -2, 1), Vec3(-2, 0, -2)}},
       {{Vec3(-1, -2, 1), Vec3(2, -1, 0), Vec3(0, -1, -2)}, {Vec3(-1, -2, -2), Vec3(1, -2, -2), Vec3(1, -2, -2)}},
       {{Vec3(1, 0, 1), Vec3(2, -2, -1), Vec3(-1, -2, 2)}, {Vec3(-2, 2, -2), Vec3(-2, 2, -1), Vec3(-2, 2, -1)}},
       {{Vec3(1, 0, -1), Vec3(-2, 1, -1), Vec3(1, -1, 2)}, {Vec3(-1, 0, 2), Vec3(2, 2, -1), Vec3(2, 2, -1)}},
       {{Vec3(1, 2, -1), Vec3(2, 2, -2), Vec3(2, 1, -1)}, {Vec3(-1, 0, -1), Vec3(-1, 2, 0), Vec3(2, 1, 1)}}}};
  int found = 0;
  for (const Case& c : cases) found += check_what_is_found(c.p_T, c.directions);
  LONGS_EQUAL(1, found);  // of the last one
  const Vec3 same(0.1, 0.2, 1.0);
  LONGS_EQUAL(0, check_what_is_found(cases[0].p_T, {same, same, same}));
}

}  // namespace relnav
