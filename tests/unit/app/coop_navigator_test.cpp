// CoopNavigator on rendered light spots of a moving target: from the image to the state, with LEDs hidden, with clutter, with
// nothing to see.
#include "fsw/app/coop_navigator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "platform/host/scripted_clock.hpp"
#include "tests/unit/app/spot_motion.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::CoopNavigator;
using app::CoopNavigatorConfig;
using app::FeatureUse;
using app::StepReport;

TEST_GROUP(CoopNavigator) {
  platform::host::ScriptedClock clock;
  std::unique_ptr<CoopNavigator> navigator = std::make_unique<CoopNavigator>(clock);
  std::unique_ptr<StepReport> report = std::make_unique<StepReport>();
  test::SpotMotion scene;
  int frame = 0;

  void configure(const CameraRig& rig, const TargetModel& target, double expected_cone_rad = 0.6,
                 double filter_gate_chi2 = PoseFilterConfig().gate_chi2,
                 double image_gate_chi2 = PoseFilterConfig().image_gate_chi2) {
    scene.rig = rig;
    scene.target = target;
    CoopNavigatorConfig config;
    config.target = target;
    config.expected_cone_rad = expected_cone_rad;
    config.filter.gate_chi2 = filter_gate_chi2;
    config.filter.image_gate_chi2 = image_gate_chi2;
    CHECK_TRUE(navigator->configure(config, rig) == Status::ok);
  }
  /// Spots that are none of the target's, not too near to each other.
  [[nodiscard]] static std::vector<Vec2> clutter_of(std::size_t count) {
    Generator generator(17);
    std::vector<Vec2> clutter;
    while (clutter.size() < count) {
      const double u = 20.0 + 600.0 * generator.uniform();
      const double v = 20.0 + 440.0 * generator.uniform();
      const Vec2 uv(u, v);
      const bool near =
          std::any_of(clutter.begin(), clutter.end(), [&](const Vec2& c) { return (c - uv).norm() < 16.0; });
      if (!near) clutter.push_back(uv);
    }
    return clutter;
  }
  [[nodiscard]] Time time() const { return Time{1'000'000'000 + std::int64_t{frame} * 100'000'000}; }
  /// `blind`: a camera that gives no image.
  Status process(std::size_t blind = config::max_cameras) {
    *report = StepReport();
    std::array<app::CameraImage, config::max_cameras> views;
    for (std::size_t c = 0; c < scene.rig.size(); ++c) {
      if (c != blind) views[c] = scene.images[c].view();
    }
    return navigator->process({views.data(), scene.rig.size()}, time(), *report);
  }
  void next() {
    ++frame;
    scene.advance();
  }
  /// Each axis of the pose within 5 sigma of what is reported.
  void check_pose() {
    const RelativeState& s = report->state;
    CHECK_TRUE(s.time == time());
    Vec6 d;
    d << scene.pose.t_CT - s.t_CT, log_so3(scene.pose.R_CT * s.R_CT.transpose());
    for (int k = 0; k < 6; ++k) CHECK_TRUE(std::fabs(d(k)) < 5.0 * std::sqrt(s.pose_covariance(k, k)));
    CHECK_TRUE(d.head<3>().norm() < 0.02);  // and not because sigmas are large
    CHECK_TRUE(d.tail<3>().norm() < 0.01);
  }
  void check_rates() {
    const RelativeState& s = report->state;
    Vec6 d;
    d << scene.v_C - s.v_C, scene.omega_C - s.omega_C;
    for (int k = 0; k < 6; ++k) CHECK_TRUE(std::fabs(d(k)) < 5.0 * std::sqrt(s.rate_covariance(k, k)));
    CHECK_TRUE(d.head<3>().norm() < 0.05);
    CHECK_TRUE(d.tail<3>().norm() < 0.05);
  }
  [[nodiscard]] int count(FeatureUse use) const {
    int n = 0;
    for (const app::FeatureReport& f : report->feature_reports) n += f.use == use ? 1 : 0;
    return n;
  }
  /// From the 10th frame on, rows below `row` show the frame before, five frames in a row.
  void fly_torn_at(int row) {
    std::array<test::SpotImage, config::max_cameras> before;
    for (int k = 0; k < 25; ++k, next()) {
      scene.render();
      const auto whole = scene.images;
      const bool torn = k >= 10 && k < 15;
      for (std::size_t c = 0; c < scene.rig.size(); ++c) {
        if (torn) scene.images[c].take_rows_of(before[c], row);
      }
      before = whole;
      CHECK_TRUE(process() == Status::ok);
      for (std::size_t c = 0; c < scene.rig.size(); ++c) {
        const Tear& tear = report->tears[c];
        CHECK_TRUE(tear.exists() == torn);
        if (!torn) continue;
        LONGS_EQUAL(c, tear.camera);
        CHECK_TRUE(tear.late >= 2);
        CHECK_TRUE(tear.late_below);
        DOUBLES_EQUAL(row, tear.row_px, 60.0);
      }
      check_pose();
    }
    LONGS_EQUAL(8 * scene.rig.size(), report->inliers);
  }
  void acquire_and_track(int markers) {
    scene.render();
    CHECK_FALSE(navigator->has_started());
    CHECK_TRUE(process() == Status::ok);
    CHECK_TRUE(navigator->has_started());
    LONGS_EQUAL(markers, report->inliers);
    check_pose();
    for (int k = 0; k < 30; ++k) {
      next();
      scene.render();
      CHECK_TRUE(process() == Status::ok);
      LONGS_EQUAL(markers, report->features);
      LONGS_EQUAL(markers, report->inliers);
      LONGS_EQUAL(8, count(FeatureUse::low_innovation));
      check_pose();
      check_rates();
    }
  }
};

TEST(CoopNavigator, AcquiresInTheFirstFrameAndTracksWithOneCamera) {
  configure(test::one_camera(), test::eight_leds());
  acquire_and_track(8);
  CHECK_TRUE(report->estimator == telemetry::Estimator::mono_least_squares);
}

TEST(CoopNavigator, AcquiresInTheFirstFrameAndTracksWithTwoCameras) {
  configure(test::two_cameras(), test::eight_leds());
  acquire_and_track(16);
  CHECK_TRUE(report->estimator == telemetry::Estimator::stereo_least_squares);
}

TEST(CoopNavigator, BearsHiddenLedsAndClutter) {
  configure(test::one_camera(), test::eight_leds());
  for (int k = 0; k < 30; ++k, next()) {
    // From the 5th frame two LEDs are off, others from the 15th on; a glint beside where one of them was.
    std::vector<std::size_t> hidden;
    if (k >= 5) hidden = k < 15 ? std::vector<std::size_t>{1, 6} : std::vector<std::size_t>{0, 3};
    std::vector<Vec2> clutter;
    if (k >= 5) {
      const Vec3 p_C = scene.pose.R_CT * scene.target.features[hidden[0]].p_T + scene.pose.t_CT;
      Vec2 uv_px;
      CHECK_TRUE(scene.rig[0].model.project(p_C, uv_px) == Status::ok);
      clutter.emplace_back(uv_px + Vec2(9.0, -8.0));
    }
    scene.render(hidden, clutter);
    CHECK_TRUE(process() == Status::ok);
    // Those that come back count from the third frame on.
    const int unused = static_cast<int>(hidden.size()) + (k >= 15 && k < 18 ? 2 : 0);
    LONGS_EQUAL(8 - unused, report->inliers);
    if (k > 0) LONGS_EQUAL(unused, count(FeatureUse::not_found) + count(FeatureUse::rejected));
    for (const app::FeatureReport& f : report->feature_reports) {
      if (std::find(hidden.begin(), hidden.end(), f.index) != hidden.end()) {
        CHECK_TRUE(f.use != FeatureUse::low_innovation);
      }
    }
    check_pose();
  }
}

TEST(CoopNavigator, AGlintWhereAHiddenLedWouldBeIsNotTakenForIt) {
  // Three of the eight are hidden from the 5th frame on. From the 10th on, every second frame has a glint half a pixel off the
  // place of each: nearer than anything that five others could tell by their residuals.
  configure(test::one_camera(), test::eight_leds());
  const std::vector<std::size_t> hidden{0, 3, 6};
  for (int k = 0; k < 30; ++k, next()) {
    std::vector<Vec2> glints;
    if (k >= 10 && k % 2 == 0) {
      for (const std::size_t h : hidden) {
        Vec2 uv_px;
        const Vec3 p_C = scene.pose.R_CT * scene.target.features[h].p_T + scene.pose.t_CT;
        CHECK_TRUE(scene.rig[0].model.project(p_C, uv_px) == Status::ok);
        glints.emplace_back(uv_px + Vec2(0.4, 0.3));
      }
    }
    scene.render(k >= 5 ? hidden : std::vector<std::size_t>{}, glints);
    CHECK_TRUE(process() == Status::ok);
    LONGS_EQUAL(k >= 5 ? 5 : 8, report->inliers);
    check_pose();
  }
}

TEST(CoopNavigator, AnOutlierInTheGateIsRejected) {
  configure(test::one_camera(), test::eight_leds());
  for (int k = 0; k < 10; ++k, next()) {
    scene.render();
    CHECK_TRUE(process() == Status::ok);
  }
  Vec2 uv_px;
  const Vec3 p_C = scene.pose.R_CT * scene.target.features[2].p_T + scene.pose.t_CT;
  CHECK_TRUE(scene.rig[0].model.project(p_C, uv_px) == Status::ok);
  scene.render({2}, {uv_px + Vec2(1.5, 1.0)});
  CHECK_TRUE(process() == Status::ok);
  LONGS_EQUAL(8, report->matched);
  LONGS_EQUAL(7, report->inliers);
  LONGS_EQUAL(1, count(FeatureUse::rejected));
  check_pose();
}

TEST(CoopNavigator, OfATornImageOnlyTheNewPartIsUsed) {
  // Whichever part has more LEDs.
  for (const int row : {170, 240, 300}) {
    scene = test::SpotMotion();
    scene.v_C = Vec3(0.4, -0.3, -0.2);
    scene.omega_C = Vec3(0.1, -0.15, 0.2);
    configure(test::one_camera(), test::eight_leds());
    fly_torn_at(row);
  }
}

TEST(CoopNavigator, NorIsItWhereTheMotionIsSmallAndHardlyKnown) {
  // Half a pixel a frame, and a filter that expects anything: all spots lie in their gates, and a pose fits most of them.
  for (const int row : {240, 270, 300}) {
    scene = test::SpotMotion();
    scene.rig = test::one_camera();
    scene.target = test::eight_leds();
    scene.v_C = Vec3(0.02, 0.01, -0.6);
    scene.omega_C = Vec3(0.02, -0.03, 0.01);
    CoopNavigatorConfig config;
    config.target = scene.target;
    config.filter.noise = {50.0, 10.0};
    CHECK_TRUE(navigator->configure(config, scene.rig) == Status::ok);
    fly_torn_at(row);
  }
}

TEST(CoopNavigator, BothImagesOfAPairMayBeTornAtOnce) {
  scene.v_C = Vec3(0.4, -0.3, -0.2);
  scene.omega_C = Vec3(0.1, -0.15, 0.2);
  configure(test::two_cameras(), test::eight_leds());
  fly_torn_at(240);
}

TEST(CoopNavigator, BothMayBeTornWhereOnlyThePoseTells) {
  scene.rig = test::two_cameras();
  scene.target = test::eight_leds();
  scene.v_C = Vec3(0.02, 0.01, -0.6);
  scene.omega_C = Vec3(0.02, -0.03, 0.01);
  CoopNavigatorConfig config;
  config.target = scene.target;
  config.filter.noise = {50.0, 10.0};
  CHECK_TRUE(navigator->configure(config, scene.rig) == Status::ok);
  fly_torn_at(270);
}

TEST(CoopNavigator, WithoutSpotsTheStateIsThePredictedOne) {
  configure(test::one_camera(), test::eight_leds());
  for (int k = 0; k < 20; ++k, next()) {
    scene.render();
    CHECK_TRUE(process() == Status::ok);
  }
  double sigma = 0.0;
  for (int k = 0; k < 5; ++k, next()) {
    scene.render_nothing();
    CHECK_TRUE(process() == Status::ok);
    LONGS_EQUAL(0, report->inliers);
    LONGS_EQUAL(0, report->matched);
    LONGS_EQUAL(8, count(FeatureUse::not_found));
    CHECK_TRUE(report->state.time == time());
    CHECK_TRUE((report->state.t_CT - scene.pose.t_CT).norm() < 0.05);
    CHECK_TRUE(test::angle_between(report->state.R_CT, scene.pose.R_CT) < 0.05);
    const double grown = report->state.pose_covariance(0, 0);
    CHECK_TRUE(grown > sigma);
    sigma = grown;
  }
  scene.render();  // and when they are back, it goes on
  CHECK_TRUE(process() == Status::ok);
  LONGS_EQUAL(8, report->inliers);
  check_pose();
  navigator->restart();
  CHECK_FALSE(navigator->has_started());
}

TEST(CoopNavigator, TooFewSpotsForAPoseCorrectThePredictedOne) {
  configure(test::one_camera(), test::eight_leds());
  for (int k = 0; k < 10; ++k, next()) {
    scene.render();
    CHECK_TRUE(process() == Status::ok);
  }
  for (int k = 0; k < 15; ++k, next()) {
    scene.render({0, 1, 2, 3, 4});  // three left: by themselves up to four poses
    CHECK_TRUE(process() == Status::ok);
    LONGS_EQUAL(3, report->matched);
    LONGS_EQUAL(3, report->inliers);
    check_pose();
  }
  for (int k = 0; k < 4; ++k, next()) {
    scene.render({0, 1, 2, 3});
    CHECK_TRUE(process() == Status::ok);
    LONGS_EQUAL(k < 3 ? 3 : 4, report->inliers);
    check_pose();
  }
}

TEST(CoopNavigator, APoseTheFilterRefusesIsNotUsed) {
  configure(test::one_camera(), test::eight_leds(), 0.6, 1e-9);
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  const Vec3 t_CT = report->state.t_CT;
  next();
  scene.render();
  CHECK_TRUE(process() == Status::inconsistent);
  LONGS_EQUAL(8, report->matched);
  LONGS_EQUAL(0, report->inliers);
  LONGS_EQUAL(8, count(FeatureUse::rejected));
  CHECK_TRUE((report->state.t_CT - t_CT).norm() < 1e-12);  // at rest, as it started
}

TEST(CoopNavigator, TooFewSpotsThatDoNotFitAreNoUpdate) {
  configure(test::one_camera(), test::eight_leds(), 0.6, PoseFilterConfig().gate_chi2, 1e-9);
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  next();
  scene.render({0, 1, 2, 3, 4});
  CHECK_TRUE(process() == Status::inconsistent);
  LONGS_EQUAL(3, report->matched);
  LONGS_EQUAL(0, report->inliers);
  next();
  scene.render({0, 1, 2, 3, 4, 5, 6, 7});  // none at all is no fault of theirs
  CHECK_TRUE(process() == Status::ok);
  LONGS_EQUAL(0, report->inliers);
}

TEST(CoopNavigator, SpotsThatAreNoUpdateSayNothingAboutWhatIsInSight) {
  // A marker that is missed in two frames is out of sight, but not in frames that contradict the filter.
  configure(test::one_camera(), test::eight_leds(), 0.6, PoseFilterConfig().gate_chi2, 1e-9);
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  for (int k = 0; k < 3; ++k) {
    next();
    scene.render({0, 1, 2, 3, 4});
    CHECK_TRUE(process() == Status::inconsistent);
  }
  next();
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  LONGS_EQUAL(8, report->matched);
  LONGS_EQUAL(8, report->inliers);
}

TEST(CoopNavigator, OneCameraGoesOnWhileTheOtherIsBlind) {
  for (const std::size_t blind : {0U, 1U}) {
    configure(test::two_cameras(), test::eight_leds());
    for (int k = 0; k < 20; ++k, next()) {
      scene.render();
      const bool both = k < 5 || k >= 15;
      CHECK_TRUE(process(both ? config::max_cameras : blind) == Status::ok);
      LONGS_EQUAL(both ? 16 : 8, report->inliers);
      LONGS_EQUAL(both ? 16 : 8, report->features);
      check_pose();
    }
  }
}

TEST(CoopNavigator, AcquiresWithOneOfTwoCameras) {
  configure(test::two_cameras(), test::eight_leds());
  scene.render();
  CHECK_TRUE(process(1) == Status::ok);
  LONGS_EQUAL(8, report->inliers);
  check_pose();
}

TEST(CoopNavigator, WithoutAnyImageNothingIsFound) {
  configure(test::one_camera(), test::eight_leds());
  scene.render();
  CHECK_TRUE(process(0) == Status::too_few_features);
  CHECK_TRUE(process() == Status::ok);
  next();
  CHECK_TRUE(process(0) == Status::ok);  // predicted
  LONGS_EQUAL(0, report->features);
  LONGS_EQUAL(0, report->inliers);
}

TEST(CoopNavigator, SixteenBitsAreUsedToTheLast) {
  for (const int bits : {12, 16}) {
    CoopNavigatorConfig config;
    config.target = test::eight_leds();
    config.sensor_bits = static_cast<std::uint8_t>(bits);
    scene = test::SpotMotion();
    scene.rig = test::one_camera();
    scene.target = config.target;
    CHECK_TRUE(navigator->configure(config, scene.rig) == Status::ok);
    for (int k = 0; k < 5; ++k, next()) {
      scene.render();
      const std::vector<std::uint16_t> deep = scene.images[0].deeper(bits);
      const std::array<app::CameraImage, 1> images{
          vision::ImageView16{deep.data(), test::spot_width_px, test::spot_height_px, test::spot_width_px}};
      *report = StepReport();
      CHECK_TRUE(navigator->process(images, time(), *report) == Status::ok);
      LONGS_EQUAL(8, report->inliers);
      check_pose();
    }
  }
}

TEST(CoopNavigator, AWrongCalibrationIsAnAlarmAndNoPose) {
  configure(test::two_cameras(), test::eight_leds());
  for (int k = 0; k < 3; ++k, next()) {
    scene.render();
    CHECK_TRUE(process() == Status::ok);
  }
  // The second camera is knocked by a tenth of a degree: 1.2 px, far beyond the noise.
  scene.rig[1].R_KC = exp_so3(Vec3(0.0018, 0.0, 0.0)) * scene.rig[1].R_KC;
  for (int k = 0; k < 3; ++k, next()) {
    scene.render();
    CHECK_TRUE(process() == Status::inconsistent);
    LONGS_EQUAL(0, report->inliers);
  }
}

TEST(CoopNavigator, ASearchOfSeveralFramesIsMetAgainAndStartsAtTheTimeOfItsSpots) {
  configure(test::one_camera(), test::eight_leds());
  scene.v_C = Vec3(0.4, -0.3, -0.5);
  scene.omega_C = Vec3(0.15, -0.1, 0.2);
  const std::vector<Vec2> clutter = clutter_of(45);
  int unfinished = 0;
  for (int k = 0; k < 10; ++k, next()) {
    scene.render({}, clutter);
    const Status status = process();
    if (status == Status::ok) break;
    CHECK_TRUE(status == Status::unfinished);
    CHECK_FALSE(navigator->has_started());
    LONGS_EQUAL(0, report->inliers);
    ++unfinished;
  }
  CHECK_TRUE(navigator->has_started());
  CHECK_TRUE_TEXT(unfinished >= 2, "the case is too easy to show anything");
  CHECK_TRUE(report->inliers >= 4);  // windows are wide, and some of the clutter lies in them
  check_pose();
  next();
  scene.render({}, clutter);
  CHECK_TRUE(process() == Status::ok);
  check_pose();
  check_rates();  // a pose that bears another time than its own gives other rates
}

TEST(CoopNavigator, ASearchDoesNotOutliveAGapOrANewTimeBase) {
  for (const int jump : {-30, 200}) {  // frames
    for (const int before : {1, 2}) {  // frames: the search runs; it has found
      configure(test::one_camera(), test::eight_leds());
      scene.pose.t_CT = Vec3(-0.3, 0.2, 6.0);
      frame = 100;
      const std::vector<Vec2> clutter = clutter_of(45);
      for (int k = 0; k < before; ++k, next()) {
        scene.render({}, clutter);
        CHECK_TRUE(process() == Status::unfinished);
      }
      // The target is elsewhere by now, and alone: it has to be looked for anew, and is found at once.
      frame += jump;
      scene.pose.t_CT += Vec3(0.8, -0.5, 0.5);
      scene.render();
      CHECK_TRUE(process() == Status::ok);
      LONGS_EQUAL(8, report->inliers);
      check_pose();
    }
  }
}

TEST(CoopNavigator, SpotsThatLeadNowhereGiveWayToThoseOfALaterFrame) {
  configure(test::one_camera(), test::eight_leds());
  scene.render({0, 1, 2, 3, 4, 5, 6, 7}, clutter_of(60));
  CHECK_TRUE(process() == Status::unfinished);
  int frames = 0;
  for (; frames < 20 && !navigator->has_started(); ++frames) {
    next();
    scene.render();
    static_cast<void>(process());
  }
  CHECK_TRUE(navigator->has_started());
  CHECK_TRUE_TEXT(frames > 2 && frames < 10, StringFromFormat("%d", frames).asCharString());
  check_pose();
}

TEST(CoopNavigator, NothingToSeeIsNoTarget) {
  configure(test::one_camera(), test::eight_leds());
  scene.render_nothing();
  for (int k = 0; k < 3; ++k, next()) {
    CHECK_TRUE(process() == Status::too_few_features);
    CHECK_FALSE(navigator->has_started());
    LONGS_EQUAL(0, report->inliers);
  }
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  check_pose();
}

TEST(CoopNavigator, ASymmetricSquareIsNotAcquiredUnlessAnAttitudeIsExpected) {
  configure(test::two_cameras(), test::four_leds(), 0.0);
  for (int k = 0; k < 10; ++k, next()) {
    scene.render();
    CHECK_TRUE(process() == Status::ambiguous);
    CHECK_FALSE(navigator->has_started());
    LONGS_EQUAL(0, report->inliers);
    CHECK_TRUE(report->state.t_CT == Vec3::Zero());
  }
  configure(test::two_cameras(), test::four_leds(), 0.6);
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  LONGS_EQUAL(8, report->inliers);
  check_pose();
}

TEST(CoopNavigator, RefusesWhatItCannotUse) {
  CoopNavigatorConfig config;
  config.target = test::eight_leds();
  CHECK_TRUE(navigator->configure(config, CameraRig()) == Status::invalid_argument);
  config.spots.min_contrast = 2.0;
  CHECK_TRUE(navigator->configure(config, test::one_camera()) == Status::invalid_argument);
  config.spots.min_contrast = 0.1;
  const auto is_refused = [&](auto& setting, auto bad) {
    const auto good = setting;
    setting = bad;
    const bool refused = navigator->configure(config, test::one_camera()) == Status::invalid_argument;
    setting = good;
    return refused && navigator->configure(config, test::one_camera()) == Status::ok;
  };
  CHECK_TRUE(is_refused(config.sensor_bits, std::uint8_t{17}));
  CHECK_TRUE(is_refused(config.min_observations, std::uint16_t{3}));
  CHECK_TRUE(is_refused(config.expected_cone_rad, -1.0));
  CHECK_TRUE(is_refused(config.search.range_max_m, 0.5));
  CHECK_TRUE(is_refused(config.tracking.flux_ratio, 1.0));
  CHECK_TRUE(is_refused(config.filter.rate_sigma_rad_s, 0.0));
  configure(test::two_cameras(), test::eight_leds());
  scene.rig = test::one_camera();  // one image for two cameras
  scene.render();
  CHECK_TRUE(process() == Status::invalid_argument);
}

TEST(CoopNavigator, TimeThatStandsStillIsRefused) {
  configure(test::one_camera(), test::eight_leds());
  scene.render();
  CHECK_TRUE(process() == Status::ok);
  CHECK_TRUE(process() == Status::out_of_order);
}
