// What the operations and functions of the fixed-point path err by, and that docs/fixed-point.md says so.
// RELNAV_UPDATE_FIXED_POINT=1 in the environment rewrites its tables.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "fsw/attitude/msr.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/geometry/motor.hpp"
#include "fsw/geometry/triangulation.hpp"
#include "fsw/math/elementary.hpp"
#include "fsw/math/scalar.hpp"
#include "tests/support/generated_document.hpp"
#include "tests/support/wide.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using test::Wide;

namespace {

constexpr std::uint64_t seed = 662607;

std::string text_of(int digits, double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

/// Largest error, in steps, and where.
struct Worst {
  double steps = 0.0;
  std::string at = "everywhere";
  template <typename Where>
  void see(double error, const Where& where) {
    if (!(error > steps)) return;
    steps = error;
    at = where();
  }
};

struct Row {
  std::string what;
  double bound = 0.0;
  Worst worst;
};

/// Of one format: every operation over pairs of numbers of every size and close to where something happens.
template <int Bits, typename Raw>
class Operations {
  using F = Fixed<Bits, Raw>;
  static constexpr int digits = std::numeric_limits<Raw>::digits;

 public:
  std::vector<Row> sweep() {
    const std::vector<Raw> numbers = numbers_of_every_size();
    for (const Raw a : numbers) {
      alone(a);
      for (const Raw b : numbers) together(a, b);
    }
    for (int i = 0; i < 400000; ++i) {
      const Raw a = draw();
      alone(a);
      together(a, draw());
      const int size = static_cast<int>(generator_.below(digits + 4)) - Bits;  // drawn first, by every compiler
      const double value = std::ldexp(2.0 * generator_.uniform() - 1.0, size);
      from_double(value);
    }
    return {{"a + b, a - b", 0.0, sum_},
            {"a b", 0.5, product_},
            {"a / b", 0.5, quotient_},
            {"sqrt(a)", 0.5, root_},
            {"from `double`", 0.5, from_double_},
            {"to `double`, relative, in 2^-53", Bits < 53 && digits < 53 ? 0.0 : 1.0, to_double_},
            {"from Q2.29", Bits < 29 ? 0.5 : 0.0, from_29_},
            {"from Q16.47", Bits < 47 ? 0.5 : 0.0, from_47_},
            {"from Q7.56", Bits < 56 ? 0.5 : 0.0, from_56_}};
  }

 private:
  static Wide magnitude(Raw raw) { return raw < 0 ? -Wide(raw) : Wide(raw); }
  static std::string name(const char* what, Raw raw) {
    return std::string(what) + " = " + text_of(17, std::ldexp(static_cast<double>(raw), -Bits));
  }
  static std::string names(Raw a, Raw b) { return name("a", a) + ", " + name("b", b); }

  Raw draw() {
    const std::uint64_t high = generator_.next();
    const std::uint64_t bits = (high << 32U) | generator_.next();
    const auto raw = static_cast<Raw>(bits >> (64U - digits + generator_.below(digits)));
    return generator_.below(2) == 0 ? raw : -raw;
  }
  static std::vector<Raw> numbers_of_every_size() {
    std::vector<Raw> numbers;
    for (int bit = 0; bit < digits; ++bit) {
      const Raw power = Raw{1} << bit;
      for (const Raw v : {power - 1, power, power + 1, power + power / 2}) {
        numbers.push_back(v);
        numbers.push_back(-v);
      }
    }
    return numbers;
  }

  void together(Raw a, Raw b) {
    const F x = F::from_raw(a);
    const F y = F::from_raw(b);
    const auto difference = [](Wide p, Wide q) { return static_cast<double>(p < q ? q - p : p - q); };
    if (!(x + y).overflowed()) {
      sum_.see(difference(Wide(a) + b, (x + y).raw()), [&] { return names(a, b); });
    }
    if (!(x - y).overflowed()) {
      sum_.see(difference(Wide(a) - b, (x - y).raw()), [&] { return names(a, b); });
    }
    const F p = x * y;
    if (!p.overflowed()) {
      product_.see(std::ldexp(difference(magnitude(a) * magnitude(b), magnitude(p.raw()) << Bits), -Bits),
                   [&] { return names(a, b); });
    }
    const F q = x / y;
    if (!q.overflowed()) {
      quotient_.see(
          difference(magnitude(a) << Bits, magnitude(q.raw()) * magnitude(b)) / static_cast<double>(magnitude(b)),
          [&] { return names(a, b); });
    }
  }
  void alone(Raw a) {
    if (a >= 0) {
      const Wide r = sqrt(F::from_raw(a)).raw();
      const Wide square = Wide(a) << Bits;
      const double off = static_cast<double>(square < r * r ? r * r - square : square - r * r);
      const double sum = std::sqrt(static_cast<double>(square)) + static_cast<double>(r);
      if (sum > 0.0) root_.see(off / sum, [&] { return name("a", a); });
    }
    if (a != 0) {
      const Wide back = Wide::from_double(std::ldexp(static_cast<double>(F::from_raw(a)), Bits));
      const Wide off = back < a ? Wide(a) - back : back - a;
      to_double_.see(std::ldexp(static_cast<double>(off) / static_cast<double>(magnitude(a)), 53),
                     [&] { return name("a", a); });
    }
    // The same bits as a number of the other formats.
    from<29, std::int32_t>(static_cast<std::int32_t>(digits < 32 ? a : a >> 32), from_29_);
    from<47, std::int64_t>(a, from_47_);
    from<56, std::int64_t>(a, from_56_);
  }
  void from_double(double value) {
    const F x(value);
    if (x.overflowed()) return;
    const double scaled = std::ldexp(value, Bits);
    from_double_.see(std::fabs(scaled - static_cast<double>(x.raw())), [&] { return text_of(17, value); });
  }
  template <int OtherBits, typename OtherRaw>
  static void from(OtherRaw raw, Worst& worst) {
    const F x(Fixed<OtherBits, OtherRaw>::from_raw(raw));
    if (x.overflowed()) return;
    constexpr int up = std::max(Bits - OtherBits, 0);
    constexpr int down = std::max(OtherBits - Bits, 0);
    const Wide off = (Wide(raw) << up) - (Wide(x.raw()) << down);
    worst.see(std::ldexp(static_cast<double>(off < 0 ? -off : off), -down),
              [&] { return text_of(17, std::ldexp(static_cast<double>(raw), -OtherBits)); });
  }

  Generator generator_{seed};
  Worst sum_, product_, quotient_, root_, from_double_, to_double_, from_29_, from_47_, from_56_;
};

/// Step of a scalar near one.
template <typename S>
struct Step {
  static constexpr double value = 0x1p-24;  // float
};
template <int Bits, typename Raw>
struct Step<Fixed<Bits, Raw>> {
  static constexpr double value = 1.0 / static_cast<double>(std::int64_t{1} << Bits);
};

/// Functions in a scalar against the same in double, from the same numbers.
template <typename S>
class Functions {
  using Vector = Eigen::Matrix<S, 3, 1>;
  using Vector_d = Eigen::Matrix<double, 3, 1>;
  static constexpr bool is_wide = std::is_same_v<S, FixedQ47> || std::is_same_v<S, float>;

 public:
  std::vector<Row> sweep() {
    for (int i = 0; i < 100000; ++i) attitude(i);
    std::vector<Row> rows{{"`GibbsSet::dcm`, \\|g_k\\| <= 1", 4.0, dcm_},
                          {"`GibbsSet::correct`, \\|g_k\\| <= 1, \\|dg_k\\| and dg'g <= 1/4", 6.0, correct_},
                          {"`GibbsSet::switch_if_due`, \\|g_k\\| <= 7/3", 1.0, switch_}};
    if (!is_wide) return rows;
    for (int i = 0; i < 20000; ++i) lines_and_points();
    for (int i = 0; i < 5000; ++i) systems();
    rows.push_back({"`MotorLine::through`, points within 2, 0.1 apart: n", 3.0, direction_});
    rows.push_back({"`triangulate`, parallax p from 0.005: relative error of z, times p", 6.0, depth_});
    rows.push_back({"`NormalEquations<6>`, 16 rows of elements within 1: solution, over 16 tr(A^-1) and its length",
                    1.0, solution_});
    rows.push_back({"`symmetric_eigen<4>`, elements within 1: eigenvalues", 40.0, eigenvalue_});
    return rows;
  }

 private:
  double uniform(double size) { return size * (2.0 * generator_.uniform() - 1.0); }
  /// As S has it, in double too.
  Vector random(double size, Vector_d& in_double) {
    Vector v;
    for (int k = 0; k < 3; ++k) {
      const bool corner = generator_.below(8) == 0;
      const double x = corner ? (generator_.below(2) == 0 ? size : -size) : uniform(size);
      v(k) = static_cast<S>(x);
      in_double(k) = static_cast<double>(v(k));
    }
    return v;
  }
  static std::string name(const char* what, const Vector_d& v) {
    return std::string(what) + " = (" + text_of(6, v(0)) + ", " + text_of(6, v(1)) + ", " + text_of(6, v(2)) + ")";
  }
  template <typename A, typename B>
  static double steps(const A& actual, const B& expected) {
    double largest = 0.0;
    for (int k = 0; k < static_cast<int>(expected.size()); ++k) {
      CHECK(is_sound(actual(k)));
      largest = std::max(largest, std::fabs(static_cast<double>(actual(k)) - expected(k)));
    }
    return largest / Step<S>::value;
  }

  void attitude(int i) {
    Vector_d g;
    Vector_d dg;
    GibbsSet<S> a{random(1.0, g), i % 4};
    GibbsSet<double> b{g, i % 4};
    const Vector d = random(0.25, dg);
    const auto where = [&] { return name("g", g) + (i % 4 == 0 ? "" : ", set " + std::to_string(i % 4)); };
    const Eigen::Matrix<S, 3, 3> R = a.dcm();
    dcm_.see(steps(R.reshaped(), b.dcm().reshaped().eval()), where);
    if (dg.dot(g) > 0.25) return;
    a.correct(d);
    b.correct(dg);
    correct_.see(steps(a.g, b.g), [&] { return where() + ", " + name("dg", dg); });
    for (int k = 0; k < 3; ++k) b.g(k) = static_cast<double>(a.g(k));
    const Vector_d before = b.g;
    if (a.switch_if_due() != b.switch_if_due()) return;  // the next number is 1 exactly
    switch_.see(steps(a.g, b.g), [&] { return name("g", before); });
  }

  void lines_and_points() {
    Vector_d p;
    Vector_d q;
    const Vector a = random(2.0, p);
    const Vector b = random(2.0, q);
    if ((p - q).norm() > 0.1) {
      direction_.see(steps(MotorLine<S>::through(a, b).n, MotorLine<double>::through(p, q).n),
                     [&] { return name("a", p) + ", " + name("b", q); });
    }
    // A point 2 to 200 baselines ahead in two cameras side by side, turned a little.
    const double z = math::exp(0.7 + 4.6 * generator_.uniform());
    const double y = 0.3 * z * uniform(1.0);
    const double x = 0.3 * z * uniform(1.0);
    const Vector_d point(x, y, z);
    const double turn = uniform(0.2);
    const math::SinCos s = math::sincos(turn);
    Eigen::Matrix3d R;
    R << s.cos, 0.0, -s.sin, 0.0, 1.0, 0.0, s.sin, 0.0, s.cos;
    const double up = uniform(0.1);
    const double along = uniform(0.1);
    const Vector_d t = R * Vector_d(-1.0, along, up);
    const Vector_d second = R * point + t;
    if (second(2) < 1.0) return;
    const Eigen::Matrix<S, 2, 1> xy_1(static_cast<S>(point(0) / z), static_cast<S>(point(1) / z));
    const Eigen::Matrix<S, 2, 1> xy_2(static_cast<S>(second(0) / second(2)), static_cast<S>(second(1) / second(2)));
    const Eigen::Matrix<S, 3, 3> R_s = R.template cast<S>();
    const Vector t_s = t.template cast<S>();
    Vector found;
    Vector_d expected;
    CHECK(triangulate<S>(xy_1, xy_2, R_s, t_s, found) == Status::ok);
    CHECK(triangulate<double>(xy_1.template cast<double>(), xy_2.template cast<double>(), R_s.template cast<double>(),
                              t_s.template cast<double>(), expected) == Status::ok);
    CHECK(is_sound(found));
    const double error = std::fabs(static_cast<double>(found(2)) / expected(2) - 1.0) / z / Step<S>::value;
    depth_.see(error, [&] { return name("p_C", point) + ", turned by " + text_of(3, turn) + " rad"; });
  }

  void systems() {
    NormalEquations<S, 6> e;
    NormalEquations<double, 6> f;
    e.clear();
    f.clear();
    for (int row = 0; row < 16; ++row) {
      std::array<S, 6> j;
      std::array<double, 6> j_d;
      for (std::size_t k = 0; k < 6; ++k) {
        j[k] = static_cast<S>(uniform(1.0));
        j_d[k] = static_cast<double>(j[k]);
      }
      const auto r = static_cast<S>(uniform(1.0));
      e.add(j, r);
      f.add(j_d, static_cast<double>(r));
    }
    CHECK(e.factorise(S(0)) == Status::ok);
    CHECK(f.factorise(0.0) == Status::ok);
    S gain;
    double gain_d = 0.0;
    const auto d = e.solution(gain);
    const auto d_d = f.solution(gain_d);
    // No smaller than what errors of A are multiplied by.
    const double sensitivity = f.inverse().trace() * 16.0;
    solution_.see(steps(d, d_d) / (sensitivity * std::max(d_d.norm(), 1.0)),
                  [&] { return "16 tr(A^-1) = " + text_of(3, sensitivity); });

    Eigen::Matrix<S, 4, 4> A;
    Eigen::Matrix<S, 4, 4> V;
    Eigen::Matrix<double, 4, 4> A_d;
    Eigen::Matrix<double, 4, 4> V_d;
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c <= r; ++c) {
        A(r, c) = A(c, r) = static_cast<S>(uniform(1.0));
        A_d(r, c) = A_d(c, r) = static_cast<double>(A(r, c));
      }
    }
    symmetric_eigen<S, 4>(A, V);
    symmetric_eigen<double, 4>(A_d, V_d);
    std::array<double, 4> values;
    std::array<double, 4> expected;
    for (int k = 0; k < 4; ++k) {
      CHECK(is_sound(A(k, k)));
      values[static_cast<std::size_t>(k)] = static_cast<double>(A(k, k));
      expected[static_cast<std::size_t>(k)] = A_d(k, k);
    }
    std::sort(values.begin(), values.end());
    std::sort(expected.begin(), expected.end());
    for (std::size_t k = 0; k < 4; ++k) {
      eigenvalue_.see(std::fabs(values[k] - expected[k]) / Step<S>::value,
                      [&] { return "eigenvalue " + text_of(3, expected[k]); });
    }
  }

