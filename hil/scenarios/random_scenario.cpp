#include "hil/scenarios/random_scenario.hpp"

#include <Eigen/Geometry>

#include "hil/scenarios/targets.hpp"

namespace relnav::hil {
namespace {

constexpr double cube_edge_m = 2.0;
constexpr double image_border_px = 10.0;

Mat3 even_rotation(Gaussian& random) {
  for (;;) {
    const double w = random.next();
    const double x = random.next();
    const double y = random.next();
    const double z = random.next();
    const Eigen::Quaterniond q(w, x, y, z);
    if (q.norm() > 1e-3) return q.normalized().toRotationMatrix();
  }
}

Mat3 half_turn(Gaussian& random) {
  const Vec3 n = random.direction();
  return 2.0 * n * n.transpose() - Mat3::Identity();
}

Vec3 position(Gaussian& random) {
  const double range = random.uniform(6.0, 7.5);
  const double x = random.uniform(-0.1, 0.1);
  const double y = random.uniform(-0.1, 0.1);
  return {range * x, range * y, range};
}

}  // namespace

Scenario random_scenario(RandomTarget target, const ScenarioOptions& options) {
  Scenario scenario;
  scenario.cameras = {forward_camera(2000.0, 2000.0, 2048, 2048)};
  scenario.cameras[0].rate_hz = 1.0;
  scenario.target = target == RandomTarget::cube ? cube_target(cube_edge_m) : eight_point_target();
  const std::vector<std::size_t> all = all_features(scenario.target);
  ScenarioRecorder recorder(scenario, options.seed);
  Gaussian poses(~options.seed);  // other numbers than the noise
  const std::size_t count = options.count == 0 ? 10000 : options.count;
  while (scenario.truth.size() < count) {
    const std::size_t i = scenario.truth.size();
    TimedPose pose{Time{static_cast<std::int64_t>(i) * 1'000'000'000}, Vec3::Zero(), Mat3::Identity()};
    pose.R_CT = i % 4 == 3 ? half_turn(poses) : even_rotation(poses);
    pose.t_CT = position(poses);
    if (!recorder.all_in_image(pose, image_border_px)) continue;
    recorder.add(pose, target == RandomTarget::cube ? visible_cube_vertices(cube_edge_m, pose) : all, options.sigma_px);
  }
  return scenario;
}

}  // namespace relnav::hil
