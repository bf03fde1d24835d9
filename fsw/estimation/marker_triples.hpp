#pragma once
#include <array>
#include <cstdint>

#include "fsw/geometry/p3p.hpp"
#include "fsw/geometry/target_model.hpp"

namespace relnav {

/// Markers that a search without identities can handle.
inline constexpr std::size_t max_search_markers = 16;

/// All triples of a target's markers that can found a hypothesis: not on a line, and not on faces that exclude each other.
class MarkerTriples {
 public:
  struct Triple {
    std::array<std::uint8_t, 3> marker{};
    P3pPoints points;
    /// Sign of det [ray1 ray2 ray3] whenever all three faces are seen; 0: either.
    int orientation = 0;
  };

  /// invalid_argument: more than max_search_markers, or a value that is not finite; too_few_features: fewer than 4;
  /// rank_deficient: no triple is left.
  Status build(const TargetModel& target);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const Triple& operator[](std::size_t i) const { return triples_[i]; }

 private:
  static constexpr std::size_t capacity = max_search_markers * (max_search_markers - 1) * (max_search_markers - 2) / 6;
  std::array<Triple, capacity> triples_{};
  std::size_t size_ = 0;
};

}  // namespace relnav
