#include "fsw/estimation/spot_triples.hpp"

#include <utility>

namespace relnav {
namespace {

/// The second of a pair of neighbours and the first: (1,0) (2,0) (2,1) (3,0) ...
constexpr std::array<std::array<std::uint8_t, 2>, 15> pair_order{{{0, 1},
                                                                  {0, 2},
                                                                  {1, 2},
                                                                  {0, 3},
                                                                  {1, 3},
                                                                  {2, 3},
                                                                  {0, 4},
                                                                  {1, 4},
                                                                  {2, 4},
                                                                  {3, 4},
                                                                  {0, 5},
                                                                  {1, 5},
                                                                  {2, 5},
                                                                  {3, 5},
                                                                  {4, 5}}};
constexpr double far_away = 1e9;

}  // namespace

void SpotTriples::build(const SpotField& field, SpotField::Mask which, double least_separation_rad) {
  least_chord2_ = least_separation_rad * least_separation_rad;
  count_ = 0;
  for (std::size_t i = 0; i < config::max_spots; ++i) {
    if ((which >> i & 1U) == 0) continue;
    rays_[count_] = field.ray(i);
    spot_[count_++] = static_cast<std::uint8_t>(i);
  }
  a_ = 0;
  b_ = 1;
  c_ = 2;
  pair_ = 0;
  centre_ = 0;
  steps_ = 0;
  // The nearest six of each that are not too near, nearest first.
  std::array<double, config::max_spots> reach{};
  for (std::size_t i = 0; i < count_; ++i) {
    std::array<double, neighbours> distance;
    distance.fill(far_away);
    near_[i].fill(static_cast<std::uint8_t>(i));
    for (std::size_t j = 0; j < count_; ++j) {
      double d = (rays_[i] - rays_[j]).squaredNorm();
      if (j == i || d < least_chord2_) continue;
      auto candidate = static_cast<std::uint8_t>(j);
      for (std::size_t k = 0; k < neighbours; ++k) {
        if (!(d < distance[k])) continue;
        std::swap(d, distance[k]);
        std::swap(candidate, near_[i][k]);
      }
    }
    reach[i] = distance[3];
    dense_[i] = static_cast<std::uint8_t>(i);
    for (std::size_t k = i; k > 0 && reach[dense_[k]] < reach[dense_[k - 1]]; --k) std::swap(dense_[k], dense_[k - 1]);
  }
}

void SpotTriples::skip(int count) {
  Triple unused;
  for (int k = 0; k < count; ++k) {
    if (!next(unused)) return;
  }
}

bool SpotTriples::is_wide(const Triple& t) const {
  if (t[0] == t[1] || t[0] == t[2] || t[1] == t[2]) return false;
  return (rays_[t[0]] - rays_[t[1]]).squaredNorm() >= least_chord2_ &&
         (rays_[t[0]] - rays_[t[2]]).squaredNorm() >= least_chord2_ &&
         (rays_[t[1]] - rays_[t[2]]).squaredNorm() >= least_chord2_;
}

bool SpotTriples::strongest(Triple& out) {
  while (c_ < count_) {  // bound: the triples of the spots
    out = {static_cast<std::uint8_t>(a_), static_cast<std::uint8_t>(b_), static_cast<std::uint8_t>(c_)};
    if (++a_ == b_) {
      a_ = 0;
      if (++b_ == c_) {
        b_ = 1;
        ++c_;
      }
    }
    if (is_wide(out)) return true;
  }
  return false;
}

bool SpotTriples::neighbouring(Triple& out) {
  while (pair_ < pairs && count_ >= 3) {  // bound: pairs times the spots
    const std::size_t centre = dense_[centre_];
    out = {static_cast<std::uint8_t>(centre), near_[centre][pair_order[pair_][0]], near_[centre][pair_order[pair_][1]]};
    if (++centre_ == count_) {
      centre_ = 0;
      ++pair_;
    }
    if (is_wide(out)) return true;
  }
  return false;
}

bool SpotTriples::next(Triple& out) {
  Triple t{};
  const bool found = steps_ % 2 == 0 ? (strongest(t) || neighbouring(t)) : (neighbouring(t) || strongest(t));
  if (!found) return false;
  ++steps_;
  out = {spot_[t[0]], spot_[t[1]], spot_[t[2]]};
  return true;
}

}  // namespace relnav
