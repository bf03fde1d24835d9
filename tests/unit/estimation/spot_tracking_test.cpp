// Which markers are expected where, and which spot is whose.
#include "fsw/estimation/spot_tracking.hpp"

#include <cmath>

#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/spot_simulation.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

ExpectedMarker marker_at(std::uint16_t feature, std::uint16_t camera, double u, double v) {
  ExpectedMarker m;
  m.feature = feature;
  m.camera = camera;
  m.uv_px = Vec2(u, v);
  m.S_px2 = Mat2::Zero();
  return m;
}

LightSpot spot_at(double u, double v, double sigma_px = 0.1) {
  LightSpot s;
  s.uv_px = Vec2(u, v);
  s.sigma_px = sigma_px;
  return s;
}

}  // namespace

TEST_GROUP(SpotTracking) {
  SpotTrackingSettings settings;
  ExpectedMarkers markers;
  RigSpots spots;
  SpotAssignment assignment;

  void expect(const ExpectedMarker& m) { CHECK(markers.push_back(m) == Status::ok); }
  void put(std::size_t camera, const LightSpot& s) { CHECK(spots[camera].push_back(s) == Status::ok); }
  void assign(Markers which = Markers::all) {
    assign_spots(markers, spots, which, settings, assignment);
    LONGS_EQUAL(static_cast<int>(assignment.observations.size()), static_cast<int>(assignment.marker.size()));
    LONGS_EQUAL(static_cast<int>(assignment.observations.size()), static_cast<int>(assignment.flux.size()));
  }
  /// Position of the observation of an expected marker, or -1.
  int observation_of(std::size_t marker) const {
    for (std::size_t i = 0; i < assignment.marker.size(); ++i) {
      if (assignment.marker[i] == marker) return static_cast<int>(i);
    }
    return -1;
  }
};

TEST(SpotTracking, markers_are_expected_at_their_projection_with_the_covariance_of_the_pose) {
  const CameraRig rig = test::two_cameras();
  const TargetModel target = test::eight_leds();
  test::SpotSimulation simulation(1);
  test::Normal rng(1);
  for (int k = 0; k < 20; ++k) {
    test::SpotScenario scenario;
    const Pose pose = simulation.pose(scenario);
    Mat6 root;
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) root(r, c) = 0.01 * rng();
    }
    const Mat6 P = root * root.transpose();
    markers.clear();
    std::size_t first = 0;
    for (std::uint16_t camera = 0; camera < 2; ++camera) {
      expect_markers(rig, target, pose, P, camera, 2.0, settings, markers);
      CHECK(markers.size() >= first + 6);
      for (std::size_t i = first; i < markers.size(); ++i) {
        const ExpectedMarker& m = markers[i];
        LONGS_EQUAL(camera, m.camera);
        const auto image = [&](const Vec6& d) {
          const Mat3 R_CT = exp_so3(Vec3(d.tail<3>())) * pose.R_CT;
          const Vec3 p_C = R_CT * target.features[m.feature].p_T + pose.t_CT + d.head<3>();
          Vec2 uv_px = Vec2::Zero();
          CHECK(rig[camera].model.project(Vec3(rig[camera].R_KC * p_C + rig[camera].t_KC), uv_px) == Status::ok);
          return uv_px;
        };
        const Vec6 zero = Vec6::Zero();
        CHECK((image(zero) - m.uv_px).norm() < 1e-9);
        const Mat<2, 6> J = test::numeric_jacobian<2, 6>(image, zero, 1e-5);
        const Mat2 S = J * P * J.transpose();
        CHECK((S - m.S_px2).norm() < 1e-5 * S.norm());
      }
      first = markers.size();
    }
  }
}

TEST(SpotTracking, faces_turned_away_are_not_expected) {
  const CameraRig rig = test::one_camera();
  const TargetModel target = test::sixteen_leds();
  const Pose pose{Mat3::Identity(), Vec3(0.0, 0.0, 8.0)};
  expect_markers(rig, target, pose, Mat6::Identity(), 0, 2.0, settings, markers);
  LONGS_EQUAL(3, static_cast<int>(markers.size()));  // those on the face -z
  for (const ExpectedMarker& m : markers) CHECK(target.features[m.feature].normal_T.z() < -0.5);

  // A face whose cosine is 0.0995 or 0.1005 at the limit of 0.1.
  for (const bool seen : {false, true}) {
    const double c = seen ? 0.1005 : 0.0995;
    const TargetModel tilted = test::target_of({Vec3::Zero()}, {Vec3(std::sqrt(1.0 - c * c), 0.0, -c)});
    markers.clear();
    expect_markers(rig, tilted, pose, Mat6::Identity(), 0, 2.0, settings, markers);
    LONGS_EQUAL(seen ? 1 : 0, static_cast<int>(markers.size()));
  }
}

