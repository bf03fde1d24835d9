#include "fsw/math/chi_square.hpp"

#include <algorithm>
#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace relnav;

namespace {

/// How often chi-square of an even number of degrees of freedom passes x.
double passes(int k, double x) {
  double term = 1.0;
  double sum = 1.0;
  for (int i = 1; i < k / 2; ++i) {
    term *= 0.5 * x / i;
    sum += term;
  }
  return std::exp(-0.5 * x) * sum;
}

/// The exact point, by bisection.
double point(int k, double z) {
  const double probability = 0.5 * std::erfc(z / std::sqrt(2.0));
  double low = 0.0;
  double high = 1000.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (passes(k, middle) > probability ? low : high) = middle;
  }
  return low;
}

double largest_error(int k, double z_max) {
  double largest = 0.0;
  for (int i = 0; 0.1 * i <= z_max + 1e-9; ++i) {
    largest = std::max(largest, std::fabs(chi2_point(k, 0.1 * i) / point(k, 0.1 * i) - 1.0));
  }
  return largest;
}

}  // namespace

TEST_GROUP(ChiSquare){};

TEST(ChiSquare, point_is_as_near_as_stated) {
  CHECK(largest_error(2, 2.4) < 0.014);
  CHECK(largest_error(2, 5.0) < 0.11);
  for (const int k : {4, 6, 12, 60, 120}) {
    CHECK(largest_error(k, 2.4) < 0.005);
    CHECK(largest_error(k, 5.0) < 0.065);
  }
  CHECK(chi2_point(2, 5.0) > point(2, 5.0));
}

TEST(ChiSquare, ninety_nine_percent) {
  DOUBLES_EQUAL(6.6349, chi2_99(1), 0.05);  // printed tables
  DOUBLES_EQUAL(9.2103, chi2_99(2), 0.02);
  DOUBLES_EQUAL(16.8119, chi2_99(6), 0.04);
  DOUBLES_EQUAL(88.3794, chi2_99(60), 0.03);
}
