#pragma once
#include <cstddef>

/// Every capacity and budget of the flight software. Each can be overridden when configuring (-DRELNAV_...=N).
#ifndef RELNAV_MAX_FEATURES
#define RELNAV_MAX_FEATURES 60
#endif
#ifndef RELNAV_MAX_IMAGE_WIDTH
#define RELNAV_MAX_IMAGE_WIDTH 1024
#endif
#ifndef RELNAV_MAX_IMAGE_HEIGHT
#define RELNAV_MAX_IMAGE_HEIGHT 1024
#endif

namespace relnav::config {

inline constexpr std::size_t max_features = RELNAV_MAX_FEATURES;          ///< feature slots of the filter
inline constexpr std::size_t max_image_width = RELNAV_MAX_IMAGE_WIDTH;    ///< pixels
inline constexpr std::size_t max_image_height = RELNAV_MAX_IMAGE_HEIGHT;  ///< pixels
inline constexpr std::size_t motion_states = 12;                          ///< position, attitude, velocity, rate
inline constexpr std::size_t max_feature_states = 6;                      ///< inverse depth; 3 once Euclidean
inline constexpr std::size_t max_states = motion_states + max_features * max_feature_states;
inline constexpr std::size_t max_measurement_rows = 2 * max_features;
inline constexpr std::size_t max_cameras = 2;
inline constexpr std::size_t max_target_features = 64;  ///< of a cooperative target
inline constexpr std::size_t max_target_lines = 64;
inline constexpr std::size_t max_spots = 64;           ///< light spots of one frame
inline constexpr std::size_t max_spot_runs = 4096;     ///< horizontal runs of bright pixels of one search
inline constexpr std::size_t max_spot_regions = 1024;  ///< connected regions of one search
inline constexpr std::size_t max_observations = max_cameras * max_target_features;

}  // namespace relnav::config