TEST(SpotTracking, the_second_camera_judges_faces_from_where_it_stands) {
  CameraRig rig = test::two_cameras();
  rig[1] = {rig[0].model, Mat3::Identity(), Vec3(-4.0, 0.0, 0.0)};  // 4 m to the right
  // Normal 88 deg off the line of sight of the first camera, 64 deg off that of the second.
  const TargetModel target = test::target_of({Vec3::Zero()}, {Vec3(std::sin(1.54), 0.0, -std::cos(1.54))});
  const Pose pose{Mat3::Identity(), Vec3(0.0, 0.0, 9.0)};
  expect_markers(rig, target, pose, Mat6::Identity(), 0, 2.0, settings, markers);
  LONGS_EQUAL(0, static_cast<int>(markers.size()));
  expect_markers(rig, target, pose, Mat6::Identity(), 1, 2.0, settings, markers);
  LONGS_EQUAL(1, static_cast<int>(markers.size()));
}

TEST(SpotTracking, nothing_is_expected_outside_of_the_image_or_behind) {
  const CameraRig rig = test::one_camera();
  const TargetModel target = test::target_of({Vec3::Zero()});
  const auto count = [&](const Vec3& t_CT, double border_px) {
    markers.clear();
    expect_markers(rig, target, {Mat3::Identity(), t_CT}, Mat6::Identity(), 0, border_px, settings, markers);
    return static_cast<int>(markers.size());
  };
  LONGS_EQUAL(1, count({0.0, 0.0, 5.0}, 2.0));
  LONGS_EQUAL(0, count({0.0, 0.0, -5.0}, 2.0));
  LONGS_EQUAL(0, count({0.0, 3.5, 5.0}, 2.0));
  // 230 px below the middle, 12 px from the edge.
  Vec3 ray;
  CHECK(rig[0].model.unproject(Vec2(320.0, 467.0), ray) == Status::ok);
  LONGS_EQUAL(1, count(5.0 * ray, 2.0));
  LONGS_EQUAL(0, count(5.0 * ray, 20.0));
}

TEST(SpotTracking, the_nearest_pair_comes_first_and_each_spot_serves_once) {
  expect(marker_at(5, 0, 100.0, 100.0));
  expect(marker_at(6, 0, 102.0, 100.0));
  put(0, spot_at(101.5, 100.0));  // nearer to the second
  assign();
  LONGS_EQUAL(1, static_cast<int>(assignment.observations.size()));
  LONGS_EQUAL(6, assignment.observations[0].feature);
  LONGS_EQUAL(1, assignment.marker[0]);

  put(0, spot_at(102.4, 100.0));  // nearer still: the first spot is left to the first marker
  assign();
  LONGS_EQUAL(2, static_cast<int>(assignment.observations.size()));
  LONGS_EQUAL(1, assignment.marker[0]);
  DOUBLES_EQUAL(102.4, assignment.observations[0].uv_px(0), 0.0);
  LONGS_EQUAL(0, assignment.marker[1]);
  DOUBLES_EQUAL(101.5, assignment.observations[1].uv_px(0), 0.0);

  put(0, spot_at(101.0, 101.0));  // one too many
  assign();
  LONGS_EQUAL(2, static_cast<int>(assignment.observations.size()));
}

TEST(SpotTracking, cameras_are_kept_apart) {
  expect(marker_at(3, 0, 100.0, 100.0));
  expect(marker_at(3, 1, 200.0, 100.0));
  put(0, spot_at(200.0, 100.0));
  put(1, spot_at(100.0, 100.0));
  assign();
  LONGS_EQUAL(0, static_cast<int>(assignment.observations.size()));
  put(1, spot_at(200.5, 100.0));
  assign();
  LONGS_EQUAL(1, static_cast<int>(assignment.observations.size()));
  LONGS_EQUAL(1, assignment.observations[0].camera);
  LONGS_EQUAL(3, assignment.observations[0].feature);
}

