#pragma once
#include <array>
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/estimation/marker_triples.hpp"
#include "fsw/estimation/spot_mates.hpp"
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
  int work = 0;    ///< all that was done, in three-point problems
};

/// Three spots of a camera held against every three markers that they can be, in pieces of bounded work. Keeps the hypotheses
/// with at least `least_hits` more spots of this camera within the gate; those of another one count as well.
class SpotTrial {
 public:
  using Spots = std::array<std::uint8_t, 3>;

  void begin(std::uint16_t camera, const Spots& spots, int least_hits, std::size_t keep);
  /// Of the first camera of two: by their mates the spots bound the distances of the markers.
  void begin_mated(const SpotMates& mates, const Spots& spots, std::size_t keep);
  /// Goes on until effort.work reaches `limit`. True: done.
  [[nodiscard]] bool advance(const SpotScene& scene, const MarkerTriples& triples, int limit, SearchEffort& effort);
  void abandon() { is_open_ = false; }
  [[nodiscard]] bool is_open() const { return is_open_; }
  [[nodiscard]] const SpotHypotheses& best() const { return best_; }

 private:
  [[nodiscard]] bool can_be(const MarkerTriples::Triple& triple, const Spots& order) const;
  void solve(const SpotScene& scene, const MarkerTriples::Triple& triple, const std::array<Vec3, 3>& rays,
             SearchEffort& effort);

  SpotHypotheses best_;
  Spots spots_{};
  std::array<SpotMates::Span, 3> distance_{};  ///< of spots 0-1, 0-2, 1-2
  std::size_t order_ = 0;                      ///< where advance() goes on
  std::size_t triple_ = 0;                     ///<
  int least_hits_ = 0;
  std::uint16_t camera_ = 0;
  bool is_open_ = false;
};

}  // namespace relnav
