// Equations of the motor solver by themselves; the solver: tests/unit/estimation/scaled_motor_solver_test.cpp.
#include "fsw/geometry/motor.hpp"

#include <vector>

#include "fsw/attitude/so3.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/math/types.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using Line = MotorLine<double>;

Vec3 draw(Generator& generator) {
  Vec3 v;
  for (int k = 0; k < 3; ++k) v(k) = 2.0 * generator.uniform() - 1.0;
  return v;
}

}  // namespace

TEST_GROUP(Motor){};

TEST(Motor, line_through_two_points_is_a_unit_direction_and_a_moment) {
  const Line line = Line::through(Vec3(0.0, 2.0, 0.0), Vec3(-3.0, 2.0, 0.0));
  CHECK((line.n - Vec3(-1.0, 0.0, 0.0)).norm() < 1e-15);
  CHECK((line.m - Vec3(0.0, 0.0, 2.0)).norm() < 1e-15);
  // Any two points of the line, also far apart or close together.
  for (const double length : {1e-3, 1.0, 1e3}) {
    const Vec3 a(5.0, 2.0, 0.0);
    const Line same = Line::through(a, a - length * Vec3::UnitX());
    CHECK((same.n - line.n).norm() < 1e-15);
    CHECK((same.m - line.m).norm() < 1e-14);
  }
}

TEST(Motor, lines_of_a_moved_body_give_the_motion) {
  Generator generator(5);
  for (int i = 0; i < 200; ++i) {
    const Mat3 R_CT = exp_so3(3.0 * draw(generator));
    const Vec3 t_CT = 4.0 * draw(generator);
    constexpr int count = 4;
    RotorEquations<double> rotor(count);
    std::vector<Line> lines_T;
    std::vector<Line> lines_C;
    for (int k = 0; k < count; ++k) {
      const Vec3 a = draw(generator);
      const Vec3 b = draw(generator);
      lines_T.push_back(Line::through(a, b));
      lines_C.push_back(Line::through(R_CT * a + t_CT, R_CT * b + t_CT));
      rotor.add(lines_T.back().n, lines_C.back().n);
    }
    Mat3 R_found;
    CHECK(rotor.solve(1e-6, R_found) == Status::ok);
    CHECK((R_found - R_CT).norm() < 1e-9);
    TranslatorEquations<double> translator(count);
    for (std::size_t k = 0; k < lines_C.size(); ++k) translator.add(lines_C[k], R_CT * lines_T[k].m);
    Vec3 t_found;
    CHECK(translator.solve(1e-9, t_found) == Status::ok);
    CHECK((t_found - t_CT).norm() < 1e-9);
  }
}

TEST(Motor, parallel_lines_leave_the_motion_open) {
  RotorEquations<double> rotor(3);
  TranslatorEquations<double> translator(3);
  const Vec3 n = Vec3(1.0, 2.0, -2.0) / 3.0;
  for (int k = 0; k < 3; ++k) {
    const Line line = Line::through(Vec3(k, 0.0, 0.0), Vec3(k, 0.0, 0.0) + n);
    rotor.add(line.n, line.n);
    translator.add(line, line.m);
  }
  Mat3 R_CT = Mat3::Constant(7.0);
  Vec3 t_CT = Vec3::Constant(7.0);
  CHECK(rotor.solve(1e-6, R_CT) == Status::rank_deficient);
  CHECK(translator.solve(1e-6, t_CT) != Status::ok);
  CHECK(R_CT == Mat3(Mat3::Constant(7.0)) && t_CT == Vec3(Vec3::Constant(7.0)));
}

}  // namespace relnav
