#include "platform/files/camera_file.hpp"

#include <Eigen/LU>

#include <cmath>
#include <vector>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#include "platform/files/yaml_reader.hpp"

namespace relnav {
namespace {

constexpr double largest_side_px = 65535.0;

void read_intrinsics(const YamlReader& camera, CameraIntrinsics& c) {
  YAML::Node at = camera.find({"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "M1"});
  if (at) {
    const auto k = camera.numbers(at, "camera_matrix");
    if (k.size() != 9)
      camera.fail(at, "camera_matrix has " + std::to_string(k.size()) + " numbers", "9: the 3x3 matrix row by row");
    if (std::abs(k[1]) > 1e-9 || std::abs(k[3]) > 1e-9 || std::abs(k[6]) > 1e-9 || std::abs(k[7]) > 1e-9 ||
        std::abs(k[8] - 1.0) > 1e-9) {
      camera.fail(at, "camera_matrix is not of the form [fu 0 cu; 0 fv cv; 0 0 1]", "a pinhole camera without skew");
    }
    c.fu = k[0], c.cu = k[2], c.fv = k[4], c.cv = k[5];
  } else {
    at = camera.require({"intrinsics"}, "intrinsics: [fu, fv, cu, cv] in pixels");
    const auto k = camera.numbers(at, "intrinsics");
    if (k.size() != 4)
      camera.fail(at, "intrinsics has " + std::to_string(k.size()) + " numbers", "4: [fu, fv, cu, cv]");
    c.fu = k[0], c.fv = k[1], c.cu = k[2], c.cv = k[3];
  }
  if (!(c.fu > 0.0) || !(c.fv > 0.0)) {
    camera.fail(at, format_text("focal length [%g, %g]", c.fu, c.fv), "positive focal lengths in pixels");
  }
}

std::int32_t side(const YamlReader& camera, const YAML::Node& node, const std::string& what) {
  const double value = camera.number(node, what);
  if (!(value >= 1.0 && value <= largest_side_px) || value != std::floor(value)) {
    camera.fail(node, what + " is " + in_quotes(node.Scalar()), "a whole number of pixels from 1 to 65535");
  }
  return static_cast<std::int32_t>(value);
}

void read_resolution(const YamlReader& camera, CameraIntrinsics& c) {
  if (camera.has({"image_width", "image_Width", "imageWidth"})) {
    c.width_px = side(camera, camera.find({"image_width", "image_Width", "imageWidth"}), "image_width");
    c.height_px =
        side(camera, camera.require({"image_height", "image_Height", "imageHeight"}, "the image height in pixels"),
             "image_height");
    return;
  }
  const YAML::Node at = camera.require({"resolution"}, "resolution: [width, height] in pixels");
  if (!at.IsSequence() || at.size() != 2) camera.fail(at, "resolution is not a pair", "resolution: [width, height]");
  c.width_px = side(camera, at[0], "width");
  c.height_px = side(camera, at[1], "height");
}

DistortionModel distortion_model(const YamlReader& camera, const YAML::Node& at) {
  const std::string name = at.IsScalar() ? at.Scalar() : "";
  if (name == "none") return DistortionModel::none;
  if (name == "radial-tangential" || name == "radtan" || name == "plumb_bob" || name == "rational_polynomial") {
    return DistortionModel::radial_tangential;
  }
  if (name == "radial-inverse") return DistortionModel::radial_inverse;
  if (name == "equidistant" || name == "fisheye") return DistortionModel::equidistant;
  camera.fail(at, "unknown distortion model " + in_quotes(name),
              "radial-tangential (radtan, plumb_bob), radial-inverse, equidistant or none");
}

void read_distortion(const YamlReader& camera, CameraIntrinsics& c, bool model_may_be_absent) {
  if (camera.has({"distortion_model"}) || !model_may_be_absent) {
    c.model = distortion_model(
        camera, camera.require({"distortion_model"}, "radial-tangential, radial-inverse, equidistant or none"));
  } else {
    c.model = DistortionModel::radial_tangential;  // OpenCV's default
  }
  const YAML::Node at = camera.find({"distortion_coefficients", "distortion_coeffs", "Distortion_Coefficients",
                                     "dist_coeffs", "distCoeffs", "distCoeff", "D", "D1"});
  if (c.model == DistortionModel::none) return;
  if (!at) {
    static_cast<void>(camera.require({"distortion_coefficients"},
                                     c.model == DistortionModel::radial_inverse ? "[k1, k2]" : "4 numbers"));
  }
  const auto k = camera.numbers(at, "distortion_coefficients");
  const std::size_t wanted = c.model == DistortionModel::radial_inverse ? 2 : 4;
  // OpenCV and ROS append k3 and more; a model without them is the same as long as they are zero.
  const bool extra_allowed = c.model == DistortionModel::radial_tangential &&
                             (k.size() == 5 || k.size() == 8 || k.size() == 12 || k.size() == 14);
  if (k.size() != wanted && !extra_allowed) {
    camera.fail(at, "distortion_coefficients has " + std::to_string(k.size()) + " numbers",
                std::to_string(wanted) + (wanted == 2                               ? ": [k1, k2]"
                                          : c.model == DistortionModel::equidistant ? ": [k1, k2, k3, k4]"
                                                                                    : ": [k1, k2, p1, p2]"));
  }
  for (std::size_t i = wanted; i < k.size(); ++i) {
    if (std::abs(k[i]) > 0.0)
      camera.fail(at, "distortion coefficient " + std::to_string(i + 1) + format_text(" is %g", k[i]),
                  "0: only k1 k2 p1 p2 are supported");
  }
  for (std::size_t i = 0; i < wanted; ++i) c.coefficients[i] = k[i];
}

Mat<4, 4> transform(const YamlReader& camera, const YAML::Node& at, const char* key) {
  const auto values = camera.numbers(at, key);
  if (values.size() != 16)
    camera.fail(at, std::string(key) + " has " + std::to_string(values.size()) + " numbers",
                "16: a 4x4 matrix row by row");
  Mat<4, 4> T;
  for (int i = 0; i < 16; ++i) T(i / 4, i % 4) = values[static_cast<std::size_t>(i)];
  const Mat3 R = T.topLeftCorner<3, 3>();
  const bool rigid = (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0.0 &&
                     (T.row(3) - Mat<4, 4>::Identity().row(3)).cwiseAbs().maxCoeff() < 1e-9;
  if (!rigid)
    camera.fail(at, std::string(key) + " is not a rigid motion", "a rotation and a translation, last row 0 0 0 1");
  return T;
}

Mat<4, 4> inverse(const Mat<4, 4>& T) {
  Mat<4, 4> result = Mat<4, 4>::Identity();
  result.topLeftCorner<3, 3>() = T.topLeftCorner<3, 3>().transpose();
  result.topRightCorner<3, 1>() = -(T.topLeftCorner<3, 3>().transpose() * T.topRightCorner<3, 1>());
  return result;
}

}  // namespace

CameraCalibration read_camera_file(const std::string& path, int index) {
  YAML::Node root = load_yaml(path, "a camera file in YAML");
  if (!root.IsMap()) throw InputError(path, 0, "holds no keys", "a camera file in YAML (EuRoC, Kalibr, ROS or OpenCV)");
  const bool kalibr = root["cam0"].IsDefined();
  if (kalibr) {
    const std::string name = "cam" + std::to_string(index);
    if (!root[name]) throw InputError(path, 0, "missing node '" + name + "'", "a Kalibr camchain with this camera");
    root.reset(YAML::Node(root[name]));
    if (!root.IsMap()) throw InputError(path, line_of(root), "'" + name + "' holds no keys", "the keys of a camera");
  }
  const YamlReader camera(path, root);
  const bool ros_or_opencv = camera.has({"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "M1"});
  CameraCalibration c;
  const YAML::Node model =
      ros_or_opencv ? camera.find({"camera_model"}) : camera.require({"camera_model"}, "camera_model: pinhole");
  if (model && !(model.IsScalar() && model.Scalar() == "pinhole")) {
    camera.fail(model, "camera model " + in_quotes(model.IsScalar() ? model.Scalar() : "?"), "pinhole");
  }
  read_intrinsics(camera, c.intrinsics);
  read_resolution(camera, c.intrinsics);
  read_distortion(camera, c.intrinsics, ros_or_opencv);
  if (camera.has({"rate_hz"})) {
    c.rate_hz = camera.number(camera.find({"rate_hz"}), "rate_hz");
    if (!(c.rate_hz > 0.0))
      camera.fail(camera.find({"rate_hz"}), format_text("rate_hz is %g", c.rate_hz), "a positive number");
  }
  if (camera.has({"T_BS"})) {
    c.T_BC = transform(camera, camera.find({"T_BS"}), "T_BS");
  } else if (camera.has({"T_cam_imu"})) {
    c.T_BC = inverse(transform(camera, camera.find({"T_cam_imu"}), "T_cam_imu"));
  }
  return c;
}

}  // namespace relnav
