#include "hil/scenarios/table1_scenario.hpp"

#include <Eigen/Geometry>

#include "hil/dynamics/lvlh.hpp"
#include "hil/evaluate/rotation.hpp"
#include "hil/scenarios/targets.hpp"

namespace relnav::hil {
namespace {

constexpr double focal_length_px = 200e-3 / 7e-6;
constexpr std::int32_t side_px = 2048;
constexpr std::int64_t step_ns = 5'000'000'000;

struct Spacecraft {
  OrbitElements orbit;
  double start_rad = 0.0;           // roll, pitch and yaw alike
  Vec3 omega_B_deg = Vec3::Zero();  // per second
};

constexpr double radians(double degrees) { return degrees / degrees_per_radian; }

Spacecraft chaser() {
  return {{0.0, 0.0, radians(42.225005), 1e-7, 6721.2e3, 0.013}, radians(0.1), Vec3(1e-4, 1e-4, 1e-4)};
}
Spacecraft target() { return {{0.0, 0.0, radians(42.225), 0.0, 6721.2e3, 0.0}, radians(2.0), Vec3(1e-3, 1e-3, 0.08)}; }

Mat3 attitude_in_orbit(const Spacecraft& s, double t_s) {
  const Mat3 R_LB0 = (Eigen::AngleAxisd(s.start_rad, Vec3::UnitZ()) * Eigen::AngleAxisd(s.start_rad, Vec3::UnitY()) *
                      Eigen::AngleAxisd(s.start_rad, Vec3::UnitX()))
                         .toRotationMatrix();
  return R_LB0 * rotation_exp(Vec3(s.omega_B_deg * (t_s / degrees_per_radian)));
}

CameraCalibration camera() { return forward_camera(focal_length_px, focal_length_px, side_px, side_px); }

}  // namespace

TimedPose table1_pose(Time time) {
  const double t_s = static_cast<double>(time.ns) * 1e-9;
  const InertialState at_chaser = orbit_state(chaser().orbit, t_s);
  const InertialState at_target = orbit_state(target().orbit, t_s);
  const Mat3 R_IL_chaser = local_frame(at_chaser, Gravity::point_mass).R_AB;
  const Mat3 R_IL_target = local_frame(at_target, Gravity::point_mass).R_AB;
  const Mat3 R_CB = camera().T_BC.topLeftCorner<3, 3>().transpose();
  const Mat3 R_CI = R_CB * (R_IL_chaser * attitude_in_orbit(chaser(), t_s)).transpose();
  const Mat3 R_IT = R_IL_target * attitude_in_orbit(target(), t_s) * R_CB.transpose();
  return {time, R_CI * (at_target.r_I - at_chaser.r_I), R_CI * R_IT};
}

Scenario table1_scenario(const ScenarioOptions& options) {
  Scenario scenario;
  scenario.cameras = {camera()};
  scenario.cameras[0].rate_hz = 0.2;
  scenario.target = cube_target(table1_cube_edge_m);
  ScenarioRecorder recorder(scenario, options.seed);
  const std::size_t count = options.count == 0 ? table1_epochs : options.count;
  for (std::size_t i = 0; i < count; ++i) {
    const TimedPose pose = table1_pose(Time{static_cast<std::int64_t>(i) * step_ns});
    recorder.add(pose, visible_cube_vertices(table1_cube_edge_m, pose), options.sigma_px);
  }
  return scenario;
}

}  // namespace relnav::hil
