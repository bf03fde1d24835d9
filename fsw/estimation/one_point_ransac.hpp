#pragma once
#include <array>

#include "fsw/base/generator.hpp"
#include "fsw/estimation/ekf_update.hpp"
#include "fsw/estimation/measurement_model.hpp"

namespace relnav {

/// A match that passed its own chi-square gate, with what was predicted for it.
struct CompatibleMatch {
  std::size_t feature = 0;  ///< position in FilterState::features()
  Vec2 uv_px = Vec2::Zero();
  double sigma_px = 1.0;
};
using CompatibleMatches = BoundedVector<CompatibleMatch, config::max_features>;

struct RansacConfig {
  double confidence = 0.99;      ///< mu: chance that one hypothesis at least was an inlier
  double threshold_sigma = 2.5;  ///< a low-innovation inlier lies within this many sigma of its match
  int max_hypotheses = 24;
};

struct RansacResult {
  std::array<bool, config::max_features> inlier{};  ///< by position in the matches
  int inliers = 0;
  int hypotheses = 0;
};

/// One-point RANSAC, Liu 2017 Table 1 and eq. (23)-(25) after Civera 2010: one match updates the state (not the
/// covariance), all are predicted from it, those within the noise threshold support it. The number of hypotheses
/// n = log(1 - mu) / log(1 - p) follows p, the inlier ratio so far (the paper calls p epsilon and swaps its meaning).
/// `update` holds P H' of `innovations` (same order as `matches`). Seeded: the same input gives the same bits.
[[nodiscard]] RansacResult one_point_ransac(const RansacConfig& settings, Generator& generator,
                                            const CameraModel& camera, const MotionModel& model,
                                            const FilterState& state, const CompatibleMatches& matches,
                                            const Innovations& innovations, const EkfUpdate& update);

}  // namespace relnav
