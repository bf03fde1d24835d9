#include "hil/io/observation_file.hpp"

#include "platform/files/camera_rig_file.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::replaced;
using relnav::test::Scratch;

namespace {

const std::string two_epochs =
    "# by hand\n"                                   // 1
    "t_ns,cam,feature_id,u,v,sigma\n"               // 2
    "1000000000, 0, 7, 10.5, 20.25, 0.5\n"          // 3
    "1000000000, 0, 3, 11, 21, 0.5\r\n"             // 4
    "\n"                                            // 5
    "1000000000, 1, 7, -0.5, 0, 2  # other eye\n"   // 6
    "1403636579763555527, 0, 9, 639.5, 0, +1e-1\n"  // 7
    "# end\n";                                      // 8

TargetModel some_target() {
  TargetModel target;
  for (const int id : {7, 3, 9}) {
    const TargetFeature feature{static_cast<std::uint16_t>(id), Vec3(id, id * id, 0.0), Vec3::Zero()};
    if (target.features.push_back(feature) != Status::ok) std::abort();
  }
  return target;
}

CameraCalibration some_camera(double x_m) {
  CameraCalibration camera;
  camera.intrinsics.fu = camera.intrinsics.fv = 500.0;
  camera.intrinsics.width_px = 640;
  camera.intrinsics.height_px = 480;
  camera.T_BC(0, 3) = x_m;
  return camera;
}

}  // namespace

TEST_GROUP(ObservationFile) {
  Scratch scratch;
  std::vector<ObservationEpoch> read(const std::string& text, double sigma_px = 1.0) {
    return read_observations(scratch.write("obs.csv", text), sigma_px);
  }
  std::string failure(const std::string& text) {
    return message_of([&] { static_cast<void>(read(text)); });
  }
  std::string failure_with(const std::string& from, const std::string& to) {
    return failure(replaced(two_epochs, from, to));
  }
};

TEST(ObservationFile, ReadsEpochs) {
  const auto epochs = read(two_epochs);
  CHECK_EQUAL(2U, epochs.size());
  CHECK_EQUAL(3U, epochs[0].rows.size());
  CHECK_EQUAL(1U, epochs[1].rows.size());
  CHECK(epochs[0].time.ns == 1000000000);
  CHECK(epochs[1].time.ns == 1403636579763555527);  // a double cannot hold this one
  const ObservationRow& row = epochs[0].rows[2];
  CHECK_EQUAL(1, row.cam);
  CHECK_EQUAL(7, row.feature_id);
  CHECK(row.uv_px == Vec2(-0.5, 0.0));
  DOUBLES_EQUAL(2.0, row.sigma_px, 1e-15);
  CHECK_EQUAL(6, row.line);
  DOUBLES_EQUAL(0.1, epochs[1].rows[0].sigma_px, 1e-15);
}

TEST(ObservationFile, ColumnsAreInTheOrderOfTheHeader) {
  const auto epochs = read(" v , u,feature_id,cam , t_ns\n1,2,3,4,5\n");
  CHECK(epochs[0].time.ns == 5);
  CHECK_EQUAL(4, epochs[0].rows[0].cam);
  CHECK_EQUAL(3, epochs[0].rows[0].feature_id);
  CHECK(epochs[0].rows[0].uv_px == Vec2(2.0, 1.0));
}

TEST(ObservationFile, SigmaHasADefault) {
  const std::string text = "t_ns,cam,feature_id,u,v\n1,0,0,5,5\n";
  DOUBLES_EQUAL(1.0, read(text)[0].rows[0].sigma_px, 0.0);
  DOUBLES_EQUAL(0.3, read(text, 0.3)[0].rows[0].sigma_px, 0.0);
}

TEST(ObservationFile, ReadsBackWhatIsWritten) {
  const ObservationRow row{1, 513, Vec2(12.345678, -0.25), 0.125, 0};
  const auto epochs =
      read(std::string(observation_header) + "\n" + observation_line(Time{1403636579763555527}, row) + "\n");
  CHECK(epochs[0].time.ns == 1403636579763555527);
  CHECK_EQUAL(1, epochs[0].rows[0].cam);
  CHECK_EQUAL(513, epochs[0].rows[0].feature_id);
  DOUBLES_EQUAL(0.0, (epochs[0].rows[0].uv_px - row.uv_px).norm(), 1e-12);
  DOUBLES_EQUAL(0.125, epochs[0].rows[0].sigma_px, 1e-15);
}

