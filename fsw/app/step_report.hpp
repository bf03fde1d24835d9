#pragma once
#include <array>
#include <cstdint>

#include "fsw/app/auto_exposure.hpp"
#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/config.hpp"
#include "fsw/estimation/relative_state.hpp"
#include "fsw/estimation/torn_image.hpp"
#include "fsw/telemetry/packets.hpp"

namespace relnav::app {

enum class Mode : std::uint8_t { standby = 0, acquire = 1, track = 2, lost = 3 };

[[nodiscard]] constexpr const char* to_string(Mode mode) {
  switch (mode) {
    case Mode::standby: return "STANDBY";
    case Mode::acquire: return "ACQUIRE";
    case Mode::track: return "TRACK";
    case Mode::lost: return "LOST";
  }
  return "UNKNOWN";
}

/// What became of a feature in this frame.
enum class FeatureUse : std::uint8_t {
  not_expected = 0,     ///< predicted outside the image or behind the camera: not searched for
  not_found = 1,        ///< searched for without success
  rejected = 2,         ///< found, but in contradiction to the rest (outlier)
  low_innovation = 3,   ///< inlier of the one-point RANSAC
  high_innovation = 4,  ///< inlier rescued after the first update
  added = 5,            ///< first seen in this frame
};

struct FeatureReport {
  std::uint16_t index = 0;       ///< slot
  std::uint16_t generation = 0;  ///< use of the slot
  FeatureUse use = FeatureUse::not_expected;
  bool euclidean = false;  ///< three states instead of six
  Vec2 predicted_px = Vec2::Zero();
  Vec2 measured_px = Vec2::Zero();  ///< valid for rejected, low_innovation, high_innovation, added
};

/// Time spent in the stages of one step, from the HAL clock. For people, never in telemetry (it would not repeat).
struct StageTimes {
  std::int64_t acquire_ns = 0;
  std::int64_t predict_ns = 0;
  std::int64_t match_ns = 0;
  std::int64_t update_ns = 0;
  std::int64_t detect_ns = 0;
  std::int64_t telemetry_ns = 0;
  std::int64_t total_ns = 0;
};

/// Everything one step() did, for whoever drives the loop.
struct StepReport {
  Status status = Status::no_data;  ///< ok: a frame was processed and `state` is valid
  Mode mode = Mode::standby;
  RelativeState state;
  bool processed = false;   ///< a frame went to the navigator, whatever it made of it
  bool predicted = false;   ///< no measurement of this frame went into `state`
  std::uint8_t camera = 0;  ///< the one whose frame gave stamp and feature reports
  telemetry::Estimator estimator = telemetry::Estimator::inverse_depth_ekf;  ///< that made `state`
  std::uint32_t reset_counter = 0;
  std::uint16_t features = 0;  ///< in the state
  std::uint16_t matched = 0;
  std::uint16_t inliers = 0;
  std::uint16_t refused_updates = 0;            ///< since start
  std::int32_t dropped = 0;                     ///< light spots of this frame that found no room
  std::array<Tear, config::max_cameras> tears;  ///< by camera: what showed the frame before was left out
  double test_ratio = 0.0;                      ///< normalised innovation squared / its 99 % bound
  BoundedVector<FeatureReport, config::max_features> feature_reports;
  std::array<ExposureReport, config::max_cameras> exposures;  ///< by camera
  StageTimes times;
};

}  // namespace relnav::app
