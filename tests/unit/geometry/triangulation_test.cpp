#include "fsw/geometry/triangulation.hpp"

#include <limits>

#include "fsw/attitude/so3.hpp"
#include "fsw/math/types.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

const Mat3 R_KC = exp_so3(Vec3(0.02, -0.1, 0.03));
const Vec3 t_KC(-0.5, 0.02, 0.01);

Vec2 image(const Vec3& p) { return Vec2(p.x() / p.z(), p.y() / p.z()); }

Status triangulated(const Vec2& xy_1, const Vec2& xy_2, Vec3& p_C) {
  return triangulate<double>(xy_1, xy_2, R_KC, t_KC, p_C);
}

}  // namespace

TEST_GROUP(Triangulation){};

TEST(Triangulation, two_images_of_a_point_give_it_back) {
  for (const Vec3& p_C : {Vec3(0.2, -0.1, 2.0), Vec3(-3.0, 1.0, 20.0), Vec3(0.0, 0.0, 1000.0)}) {
    Vec3 found;
    CHECK(triangulated(image(p_C), image(R_KC * p_C + t_KC), found) == Status::ok);
    CHECK((found - p_C).norm() < 1e-10 * p_C.squaredNorm());
  }
}

TEST(Triangulation, parallel_rays_do_not_meet) {
  const Vec3 direction(0.1, 0.2, 1.0);
  Vec3 found = Vec3::Constant(7.0);
  CHECK(triangulated(image(direction), image(R_KC * direction), found) == Status::rank_deficient);
  // A point so far away that the parallax is half of what is asked for, and one at twice of it.
  for (const double parallax : {0.5 * least_parallax, 2.0 * least_parallax}) {
    const Vec3 p_C = 0.5 / parallax * direction;
    const Status status = triangulated(image(p_C), image(R_KC * p_C + t_KC), found);
    CHECK(status == (parallax < least_parallax ? Status::rank_deficient : Status::ok));
  }
}

TEST(Triangulation, nan_is_no_point) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Vec3 found = Vec3::Constant(7.0);
  CHECK(triangulated(Vec2(nan, 0.0), Vec2(0.1, 0.0), found) != Status::ok);
  CHECK(triangulated(Vec2(0.1, 0.0), Vec2(0.1, nan), found) != Status::ok);
  CHECK(triangulated(Vec2(0.1, 0.0), Vec2(nan, 0.1), found) != Status::ok);
  CHECK(found == Vec3(Vec3::Constant(7.0)));
}

}  // namespace relnav