TEST(ObservationFile, HeaderIsNeeded) {
  CHECK_MESSAGE_HOLDS(failure(""), "obs.csv: is empty (expected the header line t_ns,cam,feature_id,u,v and");
  CHECK_MESSAGE_HOLDS(failure("# only this\n"), "obs.csv: is empty");
  CHECK_MESSAGE_HOLDS(failure("1,0,3,4,5\n"), "obs.csv:1: '1' is no column (expected the header line t_ns,cam,feat");
  CHECK_MESSAGE_HOLDS(failure_with(",sigma", ",sigmas"), "obs.csv:2: 'sigmas' is no column (expected the header");
  CHECK_MESSAGE_HOLDS(failure_with(",sigma", ",cam"), "obs.csv:2: column 'cam' twice (expected the header line");
  CHECK_MESSAGE_HOLDS(failure_with(",feature_id", ""), "obs.csv:2: no column 'feature_id' (expected the header");
  CHECK_MESSAGE_HOLDS(failure("t_ns,cam,feature_id,u,v\n"), "obs.csv: holds no observation (expected rows below");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_observations(scratch.path("no.csv"))); }),
                      "no.csv: cannot be opened");
}

TEST(ObservationFile, BadValuesAreNamedWithTheirLine) {
  CHECK_MESSAGE_HOLDS(failure_with(", 20.25, 0.5", ", 20.25"), "obs.csv:3: 5 columns (expected 6 as in the header)");
  CHECK_MESSAGE_HOLDS(failure_with("1000000000, 0, 7", "1e9, 0, 7"),
                      "obs.csv:3: t_ns is '1e9' (expected integer nanoseconds)");
  CHECK_MESSAGE_HOLDS(failure_with("0, 0, 7", "0, -1, 7"), "obs.csv:3: cam is '-1' (expected a camera number from 0)");
  CHECK_MESSAGE_HOLDS(failure_with("0, 0, 7", "0, 0, 65536"),
                      "obs.csv:3: feature_id is '65536' (expected a whole number from 0 to 65535)");
  CHECK_MESSAGE_HOLDS(failure_with("10.5", "nan"), "obs.csv:3: u is 'nan' (expected a finite number)");
  CHECK_MESSAGE_HOLDS(failure_with("20.25", "inf"), "obs.csv:3: v is 'inf' (expected a finite number)");
  CHECK_MESSAGE_HOLDS(failure_with("20.25", ""), "obs.csv:3: v is '' (expected a finite number)");
  CHECK_MESSAGE_HOLDS(failure_with("20.25, 0.5", "20.25, 0"),
                      "obs.csv:3: sigma is '0' (expected a positive number of pixels)");
  CHECK_MESSAGE_HOLDS(failure_with("20.25, 0.5", "20.25, -1"), "obs.csv:3: sigma is '-1'");
  CHECK_MESSAGE_HOLDS(failure_with("20.25, 0.5", "20.25, nan"), "obs.csv:3: sigma is 'nan' (expected a finite");
}

TEST(ObservationFile, TimeMustNotGoBack) {
  CHECK_MESSAGE_HOLDS(failure_with("1403636579763555527", "999999999"),
                      "obs.csv:7: time 999999999 after 1000000000 (expected rows sorted by time)");
}

TEST(ObservationFile, AFeatureIsSeenOnceACameraAndEpoch) {
  CHECK_MESSAGE_HOLDS(failure_with("0, 0, 3, 11", "0, 0, 7, 11"),
                      "obs.csv:4: feature 7 again in camera 0, first in line 3 (expected each feature once a camera");
  CHECK_EQUAL(2U, read(replaced(two_epochs, "527, 0, 9", "527, 0, 7")).size());  // another epoch
}

TEST_GROUP(PoseObservationsOfRows) {
  Scratch scratch;
  std::string path;
  TargetModel target = some_target();
  CameraRig rig = camera_rig_of({some_camera(0.0), some_camera(0.5)}, {"a.yaml", "b.yaml"});
  std::vector<ObservationEpoch> read(const std::string& text) {
    path = scratch.write("obs.csv", text);
    return read_observations(path);
  }
  std::string failure_with(const std::string& from, const std::string& to) {
    const auto epochs = read(replaced(two_epochs, from, to));
    return message_of([&] { check_observations(path, epochs, target, rig); });
  }
};

TEST(PoseObservationsOfRows, CarryPositionsInModelAndRig) {
  const auto epochs = read(two_epochs);
  const PoseObservations observations = pose_observations(path, epochs[0], target, rig);
  CHECK_EQUAL(3U, observations.size());
  CHECK_EQUAL(1, observations[1].feature);  // id 3
  CHECK_EQUAL(0, observations[2].feature);  // id 7
  CHECK_EQUAL(1, observations[2].camera);
  CHECK(observations[1].uv_px == Vec2(11.0, 21.0));
  DOUBLES_EQUAL(2.0, observations[2].sigma_px, 1e-15);
  check_observations(path, epochs, target, rig);
}