  Generator generator_{seed + 1};
  Worst dcm_, correct_, switch_, direction_, depth_, solution_, eigenvalue_;
};

std::string table(const std::string& title, const std::vector<Row>& rows) {
  std::string text = "\n#### " + title + "\n| | bound | worst found | at |\n|---|---|---|---|\n";
  for (const Row& row : rows) {
    CHECK_TEXT(row.worst.steps <= row.bound, (title + ": " + row.what + " at " + row.worst.at).c_str());
    text += "| " + row.what + " | " + text_of(6, row.bound) + " | " + text_of(3, row.worst.steps) + " | " +
            row.worst.at + " |\n";
  }
  return text;
}

}  // namespace

TEST_GROUP(FixedAccuracy){};

TEST(FixedAccuracy, every_operation_keeps_its_bound_and_the_document_says_so) {
  std::string made;
  made += table("Operations, Q2.29 (step 1.9e-9)", Operations<29, std::int32_t>().sweep());
  made += table("Operations, Q16.47 (step 7.1e-15)", Operations<47, std::int64_t>().sweep());
  made += table("Operations, Q7.56 (step 1.4e-17)", Operations<56, std::int64_t>().sweep());
  made += table("Functions, Q2.29", Functions<FixedQ29>().sweep());
  made += table("Functions, Q16.47", Functions<FixedQ47>().sweep());
  made += table("Functions, `float` (step 2^-24)", Functions<float>().sweep());
  test::check_generated("docs/fixed-point.md",
                        "<!-- tables: made by tests/unit/geometry/fixed_accuracy_test.cpp, begin -->\n",
                        "<!-- tables: end -->\n", made + "\n", "RELNAV_UPDATE_FIXED_POINT");
}
