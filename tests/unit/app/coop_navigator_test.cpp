// CoopNavigator on rendered light spots of a moving target: from the image to the state, with LEDs hidden, with clutter, with
// nothing to see.
#include "fsw/app/coop_navigator.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "fsw/vision/spot_profile.hpp"
#include "platform/host/scripted_clock.hpp"
#include "tests/unit/estimation/spot_simulation.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::CoopNavigator;
using app::CoopNavigatorConfig;
using app::FeatureUse;
using app::StepReport;

namespace {

constexpr int width_px = 640;
constexpr int height_px = 480;
constexpr double step_s = 0.1;

class SpotImage {
 public:
  SpotImage() : pixels_(static_cast<std::size_t>(width_px * height_px), 8) {}
  /// Disc of 1.5 px radius behind the finder's point spread.
  void draw(const Vec2& uv_px) {
    const int u0 = static_cast<int>(uv_px(0)), v0 = static_cast<int>(uv_px(1));
    for (int v = std::max(0, v0 - 6); v <= std::min(height_px - 1, v0 + 6); ++v) {
      for (int u = std::max(0, u0 - 6); u <= std::min(width_px - 1, u0 + 6); ++u) {
        const double r = (Vec2(u, v) - uv_px).norm();
        const double level = 190.0 * vision::spot_profile(r, 1.5, 1.0 / 0.75).level;
        std::uint8_t& pixel = pixels_[static_cast<std::size_t>(v * width_px + u)];
        pixel = static_cast<std::uint8_t>(std::min(255.0, pixel + std::floor(level + 0.5)));
      }
    }
  }
  [[nodiscard]] vision::ImageView view() const { return {pixels_.data(), width_px, height_px, width_px}; }

 private:
  std::vector<std::uint8_t> pixels_;
};

/// A target in constant motion and the images of it.
struct Scene {
  CameraRig rig;
  TargetModel target;
  Pose pose{exp_so3(Vec3(0.15, -0.2, 0.3)), Vec3(-0.3, 0.2, 6.0)};
  Vec3 v_C = Vec3(0.05, -0.03, -0.1);
  Vec3 omega_C = Vec3(0.03, -0.02, 0.05);
  std::array<SpotImage, config::max_cameras> images;

  /// Without the markers of `hidden`; `clutter`: a spot that is none of the target's.
  void render(const std::vector<std::size_t>& hidden = {}, const std::vector<Vec2>& clutter = {}) {
    for (std::size_t c = 0; c < rig.size(); ++c) {
      images[c] = SpotImage();
      for (const Vec2& uv : clutter) images[c].draw(uv);
      for (std::size_t i = 0; i < target.features.size(); ++i) {
        if (std::find(hidden.begin(), hidden.end(), i) != hidden.end()) continue;
        Vec2 uv_px;
        const Pose in_camera_pose = in_camera(rig[c], pose);
        const Vec3 p = in_camera_pose.R_CT * target.features[i].p_T + in_camera_pose.t_CT;
        if (rig[c].model.project(p, uv_px) == Status::ok) images[c].draw(uv_px);
      }
    }
  }
  void render_nothing() { images.fill(SpotImage()); }
  void advance() {
    pose.t_CT += step_s * v_C;
    pose.R_CT = exp_so3(Vec3(step_s * omega_C)) * pose.R_CT;
  }
};

}  // namespace

TEST_GROUP(CoopNavigator) {
  platform::host::ScriptedClock clock;
  std::unique_ptr<CoopNavigator> navigator = std::make_unique<CoopNavigator>(clock);
  std::unique_ptr<StepReport> report = std::make_unique<StepReport>();
  Scene scene;
  int frame = 0;

  void configure(const CameraRig& rig, const TargetModel& target, double expected_cone_rad = 0.6,
                 double filter_gate_chi2 = PoseFilterConfig().gate_chi2) {
    scene.rig = rig;
    scene.target = target;
    CoopNavigatorConfig config;
    config.target = target;
    config.expected_cone_rad = expected_cone_rad;
    config.filter.gate_chi2 = filter_gate_chi2;
    CHECK_TRUE(navigator->configure(config, rig) == Status::ok);
  }
  [[nodiscard]] Time time() const { return Time{1'000'000'000 + std::int64_t{frame} * 100'000'000}; }
  Status process() {
    *report = StepReport();
    std::array<vision::ImageView, config::max_cameras> views;
    for (std::size_t c = 0; c < scene.rig.size(); ++c) views[c] = scene.images[c].view();
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
  CHECK_TRUE(process() == Status::ok);
  LONGS_EQUAL(8, report->matched);
  LONGS_EQUAL(0, report->inliers);
  LONGS_EQUAL(8, count(FeatureUse::rejected));
  CHECK_TRUE((report->state.t_CT - t_CT).norm() < 1e-12);  // at rest, as it started
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
