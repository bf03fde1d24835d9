#pragma once
#include <cstdint>

// One filter update, n = 252 states and m = 60 rows, as plain data: it crosses the border of shared libraries that are
// compiled with different vector widths, and so must not carry an Eigen or a std type.

namespace relnav::bench {

inline constexpr int states = 252;
inline constexpr int pairs = 30;
inline constexpr int rows = 2 * pairs;
inline constexpr int motion = 12;
inline constexpr int feature = 6;

struct Case {
  double P[states * states];                    // column-major, symmetric
  double motion_coefficients[rows * motion];    // row-major; columns 6..11 are zero, as in the filter
  double feature_coefficients[rows * feature];  // row-major
  int feature_offset[pairs];
  double r[rows];
};

enum Part { p_ht, s, cholesky, solve, downdate, part_count };

/// What each library exports: `prepare` takes the case, `restore` resets P, `update` runs once, `result` copies P out.
struct Update {
  void (*prepare)(const Case*);
  void (*restore)();
  bool (*update)();
  bool (*part)(int);  // one step of `update`; in order, after restore
  void (*result)(double*);
};

}  // namespace relnav::bench

extern "C" {
[[gnu::visibility("default")]] const relnav::bench::Update* relnav_kernels_sse2();
[[gnu::visibility("default")]] const relnav::bench::Update* relnav_kernels_v3();
[[gnu::visibility("default")]] const relnav::bench::Update* relnav_eigen_sse2();
[[gnu::visibility("default")]] const relnav::bench::Update* relnav_eigen_v3();
}
