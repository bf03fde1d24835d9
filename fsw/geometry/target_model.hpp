#pragma once
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// One marker of a cooperative target.
struct TargetFeature {
  std::uint16_t id = 0;          ///< unique within the target
  Vec3 p_T = Vec3::Zero();       ///< m
  Vec3 normal_T = Vec3::Zero();  ///< of the face it sits on, outward, unit length; zero: seen from everywhere
};

/// Two features, by their position in TargetModel::features.
struct TargetLine {
  std::uint16_t from = 0;
  std::uint16_t to = 0;
};

/// What is known of a cooperative target, in its body frame T.
struct TargetModel {
  BoundedVector<TargetFeature, config::max_target_features> features;
  BoundedVector<TargetLine, config::max_target_lines> lines;  ///< for the motor solver; empty: its default
};

}  // namespace relnav
