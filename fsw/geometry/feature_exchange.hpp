#pragma once
/// What passes between vision and estimation, which do not see each other.
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/slot_pool.hpp"
#include "fsw/base/status.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// Where the filter expects a feature, and what its patch should look like there. Estimation -> vision.
struct FeaturePrediction {
  SlotHandle slot;
  Vec2 uv_px = Vec2::Zero();      ///< predicted pixel (distorted image coordinates)
  Mat2 S_px2 = Mat2::Identity();  ///< innovation covariance H P H' + R
  Mat2 warp = Mat2::Identity();   ///< current-image offset = warp * reference-patch offset, both in pixels
};

/// A patch found in the image. Vision -> estimation.
struct FeatureMatch {
  SlotHandle slot;
  Vec2 uv_px = Vec2::Zero();
  double sigma_px = 1.0;  ///< 1-sigma of each coordinate
  double score = 0.0;     ///< zero-mean normalised cross-correlation, -1..1
};

/// A corner worth a new feature. Vision -> estimation.
struct CornerCandidate {
  std::int32_t u_px = 0;
  std::int32_t v_px = 0;
  std::int32_t score = 0;  ///< larger is stronger
};

using FeaturePredictions = BoundedVector<FeaturePrediction, config::max_features>;
using FeatureMatches = BoundedVector<FeatureMatch, config::max_features>;

}  // namespace relnav
