#include "platform/files/camera_rig_file.hpp"

#include <Eigen/Geometry>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav {
namespace {

constexpr double least_baseline_m = 1e-6;

const char* model_name(DistortionModel model) {
  switch (model) {
    case DistortionModel::none: return "none";
    case DistortionModel::radial_tangential: return "radial-tangential";
    case DistortionModel::radial_inverse: return "radial-inverse";
    case DistortionModel::equidistant: return "equidistant";
  }
  return "unknown";
}

std::string list_text(const double* values, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + format_text("%.17g", values[i]);
  return text + "]";
}

/// Files carry few digits: the rotation nearest to what is written.
Mat3 rotation_of(const CameraCalibration& camera) {
  return Eigen::Quaterniond(Mat3(camera.T_BC.topLeftCorner<3, 3>())).normalized().toRotationMatrix();
}

}  // namespace

CameraRig camera_rig_of(const std::vector<CameraCalibration>& cameras, const std::vector<std::string>& names) {
  CameraRig rig;
  if (cameras.empty()) throw InputError("--camera", 0, "no camera", "at least one camera file");
  const Mat3 R_BC0 = rotation_of(cameras[0]);
  const Vec3 t_BC0 = cameras[0].T_BC.topRightCorner<3, 1>();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto model = CameraModel::create(cameras[i].intrinsics);
    if (!model) throw InputError(names[i], 0, "no camera model can be made of it", "a plausible calibration");
    RigCamera camera;
    camera.model = model.value();
    if (i > 0) {
      const Mat3 R_KB = rotation_of(cameras[i]).transpose();
      camera.R_KC = R_KB * R_BC0;
      camera.t_KC = R_KB * (t_BC0 - Vec3(cameras[i].T_BC.topRightCorner<3, 1>()));
    }
    if (rig.push_back(camera) != Status::ok)
      throw InputError(names[i], 0, "too many cameras", "at most " + std::to_string(config::max_cameras));
    if (i > 0 && !(camera.t_KC.norm() > least_baseline_m))
      throw InputError(names[i], 0, "stands where " + names[0] + " does", "T_BS of each camera, in both files");
  }
  return rig;
}

CameraRig read_camera_rig(const std::vector<std::string>& paths) {
  std::vector<CameraCalibration> cameras;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    cameras.push_back(read_camera_file(paths[i], static_cast<int>(i)));
  }
  return camera_rig_of(cameras, paths);
}

std::string camera_file_text(const CameraCalibration& camera) {
  const CameraIntrinsics& c = camera.intrinsics;
  const double pinhole[] = {c.fu, c.fv, c.cu, c.cv};
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T_BC = camera.T_BC;
  std::string text = "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: " + list_text(T_BC.data(), 16) + "\n";
  if (camera.rate_hz > 0.0) text += format_text("rate_hz: %.17g\n", camera.rate_hz);
  text += format_text("resolution: [%d, %d]\n", c.width_px, c.height_px) +
          "camera_model: pinhole\nintrinsics: " + list_text(pinhole, 4) +
          "  # fu, fv, cu, cv\ndistortion_model: " + model_name(c.model) + "\n";
  const std::size_t coefficients = c.model == DistortionModel::none             ? 0
                                   : c.model == DistortionModel::radial_inverse ? 2
                                                                                : 4;
  return text + "distortion_coefficients: " + list_text(c.coefficients.data(), coefficients) + "\n";
}

}  // namespace relnav
