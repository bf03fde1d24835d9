// GibbsSet, the MSR of the iterations: against RodriguesChart and the equations as printed, and its bound.
#include "fsw/attitude/msr.hpp"

#include <cmath>
#include <cstdio>

#include "fsw/attitude/rodrigues.hpp"
#include "fsw/attitude/so3.hpp"
#include "fsw/math/scalar.hpp"
#include "tests/unit/attitude/attitude_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using test::max_difference;

constexpr std::uint64_t seed = 141421;

template <typename S>
GibbsSet<S> gibbs(const Vec3& g, int set) {
  GibbsSet<S> out;
  for (int k = 0; k < 3; ++k) out.g(k) = S(g(k));
  out.set = set;
  return out;
}

template <typename S>
Mat3 dcm_in_double(const GibbsSet<S>& a) {
  const auto R = a.dcm();
  Mat3 out;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out(r, c) = static_cast<double>(R(r, c));
  }
  return out;
}

// (3), (4)
Mat3 dcm_as_printed(const Vec3& g, int set) {
  Vec3 d = Vec3::Ones();
  if (set != 0) {
    d = -d;
    d[set - 1] = 1.0;
  }
  const double g2 = g.squaredNorm();
  const Mat3 C = ((1.0 - g2) * Mat3::Identity() + 2.0 * g * g.transpose() - 2.0 * cross_matrix(g)) / (1.0 + g2);
  return C * d.asDiagonal();
}

/// Attitudes as they stand between a correction and the switch: within and beyond the bound, 180 deg, equal components.
Vec3 sample(Generator& generator, int i) {
  Vec3 g = test::random_vector(generator, 1.0);
  const auto one_of_three = [&] { return static_cast<int>(generator.below(3)); };
  switch (i % 8) {
    case 0: g *= 5.0; break;
    case 1: g *= 1.0 + 1e-9 * generator.uniform(); break;
    case 2: g *= 1e4; break;  // near 180 deg of the set
    case 3: {                 // one component exactly at the bound, or a last place beyond
      const double side = generator.below(2) == 0 ? 1.0 : -1.0;
      g(one_of_three()) = generator.below(2) == 0 ? side : std::nextafter(side, 2.0 * side);
      break;
    }
    case 4: {  // two or three of one size
      const double size = generator.below(2) == 0 ? 1.0 : 3.0 * generator.uniform();
      const int but = one_of_three();
      for (int k = 0; k < 3; ++k) {
        if (k != but || generator.below(3) == 0) g(k) = generator.below(2) == 0 ? size : -size;
      }
      break;
    }
    case 5: {  // the target frames turned by pi exactly
      const int axis = one_of_three();
      g.setZero();
      g(axis) = generator.below(2) == 0 ? 1e15 : -1e15;
      break;
    }
    case 6: {  // exactly +-1 or 0
      for (int k = 0; k < 3; ++k) g(k) = static_cast<double>(generator.below(3)) - 1.0;
      break;
    }
    default: break;
  }
  return g;
}

struct SwitchReport {
  double dcm = 0.0;
  int switches = 0;
  int kept = 0;
};

template <typename S>
SwitchReport switch_samples(int count, double largest_component) {
  Generator generator(seed);
  SwitchReport report;
  for (int i = 0; i < count; ++i) {
    const Vec3 g = sample(generator, i);
    if (g.cwiseAbs().maxCoeff() > largest_component) continue;
    GibbsSet<S> a = gibbs<S>(g, i / 8 % 4);
    bool due = false;
    for (int k = 0; k < 3; ++k) due = due || a.g(k) > S(1) || a.g(k) < S(-1);
    const GibbsSet<S> before = a;
    const bool switched = a.switch_if_due();
    bool bounded = a.set >= 0 && a.set <= 3 && switched == due;
    for (int k = 0; k < 3; ++k) bounded = bounded && a.g(k) <= S(1) && a.g(k) >= S(-1);
    if (!bounded) {
      std::printf("  seed %llu, sample %d: g %.17g %.17g %.17g\n", static_cast<unsigned long long>(seed), i, g(0), g(1),
                  g(2));
      FAIL("the bound does not hold, or a switch that was not due");
    }
    if (!switched) {
      ++report.kept;
      continue;
    }
    ++report.switches;
    report.dcm = std::max(report.dcm, max_difference(dcm_in_double(before), dcm_in_double(a)));
  }
  return report;
}

}  // namespace

TEST_GROUP(GibbsSets){};

TEST(GibbsSets, dcm_is_the_printed_one_and_the_charts) {
  Generator generator(seed);
  double printed = 0.0;
  double chart = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 g = test::random_vector(generator, i % 2 == 0 ? 1.0 : 4.0);
    const Mat3 R_CT = gibbs<double>(g, i % 4).dcm();
    printed = std::max(printed, max_difference(R_CT, dcm_as_printed(g, i % 4)));
    chart = std::max(chart, max_difference(R_CT, RodriguesChart::from_parameters(g, i % 4).dcm()));
  }
  std::printf("    dcm: against (3) %.1e, against RodriguesChart %.1e\n", printed, chart);
  CHECK(printed < 1e-15);
  CHECK(chart < 2e-15);
}

TEST(GibbsSets, a_correction_is_a_rotation_from_the_left_in_every_set) {
  Generator generator(seed + 1);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 dg = test::random_vector(generator, 0.5);
    GibbsSet<double> a = gibbs<double>(test::random_vector(generator, 1.0), i % 4);
    if (std::fabs(1.0 - dg.dot(a.g)) < 0.1) continue;
    const Mat3 expected = gibbs<double>(dg, 0).dcm() * a.dcm();
    a.correct(dg);
    worst = std::max(worst, max_difference(expected, a.dcm()));
  }
  std::printf("    correct: %.1e\n", worst);
  CHECK(worst < 2e-15);
}

