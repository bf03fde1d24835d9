#pragma once
#include <array>
#include <vector>

#include "fsw/estimation/noncoop_filter.hpp"
#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/pose_observation.hpp"
#include "fsw/geometry/target_model.hpp"
#include "hil/scenarios/gaussian.hpp"
#include "hil/simulation/scenario_file.hpp"
#include "hil/simulation/scene_state.hpp"

namespace relnav::hil {

/// A point that can be tracked on the surface of an unknown target.
struct SurfacePoint {
  Vec3 p_T = Vec3::Zero();
  Vec3 normal_T = Vec3::Zero();
};

/// Points evenly over the faces of a box, their height off the face scattered by 15 % as foil and boxes do.
[[nodiscard]] std::vector<SurfacePoint> surface_points(const FeatureSettings& settings, std::uint64_t seed);

/// What an ideal front end would find of an unknown target: points in sight, with noise, outliers and misses.
class SurfaceSensor {
 public:
  SurfaceSensor(const FeatureSettings& settings, const CameraModel& camera, std::uint64_t seed);

  /// Starts the filter at what is in sight. too_few_features: fewer than `least`.
  Status start(NoncoopFilter& filter, Time time, const SceneState& truth, std::size_t least);
  /// The features that the filter expects, where they are.
  void measure(const FeaturePredictions& predictions, const SceneState& truth, FeatureMatches& matches);
  /// New features, up to as many as the settings want at a time.
  void add_features(NoncoopFilter& filter, const SceneState& truth);
  void forget(SlotHandle slot);

 private:
  struct Entry {
    SlotHandle slot;
    int point = -1;
  };
  [[nodiscard]] bool see(std::size_t point, const SceneState& truth, Vec2& uv_px) const;
  [[nodiscard]] bool in_use(std::size_t point) const;
  Vec2 noise(double sigma_px);

  FeatureSettings settings_;
  CameraModel camera_;
  std::vector<SurfacePoint> points_;
  std::array<Entry, config::max_features> point_of_{};
  Gaussian random_;
};

/// What an ideal front end would find of the lights of a known target: identified, with noise, outliers and misses.
class LightSensor {
 public:
  LightSensor(const FeatureSettings& settings, const CameraRig& rig, const TargetModel& target, std::uint64_t seed);
  /// `truth`: as the rig's first camera sees it.
  [[nodiscard]] PoseObservations observe(const SceneState& truth);

 private:
  FeatureSettings settings_;
  CameraRig rig_;
  TargetModel target_;
  Gaussian random_;
};

}  // namespace relnav::hil
