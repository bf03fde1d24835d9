#include "hil/scenarios/stereo_scenarios.hpp"

#include "hil/evaluate/rotation.hpp"
#include "hil/scenarios/targets.hpp"

namespace relnav::hil {
namespace {

constexpr std::int32_t width_px = 4256;
constexpr std::int32_t height_px = 2832;
constexpr double fu = 35.0 / 36.0 * width_px;
constexpr double fv = 35.0 / 23.9 * height_px;

Scenario empty_scenario() {
  Scenario scenario;
  const CameraCalibration left = forward_camera(fu, fv, width_px, height_px);
  CameraCalibration right = left;
  right.T_BC(1, 3) = stereo_baseline_m;  // x_C = +Y_B
  scenario.cameras = {left, right};
  for (CameraCalibration& camera : scenario.cameras) camera.rate_hz = 1.0;
  scenario.target = square_target(stereo_half_diagonal_m);
  return scenario;
}

/// Adds epochs one second apart.
class Sweep {
 public:
  Sweep(Scenario& scenario, std::uint64_t seed)
      : scenario_(scenario), recorder_(scenario, seed), all_(all_features(scenario.target)) {}

  void add(double range_m, const Vec3& phi_C, double sigma_px, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const Time time{static_cast<std::int64_t>(scenario_.truth.size()) * 1'000'000'000};
      recorder_.add({time, Vec3(0.5 * stereo_baseline_m, 0.0, range_m), rotation_exp(phi_C)}, all_, sigma_px);
    }
  }

 private:
  Scenario& scenario_;
  ScenarioRecorder recorder_;
  std::vector<std::size_t> all_;
};

}  // namespace

Scenario stereo_noise_scenario(const ScenarioOptions& options) {
  Scenario scenario = empty_scenario();
  Sweep sweep(scenario, options.seed);
  for (int step = 0; step <= stereo_noise_steps; ++step) {
    sweep.add(stereo_range_m, Vec3::Zero(), options.sigma_px * step / stereo_noise_steps,
              options.count == 0 ? 200 : options.count);
  }
  return scenario;
}

Scenario stereo_pose_scenario(const ScenarioOptions& options) {
  Scenario scenario = empty_scenario();
  Sweep sweep(scenario, options.seed);
  const std::size_t count = options.count == 0 ? 50 : options.count;
  for (int axis = 0; axis < 3; ++axis) {
    for (int angle_deg = -40; angle_deg <= 40; angle_deg += 5) {
      sweep.add(stereo_range_m, Vec3(Vec3::Unit(axis) * (angle_deg / degrees_per_radian)), options.sigma_px, count);
    }
  }
  for (int half_metres = 6; half_metres <= 20; ++half_metres) {
    sweep.add(0.5 * half_metres, Vec3::Zero(), options.sigma_px, count);
  }
  return scenario;
}

}  // namespace relnav::hil
