#pragma once
#include <array>
#include <cstdint>

#include "fsw/estimation/spot_field.hpp"

namespace relnav {

/// Order in which triples of a camera's spots are tried. Two sequences take turns, each of which finds what the other does
/// late: the strongest spots first (every triple of the n strongest before the n+1st takes part: Chum, Matas, "PROSAC", CVPR
/// 2005), for targets brighter than the clutter; and neighbours, those in the densest places first, for targets that are
/// small in the picture. A triple may come twice.
class SpotTriples {
 public:
  using Triple = std::array<std::uint8_t, 3>;

  /// Of the spots `which`. Those closer to each other than `least_separation_rad` found no hypothesis. At most n (n + 33) / 2 steps of n.
  void build(const SpotField& field, SpotField::Mask which, double least_separation_rad);
  /// Goes on behind the first `count` steps of both sequences.
  void skip(int count);
  /// False: all have been given.
  [[nodiscard]] bool next(Triple& out);
  /// Steps taken so far, those of triples that are too narrow included.
  [[nodiscard]] int steps() const { return steps_; }

 private:
  static constexpr std::size_t neighbours = 6;
  static constexpr std::size_t pairs = neighbours * (neighbours - 1) / 2;

  [[nodiscard]] bool strongest(Triple& out);
  [[nodiscard]] bool neighbouring(Triple& out);
  [[nodiscard]] bool is_wide(const Triple& t) const;

  std::array<Vec3, config::max_spots> rays_{};
  std::array<std::uint8_t, config::max_spots> spot_{};   ///< those present
  std::array<std::uint8_t, config::max_spots> dense_{};  ///< these, by the distance of their neighbours
  std::array<std::array<std::uint8_t, neighbours>, config::max_spots> near_{};
  std::size_t count_ = 0;
  double least_chord2_ = 0.0;
  std::size_t a_ = 0, b_ = 1, c_ = 2;  ///< next of the strongest
  std::size_t pair_ = 0, centre_ = 0;  ///< next of the neighbours
  int steps_ = 0;
};

}  // namespace relnav