TEST(SpotTracking, the_gate_is_that_of_prediction_floor_and_spot) {
  settings.gate_chi2 = 16.0;
  settings.floor_sigma_px = 0.6;
  const auto is_taken = [&](const Vec2& d, const Mat2& S) {
    markers.clear();
    spots[0].clear();
    ExpectedMarker m = marker_at(0, 0, 50.0, 60.0);
    m.S_px2 = S;
    expect(m);
    put(0, spot_at(50.0 + d(0), 60.0 + d(1), 0.8));
    assign();
    return observation_of(0) == 0;
  };
  const Mat2 zero = Mat2::Zero();  // floor and spot make 1 px
  CHECK(is_taken({3.99, 0.0}, zero));
  CHECK(!is_taken({4.01, 0.0}, zero));
  CHECK(is_taken({2.82, -2.82}, zero));
  CHECK(!is_taken({2.84, -2.84}, zero));
  Mat2 S;  // eigenvalues 3 + 1 along (1, 1), 0 + 1 across
  S << 1.5, 1.5, 1.5, 1.5;
  const Vec2 along(std::sqrt(0.5), std::sqrt(0.5));
  const Vec2 across(std::sqrt(0.5), -std::sqrt(0.5));
  CHECK(is_taken(7.99 * along, S));
  CHECK(!is_taken(8.01 * along, S));
  CHECK(is_taken(3.99 * across, S));
  CHECK(!is_taken(4.01 * across, S));
}

TEST(SpotTracking, a_marker_out_of_sight_leaves_its_spot_to_the_others) {
  expect(marker_at(5, 0, 100.0, 100.0));
  expect(marker_at(6, 0, 102.0, 100.0));
  markers[1].in_sight = false;
  put(0, spot_at(101.5, 100.0));  // nearer to the second
  assign(Markers::in_sight);
  LONGS_EQUAL(1, static_cast<int>(assignment.observations.size()));
  LONGS_EQUAL(5, assignment.observations[0].feature);
  assign(Markers::all);
  LONGS_EQUAL(6, assignment.observations[0].feature);
}

TEST(SpotTracking, a_spot_of_another_brightness_is_another_light) {
  settings.flux_ratio = 2.0;
  const auto is_taken = [&](double known, double flux) {
    markers.clear();
    spots[0].clear();
    expect(marker_at(0, 0, 50.0, 60.0));
    markers[0].flux = known;
    put(0, spot_at(50.1, 60.1));
    spots[0][0].flux = flux;
    assign();
    return observation_of(0) == 0;
  };
  CHECK(is_taken(3.0, 5.9));
  CHECK(!is_taken(3.0, 6.1));
  CHECK(is_taken(3.0, 1.6));
  CHECK(!is_taken(3.0, 1.4));
  CHECK(is_taken(0.0, 1.4));  // not known
  DOUBLES_EQUAL(1.4, assignment.flux[0], 0.0);
}

TEST(SpotTracking, agreement_has_the_gate_of_the_noise_alone) {
  settings.model_sigma_px = 0.03;
  settings.agreement_chi2 = 16.0;
  const auto agrees = [&](double off_px) {
    markers.clear();
    spots[0].clear();
    expect(marker_at(0, 0, 50.0, 60.0));
    markers[0].in_sight = false;  // all are looked at
    put(0, spot_at(50.0 + off_px, 60.0, 0.04));
    find_agreeing_spots(markers, spots, settings, assignment);
    return observation_of(0) == 0;
  };
  CHECK(agrees(0.199));  // 4 sigma of 0.05 px
  CHECK(!agrees(0.201));
}

TEST(SpotTracking, the_sigma_of_the_spot_is_carried_with_that_of_the_model) {
  settings.model_sigma_px = 0.03;
  expect(marker_at(0, 0, 50.0, 60.0));
  put(0, spot_at(50.1, 60.1, 0.04));
  assign();
  LONGS_EQUAL(1, static_cast<int>(assignment.observations.size()));
  DOUBLES_EQUAL(0.05, assignment.observations[0].sigma_px, 1e-12);
  assign();  // nothing is left from before
  LONGS_EQUAL(1, static_cast<int>(assignment.observations.size()));
}

}  // namespace relnav
