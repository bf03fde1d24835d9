#include "platform/files/camera_file.hpp"

#include "tests/support/scratch.hpp"

using namespace relnav;
using relnav::test::message_of;
using relnav::test::replaced;
using relnav::test::Scratch;

namespace {

const std::string euroc =
    "sensor_type: camera\n"                                               // 1
    "T_BS:\n"                                                             // 2
    "  cols: 4\n"                                                         // 3
    "  rows: 4\n"                                                         // 4
    "  data: [0, -1, 0, 0.6, 1, 0, 0, 0.1, 0, 0, 1, -0.2, 0, 0, 0, 1]\n"  // 5
    "rate_hz: 10\n"                                                       // 6
    "resolution: [640, 480]\n"                                            // 7
    "camera_model: pinhole\n"                                             // 8
    "intrinsics: [663.9, 664.6, 323.8, 235.2]  # fu, fv, cu, cv\n"        // 9
    "distortion_model: radial-tangential\n"                               // 10
    "distortion_coefficients: [-0.045, 0.03, -0.0004, 0.0006]\n";         // 11

// yaml-cpp builds tables at first use and keeps them: let that happen before CppUTest watches for leaks.
const bool yaml_tables_built = [] {
  const Scratch scratch;
  std::string everything = replaced(euroc, "663.9", "[x");
  for (const std::string& text : {euroc, everything + "- 'a'\n? \"b\" : |\n c\n",
                                  "%YAML:1.0\n---\na: !!b c\nd: &e {f: .nan}\n..." + std::string("\n")}) {
    static_cast<void>(message_of([&] { static_cast<void>(read_camera_file(scratch.write("c.yaml", text))); }));
  }
  return true;
}();

void check_is_the_camera(const CameraIntrinsics& c) {
  DOUBLES_EQUAL(663.9, c.fu, 1e-12);
  DOUBLES_EQUAL(664.6, c.fv, 1e-12);
  DOUBLES_EQUAL(323.8, c.cu, 1e-12);
  DOUBLES_EQUAL(235.2, c.cv, 1e-12);
  CHECK_EQUAL(640, c.width_px);
  CHECK_EQUAL(480, c.height_px);
  CHECK(c.model == DistortionModel::radial_tangential);
  DOUBLES_EQUAL(-0.045, c.coefficients[0], 1e-12);
  DOUBLES_EQUAL(0.03, c.coefficients[1], 1e-12);
  DOUBLES_EQUAL(-0.0004, c.coefficients[2], 1e-12);
  DOUBLES_EQUAL(0.0006, c.coefficients[3], 1e-12);
}

}  // namespace

TEST_GROUP(CameraFile) {
  Scratch scratch;
  CameraCalibration read(const std::string& text, int index = 0) {
    return read_camera_file(scratch.write("cam.yaml", text), index);
  }
  std::string failure(const std::string& text, int index = 0) {
    return message_of([&] { static_cast<void>(read(text, index)); });
  }
};

TEST(CameraFile, ReadsEuroc) {
  const CameraCalibration c = read(euroc);
  check_is_the_camera(c.intrinsics);
  DOUBLES_EQUAL(10.0, c.rate_hz, 1e-12);
  DOUBLES_EQUAL(-1.0, c.T_BC(0, 1), 1e-12);
  DOUBLES_EQUAL(0.6, c.T_BC(0, 3), 1e-12);
}

TEST(CameraFile, ReadsKalibrCamchain) {
  const std::string text =
      "cam0:\n  camera_model: pinhole\n  intrinsics: [1, 2, 3, 4]\n  distortion_model: none\n  resolution: [6, 4]\n"
      "cam1:\n  camera_model: pinhole\n  intrinsics: [663.9, 664.6, 323.8, 235.2]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.045, 0.03, -0.0004, 0.0006]\n  resolution: [640, 480]\n  rostopic: /cam1\n"
      "  T_cam_imu:\n  - [0, 1, 0, -0.1]\n  - [-1, 0, 0, 0.6]\n  - [0, 0, 1, 0.2]\n  - [0, 0, 0, 1]\n";
  const CameraCalibration c = read(text, 1);
  check_is_the_camera(c.intrinsics);
  DOUBLES_EQUAL(-1.0, c.T_BC(0, 1), 1e-12);  // inverse of T_cam_imu
  DOUBLES_EQUAL(0.6, c.T_BC(0, 3), 1e-12);
  DOUBLES_EQUAL(0.1, c.T_BC(1, 3), 1e-12);
  CHECK_EQUAL(6, read(text, 0).intrinsics.width_px);
  CHECK_MESSAGE_HOLDS(failure(text, 2), "cam.yaml: missing node 'cam2'");
}

