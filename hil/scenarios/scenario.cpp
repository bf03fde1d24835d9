#include "hil/scenarios/scenario.hpp"

#include <filesystem>

#include "hil/replay/output_file.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/target_file.hpp"

namespace relnav::hil {
namespace {

std::string camera_file_name(std::size_t index) { return "cam" + std::to_string(index) + ".yaml"; }

std::vector<std::string> camera_file_names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) names.push_back(camera_file_name(i));
  return names;
}

}  // namespace

ScenarioRecorder::ScenarioRecorder(Scenario& scenario, std::uint64_t seed)
    : scenario_(scenario),
      rig_(camera_rig_of(scenario.cameras, camera_file_names(scenario.cameras.size()))),
      noise_(seed) {}

bool ScenarioRecorder::see(const TimedPose& pose, std::size_t camera, std::size_t feature, Vec2& uv_px) const {
  const RigCamera& c = rig_[camera];
  const Vec3 p_C0 = pose.R_CT * scenario_.target.features[feature].p_T + pose.t_CT;
  return c.model.project(Vec3(c.R_KC * p_C0 + c.t_KC), uv_px) == Status::ok;
}

void ScenarioRecorder::add(const TimedPose& pose, const std::vector<std::size_t>& features, double sigma_px) {
  ObservationEpoch epoch{pose.time, {}};
  for (std::size_t camera = 0; camera < rig_.size(); ++camera) {
    for (const std::size_t feature : features) {
      Vec2 uv_px;
      if (!see(pose, camera, feature, uv_px) || !rig_[camera].model.in_image(uv_px)) continue;
      const double du = noise_.next();
      const double dv = noise_.next();
      uv_px += sigma_px * Vec2(du, dv);
      if (!rig_[camera].model.in_image(uv_px)) continue;
      epoch.rows.push_back({static_cast<int>(camera), scenario_.target.features[feature].id, uv_px,
                            sigma_px > 0.0 ? sigma_px : noise_free_sigma_px, 0});
    }
  }
  scenario_.truth.push_back(pose);
  if (!epoch.rows.empty()) scenario_.observations.push_back(epoch);
}

bool ScenarioRecorder::all_in_image(const TimedPose& pose, double border_px) const {
  for (std::size_t camera = 0; camera < rig_.size(); ++camera) {
    for (std::size_t feature = 0; feature < scenario_.target.features.size(); ++feature) {
      Vec2 uv_px;
      if (!see(pose, camera, feature, uv_px) || !rig_[camera].model.in_image(uv_px, border_px)) return false;
    }
  }
  return true;
}

void write_scenario(const Scenario& scenario, const std::string& folder) {
  for (std::size_t i = 0; i < config::max_cameras; ++i) {
    const std::string path = folder + "/" + camera_file_name(i);
    if (i < scenario.cameras.size()) {
      OutputFile(path).write(camera_file_text(scenario.cameras[i]));
    } else {
      std::error_code error;
      std::filesystem::remove(path, error);
      if (error) throw InputError(path, 0, "cannot be removed: " + error.message(), "a writable output folder");
    }
  }
  OutputFile(folder + "/target.yaml").write(target_file_text(scenario.target));
  std::string text = std::string(observation_header) + "\n";
  for (const ObservationEpoch& epoch : scenario.observations) {
    for (const ObservationRow& row : epoch.rows) text += observation_line(epoch.time, row) + "\n";
  }
  OutputFile(folder + "/observations.csv").write(text);
  text = std::string(trajectory_header) + "\n";
  for (const TimedPose& pose : scenario.truth) text += trajectory_line(pose) + "\n";
  OutputFile(folder + "/truth.tum").write(text);
}

CameraCalibration forward_camera(double fu, double fv, std::int32_t width_px, std::int32_t height_px) {
  CameraCalibration camera;
  camera.intrinsics.fu = fu;
  camera.intrinsics.fv = fv;
  camera.intrinsics.cu = 0.5 * (width_px - 1);
  camera.intrinsics.cv = 0.5 * (height_px - 1);
  camera.intrinsics.width_px = width_px;
  camera.intrinsics.height_px = height_px;
  camera.T_BC.topLeftCorner<3, 3>() << 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  return camera;
}

}  // namespace relnav::hil
