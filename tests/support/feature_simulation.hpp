#pragma once
// Feature-level simulation of a target for the filter's Monte Carlo tests: exact motion, exact visibility, white pixel
// noise, no images. Seeded; the same seed gives the same measurements.
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "fsw/attitude/so3.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/estimation/noncoop_filter.hpp"
#include "tests/support/normal.hpp"

namespace relnav::test {

struct BodyPoint {
  Vec3 position_B;
  Vec3 normal_B;
};

/// Where the target is and how it moves: constant rate and velocity in a camera at rest, plus optional white accelerations.
struct TargetMotion {
  Vec3 t_CB0 = Vec3(0.0, 0.0, 8.0);
  Mat3 R_CB0 = Mat3::Identity();
  Vec3 v_C = Vec3::Zero();
  Vec3 omega_C = Vec3::Zero();
  double acceleration_psd = 0.0;  ///< m/s^1.5
  double angular_psd = 0.0;       ///< rad/s^1.5
};

/// Random points on the surface of a six-sided box of about 1 m half width (a satellite's bus).
inline std::vector<BodyPoint> random_body(Normal& rng, int count, double half_width_m = 0.8) {
  std::vector<BodyPoint> body;
  for (int i = 0; i < count; ++i) {
    const auto face = rng.generator().below(6);
    const int axis = static_cast<int>(face) / 2;
    const double side = (face % 2 == 0) ? 1.0 : -1.0;
    Vec3 p;
    for (int k = 2; k >= 0; --k) p(k) = rng.generator().uniform() * 2.0 - 1.0;
    p(axis) = side * (1.0 + 0.15 * rng());  // crinkled foil and boxes
    Vec3 n = Vec3::Zero();
    n(axis) = side;
    body.push_back({half_width_m * p, n});
  }
  return body;
}

class FeatureSimulation {
 public:
  FeatureSimulation(const TargetMotion& motion, const std::vector<BodyPoint>& body, const CameraModel& camera,
                    double noise_px, std::uint64_t seed)
      : motion_(motion),
        body_(body),
        camera_(camera),
        noise_px_(noise_px),
        rng_(seed),
        t_CB_(motion.t_CB0),
        R_CB_(motion.R_CB0),
        v_C_(motion.v_C),
        omega_C_(motion.omega_C) {}

  void advance(double dt_s) {
    const double root = std::sqrt(dt_s);
    const Vec3 dw = motion_.angular_psd * root * rng_.vec3();
    const Vec3 dv = motion_.acceleration_psd * root * rng_.vec3();
    t_CB_ += dt_s * (v_C_ + 0.5 * dv);
    R_CB_ = exp_so3(Vec3(dt_s * (omega_C_ + 0.5 * dw))) * R_CB_;
    v_C_ += dv;
    omega_C_ += dw;
  }

  /// Pixel of a body point without noise; false when it is turned away (beyond 75 deg) or outside the image.
  bool see(std::size_t i, Vec2& uv_px) const {
    const Vec3 p_C = R_CB_ * body_[i].position_B + t_CB_;
    const Vec3 n_C = R_CB_ * body_[i].normal_B;
    if (-n_C.dot(p_C) < 0.26 * p_C.norm()) return false;
    if (camera_.project(p_C, uv_px) != Status::ok) return false;
    return uv_px(0) > 12 && uv_px(1) > 12 && uv_px(0) < camera_.intrinsics().width_px - 13 &&
           uv_px(1) < camera_.intrinsics().height_px - 13;
  }

  /// Starts the filter on what is visible now.
  void start(NoncoopFilter& filter, Time time) {
    Vec2 sum = Vec2::Zero();
    std::vector<Vec2> seen;
    for (std::size_t i = 0; i < body_.size(); ++i) {
      Vec2 uv;
      if (see(i, uv)) {
        seen.push_back(uv);
        sum += uv;
      }
    }
    const Vec2 centre = sum / static_cast<double>(seen.size());
    double spread = 0.0;
    for (const Vec2& uv : seen) spread += (uv - centre).squaredNorm();
    Vec3 ray;
    if (camera_.unproject(centre, ray) != Status::ok) std::abort();
    filter.start(time, ray.normalized(),
                 std::sqrt(spread / static_cast<double>(seen.size())) / camera_.intrinsics().fu);
    add_features(filter);
    filter.add_scale_uncertainty();
  }

  /// New features from unused visible points, spread at random.
  void add_features(NoncoopFilter& filter) {
    const auto n = static_cast<std::uint32_t>(body_.size());
    for (std::size_t tries = 0; tries < 4 * body_.size() && filter.has_room(); ++tries) {
      if (filter.state().features().size() >= most_features_) return;
      const std::size_t i = rng_.generator().below(n);
      if (in_use(i)) continue;
      Vec2 uv;
      if (!see(i, uv)) continue;
      const Vec2 noisy = uv + first_view_noise_px * rng_.vec2();
      const Expected<SlotHandle> slot = filter.add_feature(noisy);
      if (slot) point_of_[slot.value().index] = {slot.value(), static_cast<int>(i)};
    }
  }

  void measure(const FeaturePredictions& predictions, FeatureMatches& matches) {
    matches.clear();
    for (const FeaturePrediction& p : predictions) {
      const Entry& entry = point_of_[p.slot.index];
      if (!(entry.slot == p.slot) || entry.point < 0) continue;
      Vec2 uv;
      if (!see(static_cast<std::size_t>(entry.point), uv)) continue;
      FeatureMatch m;
      m.slot = p.slot;
      m.uv_px = uv + noise_px_ * rng_.vec2();
      m.sigma_px = 0.01;
      m.score = 1.0;
      if (matches.push_back(m) != Status::ok) return;
    }
  }

  [[nodiscard]] const Mat3& R_CB() const { return R_CB_; }
  [[nodiscard]] const Vec3& t_CB() const { return t_CB_; }
  [[nodiscard]] const Vec3& omega_C() const { return omega_C_; }
  [[nodiscard]] const Vec3& v_C() const { return v_C_; }

  static constexpr double first_view_noise_px = 0.1;

 private:
  struct Entry {
    SlotHandle slot;
    int point = -1;
  };
  bool in_use(std::size_t point) const {
    for (const Entry& e : point_of_) {
      if (e.point == static_cast<int>(point)) return true;
    }
    return false;
  }

 public:
  /// Features the filter is given at the same time.
  void set_most_features(std::size_t count) { most_features_ = count; }
  void forget(SlotHandle slot) {
    if (point_of_[slot.index].slot == slot) point_of_[slot.index].point = -1;
  }

 private:
  TargetMotion motion_;
  std::vector<BodyPoint> body_;
  CameraModel camera_;
  double noise_px_;
  std::size_t most_features_ = config::max_features;
  Normal rng_;
  Vec3 t_CB_;
  Mat3 R_CB_;
  Vec3 v_C_;
  Vec3 omega_C_;
  std::array<Entry, config::max_features> point_of_{};
};

}  // namespace relnav::test