TEST(PoseObservationsOfRows, UnknownFeatureIsNamed) {
  CHECK_MESSAGE_HOLDS(failure_with("527, 0, 9", "527, 0, 8"),
                      "obs.csv:7: feature 8 is not in the target model (expected ids of the target file)");
}

TEST(PoseObservationsOfRows, CameraWithoutFileIsNamed) {
  CHECK_MESSAGE_HOLDS(failure_with("1000000000, 1, 7", "1000000000, 2, 7"),
                      "obs.csv:6: camera 2 has no camera file (expected cam from 0 to 1)");
  rig.truncate(1);
  CHECK_MESSAGE_HOLDS(failure_with("by", "BY"),
                      "obs.csv:6: camera 1 has no camera file (expected cam 0, or another --camera)");
}

TEST(PoseObservationsOfRows, CameraWithoutRowsIsNamed) {
  CHECK_MESSAGE_HOLDS(failure_with("1000000000, 1, 7", "1000000000, 0, 9"),
                      "obs.csv: no row of camera 1, which has a camera file (expected rows of every camera)");
}

TEST(PoseObservationsOfRows, PixelOutsideOfTheImageIsNamed) {
  CHECK_MESSAGE_HOLDS(failure_with("639.5, 0", "639.75, 0"),
                      "obs.csv:7: pixel (639.75, 0) is outside of camera 0's image (expected a pixel of 640 x 480)");
  CHECK_MESSAGE_HOLDS(failure_with("-0.5, 0, 2", "-0.6, 0, 2"), "obs.csv:6: pixel (-0.6, 0) is outside of camera 1's");
}

TEST_GROUP(CameraRigFile) { Scratch scratch; };

TEST(CameraRigFile, ReadsBackWhatIsWrittenAndPlacesTheCameras) {
  // Camera 0 looks along the body's x axis, camera 1 stands half a metre to its right and looks the same way.
  CameraCalibration first = some_camera(0.0);
  first.T_BC.topLeftCorner<3, 3>() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  first.T_BC.topRightCorner<3, 1>() = Vec3(0.1, 0.2, 0.3);
  first.intrinsics.cu = 319.5;
  first.intrinsics.model = DistortionModel::radial_tangential;
  first.intrinsics.coefficients = {-0.1, 0.01, 1e-4, -1e-4};
  first.rate_hz = 10.0;
  CameraCalibration second = first;
  second.T_BC(1, 3) += 0.5;
  const std::string a = scratch.write("a.yaml", camera_file_text(first));
  const std::string b = scratch.write("b.yaml", camera_file_text(second));
  const CameraCalibration again = read_camera_file(a);
  CHECK(again.T_BC == first.T_BC);
  CHECK(again.intrinsics.coefficients == first.intrinsics.coefficients);
  DOUBLES_EQUAL(319.5, again.intrinsics.cu, 0.0);
  DOUBLES_EQUAL(10.0, again.rate_hz, 0.0);
  const CameraRig rig = read_camera_rig({a, b});
  CHECK_EQUAL(2U, rig.size());
  DOUBLES_EQUAL(0.0, (rig[1].R_KC - Mat3::Identity()).norm(), 1e-12);
  DOUBLES_EQUAL(0.0, (rig[1].t_KC - Vec3(-0.5, 0.0, 0.0)).norm(), 1e-12);
  DOUBLES_EQUAL(0.0, rig[0].t_KC.norm(), 0.0);
}

TEST(CameraRigFile, WhatMakesNoRigIsSaid) {
  CHECK_MESSAGE_HOLDS(message_of([] { static_cast<void>(camera_rig_of({}, {})); }), "no camera (expected at least");
  const CameraCalibration c = some_camera(0.0);
  CHECK_MESSAGE_HOLDS(message_of([&] {
                        static_cast<void>(camera_rig_of({c, some_camera(0.5), c}, {"a", "b", "c.yaml"}));
                      }),
                      "c.yaml: too many cameras (expected at most 2)");
  CHECK_MESSAGE_HOLDS(message_of([] { static_cast<void>(camera_rig_of({{}}, {"a.yaml"})); }),
                      "a.yaml: no camera model can be made of it");
  CHECK_MESSAGE_HOLDS(message_of([&] {
                        static_cast<void>(camera_rig_of({c, c}, {"a.yaml", "b.yaml"}));
                      }),
                      "b.yaml: stands where a.yaml does (expected T_BS of each camera, in both files)");
}
