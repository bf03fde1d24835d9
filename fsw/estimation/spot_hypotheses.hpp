#pragma once
#include <array>
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/estimation/marker_triples.hpp"
#include "fsw/estimation/spot_scene.hpp"

namespace relnav {

/// A pose from three spots, and how many more it explains.
struct SpotHypothesis {
  Pose pose;
  int hits = 0;
  double d2 = 0.0;  ///< squared distances of the hits, in gates
};

/// The best hypotheses, best first: more hits, then smaller distances, then the earlier one.
class SpotHypotheses {
 public:
  static constexpr std::size_t capacity = 8;

  explicit SpotHypotheses(std::size_t keep = capacity) : keep_(keep) {}
  void offer(const SpotHypothesis& h);
  /// Hits that a new one needs at least to be kept.
  [[nodiscard]] int least_hits() const { return list_.size() < keep_ ? 0 : list_[keep_ - 1].hits; }
  [[nodiscard]] std::size_t size() const { return list_.size(); }
  [[nodiscard]] const SpotHypothesis& operator[](std::size_t i) const { return list_[i]; }

 private:
  std::size_t keep_;
  BoundedVector<SpotHypothesis, capacity> list_;
};

struct SearchEffort {
  int solved = 0;  ///< three-point problems
  int poses = 0;   ///< of these, poses that range, faces and prior allow: what was held against the other spots
};

/// Every way in which three spots of a camera can be three markers. Keeps those with at least `least_hits` more spots within
/// the gate, second camera included.
void try_spots(const SpotScene& scene, const MarkerTriples& triples, std::uint16_t camera,
               const std::array<std::uint8_t, 3>& spots, int least_hits, SearchEffort& effort, SpotHypotheses& best);

}  // namespace relnav