TEST(GibbsSets, a_switch_bounds_every_component_and_keeps_the_attitude) {
  const SwitchReport r = switch_samples<double>(2000000, 1e300);
  std::printf("    %d switches, %d not due, dcm kept to %.1e\n", r.switches, r.kept, r.dcm);
  CHECK(r.switches > 900000);
  CHECK(r.kept > 900000);
  CHECK(r.dcm < 1e-15);
}

TEST(GibbsSets, float_and_fixed_hold_the_bound_too) {
  const SwitchReport f = switch_samples<float>(400000, 1e30);
  // Fixed point: as far as its range reaches; squares of g in dcm() reach 65536 at |g| of about 128.
  const SwitchReport q = switch_samples<FixedQ47>(100000, 100.0);
  std::printf("    float: %d switches, dcm kept to %.1e; fixed: %d switches, dcm kept to %.1e\n", f.switches, f.dcm,
              q.switches, q.dcm);
  CHECK(f.switches > 100000);
  CHECK(f.dcm < 5e-7);
  CHECK(q.switches > 10000);
  CHECK(q.dcm < 1e-12);  // 1 / (1 + g'g) loses as many digits as g'g gains
}

/// Largest error of a DCM after corrections and switches of a quarter at most, Q2.29 against double.
TEST(GibbsSets, iterates_in_32_bits) {
  Generator generator(seed + 3);
  double dcm = 0.0;
  double composed = 0.0;
  for (int i = 0; i < 200000; ++i) {
    Vec3 g = test::random_vector(generator, 1.0);
    Vec3 dg = test::random_vector(generator, 0.25);
    if (i % 4 == 0) g = g.cwiseSign();  // (1, 1, 1): 1 + g'g is 4, out of range
    if (i % 3 == 0) dg = 0.25 * dg.cwiseSign();
    if (dg.dot(g) > 0.25) dg *= 0.25 / dg.dot(g);
    GibbsSet<FixedQ29> a = gibbs<FixedQ29>(g, i % 4);
    GibbsSet<FixedQ29>::Vector d;
    for (int k = 0; k < 3; ++k) {
      d(k) = FixedQ29(dg(k));
      g(k) = static_cast<double>(a.g(k));
      dg(k) = static_cast<double>(d(k));
    }
    GibbsSet<double> b = gibbs<double>(g, i % 4);
    CHECK(is_sound(a.dcm()));
    dcm = std::max(dcm, max_difference(dcm_in_double(a), b.dcm()));
    a.correct(d);
    b.correct(dg);
    CHECK(is_sound(a.g));
    static_cast<void>(a.switch_if_due());
    for (int k = 0; k < 3; ++k) CHECK(abs(a.g(k)) <= FixedQ29(1));
    composed = std::max(composed, max_difference(dcm_in_double(a), b.dcm()));
  }
  std::printf("    Q2.29: dcm off by %.1e, after correction and switch %.1e\n", dcm, composed);
  CHECK(dcm < 8 * 0x1p-29);
  CHECK(composed < 16 * 0x1p-29);
  CHECK(composed > 0x1p-29);
}

TEST(GibbsSets, fixed_point_at_the_bound_is_exact) {
  // A last place beyond 1, with companions as large: the quotients must not round beyond 1.
  const FixedQ47 beyond = FixedQ47::from_raw((std::int64_t{1} << 47) + 1);
  GibbsSet<FixedQ47> a;
  a.g = {beyond, -beyond, beyond};
  CHECK(a.switch_if_due());
  for (int k = 0; k < 3; ++k) {
    CHECK(abs(a.g(k)) <= FixedQ47(1));
    CHECK_FALSE(a.g(k).overflowed());
  }
  CHECK_FALSE(a.switch_if_due());
}

TEST(GibbsSets, index_after_a_switch_is_the_printed_one) {
  for (int set = 0; set < 4; ++set) {
    for (int j = 1; j <= 3; ++j) {
      Vec3 g(0.1, -0.2, 0.3);
      g(j - 1) = -1.5;
      GibbsSet<double> a = gibbs<double>(g, set);
      CHECK(a.switch_if_due());
      LONGS_EQUAL(set == 0 ? j : (set == j ? 0 : 6 - j - set), a.set);
      CHECK(max_difference(dcm_as_printed(g, set), a.dcm()) < 1e-15);
    }
  }
}

TEST(GibbsSets, iterates_within_the_stated_bounds) {
  // What the header promises between switches: |dg_k| and dg'g at most 1/2, |g_k| at most 1.
  Generator generator(seed + 2);
  double largest = 0.0;
  for (int i = 0; i < 300000; ++i) {
    Vec3 g = test::random_vector(generator, 1.0);
    Vec3 dg = test::random_vector(generator, 0.5);
    if (i % 4 == 0) g = g.cwiseSign();
    if (i % 3 == 0) dg = 0.5 * dg.cwiseSign();
    const double product = dg.dot(g);
    if (product > 0.5) dg *= 0.5 / product;
    GibbsSet<double> a = gibbs<double>(g, i % 4);
    a.correct(dg);
    largest = std::max(largest, a.g.cwiseAbs().maxCoeff());
  }
  std::printf("    largest component between correction and switch: %.3f\n", largest);
  CHECK(largest <= 5.0 + 1e-12);
  CHECK(largest > 4.5);
}

}  // namespace relnav
