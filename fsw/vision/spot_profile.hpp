#pragma once
#include <array>
#include <cstddef>

namespace relnav::vision {

/// Profile across a bright disc seen through a Gaussian point spread, as that of a slab: with distance r from the centre,
/// half width R and point spread s
///   p(r) = Phi((R - r) / s) - Phi((-R - r) / s),
/// Phi the normal distribution. Near a Gaussian for R < s, an edge at r = R for R >> s.
struct SpotProfile {
  double level = 0.0;      ///< p
  double by_radius = 0.0;  ///< dp/dr
  double by_width = 0.0;   ///< dp/dR
};

namespace profile {

inline constexpr double reach = 4.0;  ///< Phi is 0 or 1 beyond
inline constexpr int steps = 32;      ///< of the tables, a unit; linear in between: error below 6e-5
inline constexpr std::size_t entries = static_cast<std::size_t>(2.0 * reach) * steps + 2;

struct Entry {
  double density = 0.0;
  double distribution = 0.0;
};

constexpr double normal_density(double x) {
  double term = 1.0;
  double sum = 1.0;  // exp(-x^2 / 64) from its series, then to the power of 32
  for (int k = 1; k < 12; ++k) {
    term *= -x * x / 64.0 / k;
    sum += term;
  }
  for (int k = 0; k < 5; ++k) sum *= sum;
  return 0.3989422804014327 * sum;
}

consteval std::array<Entry, entries> make_table() {
  std::array<Entry, entries> table{};
  constexpr int parts = 8;
  constexpr double part = 1.0 / (steps * parts);
  double distribution = 3.167e-5;  // Phi(-4)
  for (std::size_t i = 0; i < entries; ++i) {
    const double x = static_cast<double>(i) / steps - reach;
    table[i] = {normal_density(x), distribution};
    for (int k = 0; k < parts; ++k) distribution += part * normal_density(x + (k + 0.5) * part);
  }
  return table;
}

inline constexpr std::array<Entry, entries> table = make_table();

[[nodiscard]] inline Entry normal(double x) {
  if (!(x > -reach)) return {0.0, 0.0};
  if (x >= reach) return {0.0, 1.0};
  const double position = (x + reach) * steps;
  const auto i = static_cast<std::size_t>(position);
  const double f = position - static_cast<double>(i);
  const Entry& a = table[i];
  const Entry& b = table[i + 1];
  return {a.density + f * (b.density - a.density), a.distribution + f * (b.distribution - a.distribution)};
}

}  // namespace profile

[[nodiscard]] inline SpotProfile spot_profile(double r, double half_width, double inverse_s) {
  const profile::Entry near = profile::normal((half_width - r) * inverse_s);
  const profile::Entry far = profile::normal((-half_width - r) * inverse_s);
  return {near.distribution - far.distribution, (far.density - near.density) * inverse_s,
          (near.density + far.density) * inverse_s};
}

}  // namespace relnav::vision
