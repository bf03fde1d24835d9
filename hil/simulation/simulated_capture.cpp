#include "hil/simulation/simulated_capture.hpp"

#include <filesystem>

#include "platform/files/camera_rig_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/target_file.hpp"

namespace relnav::hil {
namespace {

std::string camera_folder(const std::string& folder, std::size_t camera) {
  return folder + "/mav0/cam" + std::to_string(camera);
}

}  // namespace

SimulatedCapture::SimulatedCapture(const std::string& folder, const SimulationScenario& scenario,
                                   const SimulationPlan& plan)
    : folder_(folder) {
  for (std::size_t c = 0; c < scenario.cameras.size(); ++c) {
    const std::string data = camera_folder(folder, c) + "/data";
    std::error_code error;
    std::filesystem::create_directories(data, error);
    if (error) throw InputError(data, 0, "cannot be created: " + error.message(), "a writable output folder");
    CameraCalibration camera = scenario.cameras[c];
    camera.rate_hz = scenario.rate_hz;
    OutputFile(camera_folder(folder, c) + "/sensor.yaml").write(camera_file_text(camera));
    lists_.push_back(std::make_unique<OutputFile>(camera_folder(folder, c) + "/data.csv"));
    lists_.back()->line("#timestamp [ns],filename");
  }
  if (!scenario.target.features.empty()) OutputFile(folder + "/target.yaml").write(target_file_text(scenario.target));
  OutputFile truth(folder + "/truth.tum");
  truth.line(trajectory_header);
  for (const TimedPose& pose : plan.truth_at_stamps) truth.line(trajectory_line(pose));
}

void SimulatedCapture::add(std::size_t camera, Time stamp, const Image& image) {
  const std::string name = std::to_string(stamp.ns) + ".png";
  write_png(camera_folder(folder_, camera) + "/data/" + name, image);
  lists_[camera]->line(std::to_string(stamp.ns) + "," + name);
}

}  // namespace relnav::hil