TEST(CameraFile, ReadsRosCameraInfo) {
  check_is_the_camera(
      read("image_width: 640\nimage_height: 480\ncamera_name: c\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
           "  data: [663.9, 0, 323.8, 0, 664.6, 235.2, 0, 0, 1]\ndistortion_model: plumb_bob\n"
           "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.045, 0.03, -0.0004, 0.0006, 0.0]\n")
          .intrinsics);
}

TEST(CameraFile, ReadsOpencvFileStorage) {
  check_is_the_camera(read("%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   "
                           "rows: 3\n   cols: 3\n   dt: d\n"
                           "   data: [ 6.6390000000000000e+02, 0., 323.8, 0., 664.6, 235.2, 0., 0., 1. ]\n"
                           "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
                           "   data: [ -4.5e-02, 3.0e-02, -0.0004, 0.0006, 0. ]\n")
                          .intrinsics);
}

TEST(CameraFile, ReadsEveryDistortionModel) {
  const auto with = [&](const std::string& model, const std::string& numbers) {
    return read(replaced(replaced(euroc, "radial-tangential", model), "[-0.045, 0.03, -0.0004, 0.0006]", numbers))
        .intrinsics.model;
  };
  CHECK(with("radial-inverse", "[-0.1, 0.17]") == DistortionModel::radial_inverse);
  CHECK(with("equidistant", "[0.1, 0.2, 0.3, 0.4]") == DistortionModel::equidistant);
  CHECK(with("none", "[]") == DistortionModel::none);
}

TEST(CameraFile, EachMissingKeyIsNamed) {
  for (const char* key : {"resolution", "camera_model", "intrinsics", "distortion_model", "distortion_coefficients"}) {
    const std::string message = failure(replaced(euroc, std::string("\n") + key, "\nx_key"));
    CHECK_MESSAGE_HOLDS(message, "cam.yaml: missing key '" + std::string(key) + "' (expected ");
  }
}

TEST(CameraFile, BadFocalLengthIsNamedWithItsLine) {
  const auto with = [&](const std::string& fu) { return failure(replaced(euroc, "663.9", fu)); };
  CHECK_MESSAGE_HOLDS(with("-663.9"), "cam.yaml:9: focal length [-663.9, 664.6] (expected positive focal lengths");
  CHECK_MESSAGE_HOLDS(with("0"), "cam.yaml:9: focal length [0, 664.6]");
  for (const char* bad : {".nan", "nan", ".inf", "inf", "-.inf"})
    CHECK_MESSAGE_HOLDS(with(bad), "not finite (expected a finite number)");
  CHECK_MESSAGE_HOLDS(with("abc"), "cam.yaml:9: intrinsics is 'abc' (expected a finite number)");
  CHECK_MESSAGE_HOLDS(with("{a: 1}"), "cam.yaml:9: intrinsics is not a number");
}

TEST(CameraFile, WrongCountsAreNamedWithTheirLine) {
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "663.9, ", "")),
                      "cam.yaml:9: intrinsics has 3 numbers (expected 4: [fu, fv, cu, cv])");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, ", 0.0006", "")),
                      "cam.yaml:11: distortion_coefficients has 3 numbers (expected 4: [k1, k2, p1, p2])");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "0.0006]", "0.0006, 0.1]")),
                      "distortion coefficient 5 is 0.1 (expected 0");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "[640, 480]", "[640]")), "cam.yaml:7: resolution is not a pair");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "[640, 480]", "[640, 0]")),
                      "cam.yaml:7: height is '0' (expected a whole number");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "0, 0, 0, 1]", "0, 0, 0]")),
                      "cam.yaml:5: T_BS has 15 numbers (expected 16");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "data: [0, -1", "data: [0, -2")),
                      "cam.yaml:5: T_BS is not a rigid motion");
}

TEST(CameraFile, UnknownModelsAreNamed) {
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "radial-tangential", "thin-prism")),
                      "cam.yaml:10: unknown distortion model 'thin-prism' (expected radial-tangential");
  CHECK_MESSAGE_HOLDS(failure(replaced(euroc, "pinhole", "omni")),
                      "cam.yaml:8: camera model 'omni' (expected pinhole)");
}

TEST(CameraFile, WhatIsNoCameraFileIsSaid) {
  CHECK_MESSAGE_HOLDS(failure(""), "cam.yaml: holds no keys");
  CHECK_MESSAGE_HOLDS(failure("just text"), "cam.yaml: holds no keys");
  CHECK_MESSAGE_HOLDS(failure("a: [1, 2\nb: 3\n"), "not YAML");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_camera_file(scratch.path("no.yaml"))); }),
                      "no.yaml: cannot be opened");
}
