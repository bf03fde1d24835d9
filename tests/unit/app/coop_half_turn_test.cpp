// Sixteen lights on a box that turns by half a turn before the camera: blurred by the motion, most of them hidden at any time,
// among glints that come and go; the model says nothing of faces.
#include <cmath>
#include <memory>
#include <numbers>

#include "fsw/app/coop_navigator.hpp"
#include "platform/host/scripted_clock.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/dense.hpp"
#include "tests/support/lamp_scene.hpp"
#include "tests/unit/estimation/spot_simulation.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr double step_s = 0.2;
constexpr int frames = test::campaign(46, 18);  // 9 s
constexpr double lamp_radius_m = 0.015;

Vec3 on_the_box(Generator& generator) {
  // A face, and where on it.
  const auto axis = static_cast<int>(generator.below(3));
  Vec3 p_T;
  for (int k = 2; k >= 0; --k) p_T(k) = 1.3 * generator.uniform() - 0.65;
  p_T(axis) = generator.below(2) == 0 ? -0.68 : 0.68;
  return p_T;
}

/// The images of a target that turns.
class HalfTurn {
 public:
  HalfTurn(double rate_rad_s, double exposure_s) : exposure_s_(exposure_s) {
    omega_C_ = rate_rad_s * Vec3(0.2, 1.0, 0.1).normalized();
    Generator generator(11);
    for (Vec3& p_T : glints_) p_T = on_the_box(generator);
  }

  [[nodiscard]] const CameraRig& rig() const { return rig_; }
  /// What the navigator is told: no normals.
  [[nodiscard]] TargetModel told() const {
    TargetModel told = target_;
    for (TargetFeature& f : told.features) f.normal_T.setZero();
    return told;
  }
  [[nodiscard]] Pose pose_at(double time_s) const {
    return {exp_so3(Vec3(time_s * omega_C_)) * exp_so3(Vec3(0.6, 0.5, 0.1)), Vec3(0.1, -0.05, 5.0 - 0.02 * time_s)};
  }

  /// Of the frame whose exposure has its middle at time_s.
  std::vector<std::uint8_t> expose(double time_s, test::Normal& noise, Generator& flicker) {
    vision::test::LampScene scene(640, 480, 2.0);
    const Vec3 centre_T = camera_centre_T(pose_at(time_s));
    lights_ = 0;
    for (const TargetFeature& f : target_.features) {
      if (!faces(f, centre_T, 0.05)) continue;
      draw(scene, f.p_T, time_s, lamp_radius_m, 900.0);
      ++lights_;
    }
    for (const Vec3& p_T : glints_) {
      TargetFeature glint;
      glint.p_T = p_T;
      glint.normal_T = (p_T.cwiseAbs().array() > 0.67).select(p_T, Vec3::Zero()).normalized();
      const bool shines = flicker.below(3) == 0;
      const double amplitude = 60.0 + 300.0 * flicker.uniform();
      if (shines && faces(glint, centre_T, 0.1)) draw(scene, p_T, time_s, 0.5 * lamp_radius_m, amplitude);
    }
    return scene.expose<std::uint8_t>(&noise);
  }
  [[nodiscard]] int lights() const { return lights_; }

 private:
  [[nodiscard]] Vec2 image_at(const Vec3& p_T, double time_s) const {
    const Pose pose = pose_at(time_s);
    Vec2 uv_px = Vec2::Zero();
    CHECK(rig_[0].model.project(Vec3(pose.R_CT * p_T + pose.t_CT), uv_px) == Status::ok);
    return uv_px;
  }
  void draw(vision::test::LampScene& scene, const Vec3& p_T, double time_s, double radius_m, double amplitude) const {
    const Vec2 middle = image_at(p_T, time_s);
    const Vec2 path = image_at(p_T, time_s + 0.5 * exposure_s_) - image_at(p_T, time_s - 0.5 * exposure_s_);
    const Pose pose = pose_at(time_s);
    const double depth = (pose.R_CT * p_T + pose.t_CT).z();
    const double radius_px = radius_m * rig_[0].model.intrinsics().fu / depth;
    scene.add({middle(0), middle(1), radius_px, amplitude, path(0), path(1)});
  }

  CameraRig rig_ = test::one_camera();
  TargetModel target_ = test::sixteen_leds();
  std::array<Vec3, 40> glints_;
  Vec3 omega_C_;
  double exposure_s_;
  int lights_ = 0;
};

}  // namespace

TEST_GROUP(CoopHalfTurn) {
  platform::host::ScriptedClock clock;
  std::unique_ptr<app::CoopNavigator> navigator = std::make_unique<app::CoopNavigator>(clock);
  std::unique_ptr<app::StepReport> report = std::make_unique<app::StepReport>();

  void fly(double rate_deg_s, double exposure_s) {
    HalfTurn scene(rate_deg_s * std::numbers::pi / 180.0, exposure_s);
    app::CoopNavigatorConfig config;
    config.target = scene.told();
    config.expected_cone_rad = 0.0;
    CHECK(navigator->configure(config, scene.rig()) == Status::ok);
    test::Normal noise(3);
    Generator flicker(4);
    double position2 = 0.0, attitude2 = 0.0, nees = 0.0, worst = 0.0;
    int poses = 0, hidden = 0;
    for (int k = 0; k < frames; ++k) {
      const double time_s = k * step_s;
      const std::vector<std::uint8_t> pixels = scene.expose(time_s, noise, flicker);
      const std::array<app::CameraImage, 1> images{vision::ImageView{pixels.data(), 640, 480, 640}};
      *report = app::StepReport();
      const Status status = navigator->process(images, Time{static_cast<std::int64_t>(time_s * 1e9)}, *report);
      if (!navigator->has_started()) {
        CHECK(k < 8);  // 3360 ways in which three spots can be three of 16 markers, some frames for each
        continue;
      }
      CHECK(status == Status::ok);
      hidden += 16 - scene.lights();
      const RelativeState& s = report->state;
      const Pose truth = scene.pose_at(time_s);
      Vec6 d;
      d << truth.t_CT - s.t_CT, log_so3(Mat3(truth.R_CT * s.R_CT.transpose()));
      const double n = test::mahalanobis_squared(d, s.pose_covariance);
      position2 += d.head<3>().squaredNorm() / truth.t_CT.squaredNorm();
      attitude2 += d.tail<3>().squaredNorm();
      nees += n;
      worst = std::max(worst, n);
      ++poses;
    }
    const double position = std::sqrt(position2 / poses);
    const double attitude_deg = std::sqrt(attitude2 / poses) * 180.0 / std::numbers::pi;
    std::printf(
        "    %.0f deg/s, %.0f ms: %d poses, %.1f lights hidden, position %.3f %% of range, attitude %.3f deg, NEES "
        "%.1f, at most %.0f\n",
        rate_deg_s, 1e3 * exposure_s, poses, static_cast<double>(hidden) / poses, 100.0 * position, attitude_deg,
        nees / poses, worst);
    CHECK(position < 0.0003);
    CHECK(attitude_deg < 0.05);
    CHECK(nees / poses < 6.0);
    CHECK(worst < 40.0);
  }
};

TEST(CoopHalfTurn, slow_exposure_of_a_slow_turn) { fly(10.0, 0.02); }

TEST(CoopHalfTurn, half_a_turn_with_motion_blur) { fly(20.0, 0.1); }

}  // namespace relnav
