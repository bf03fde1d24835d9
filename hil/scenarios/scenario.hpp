#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/target_model.hpp"
#include "hil/io/observation_file.hpp"
#include "hil/io/trajectory.hpp"
#include "hil/scenarios/gaussian.hpp"
#include "platform/files/camera_file.hpp"

namespace relnav::hil {

/// Input of `relnav solve` together with the truth.
struct Scenario {
  std::vector<CameraCalibration> cameras;
  TargetModel target;
  Trajectory truth;
  std::vector<ObservationEpoch> observations;
};

/// Pixel noise, seed and length of a scenario.
struct ScenarioOptions {
  double sigma_px = 1.0;  ///< of each coordinate
  std::uint64_t seed = 1;
  std::size_t count = 0;  ///< epochs, or epochs a step of a sweep
};

/// What is stated as sigma of observations without noise (a sigma is positive).
inline constexpr double noise_free_sigma_px = 0.01;

/// Adds epochs to a scenario whose cameras and target are there.
class ScenarioRecorder {
 public:
  ScenarioRecorder(Scenario& scenario, std::uint64_t seed);

  /// Notes the pose and what each camera sees of the features (positions in the model), with noise. Pixels that fall
  /// outside of the image, before or after the noise, are left out.
  void add(const TimedPose& pose, const std::vector<std::size_t>& features, double sigma_px);
  /// Every feature is inside of every image, at least border_px from its edge.
  [[nodiscard]] bool all_in_image(const TimedPose& pose, double border_px) const;

 private:
  [[nodiscard]] bool see(const TimedPose& pose, std::size_t camera, std::size_t feature, Vec2& uv_px) const;

  Scenario& scenario_;
  CameraRig rig_;
  Gaussian noise_;
};

/// Writes cam0.yaml (cam1.yaml), target.yaml, observations.csv and truth.tum into an existing folder; files of these
/// names are replaced, the cam1.yaml of another scenario is removed. Throws InputError.
void write_scenario(const Scenario& scenario, const std::string& folder);

/// A camera without distortion whose principal point is the middle of the image, in the origin of the chaser's body
/// frame, looking along +X_B: x_C = +Y_B (right), y_C = +Z_B (down), z_C = +X_B.
[[nodiscard]] CameraCalibration forward_camera(double fu, double fv, std::int32_t width_px, std::int32_t height_px);

}  // namespace relnav::hil
