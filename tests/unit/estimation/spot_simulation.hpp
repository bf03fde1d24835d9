#pragma once
/// Light spots of a target among clutter, for the tests of the acquisition.
#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/spot_acquisition.hpp"
#include "tests/support/feature_simulation.hpp"

namespace relnav::test {

inline CameraModel led_camera(double focal_px = 548.6) {
  CameraIntrinsics k;
  k.fu = focal_px;
  k.fv = focal_px - 0.5;
  k.cu = 322.9;
  k.cv = 237.7;
  k.width_px = 640;
  k.height_px = 480;
  k.model = DistortionModel::radial_tangential;
  k.coefficients = {-0.091, 0.067, 0.0005, -0.0004};
  return CameraModel::create(k).value();
}

inline CameraRig one_camera() {
  CameraRig rig;
  static_cast<void>(rig.push_back({led_camera(), Mat3::Identity(), Vec3::Zero()}));
  return rig;
}

inline CameraRig two_cameras() {
  CameraRig rig = one_camera();
  const Mat3 R = exp_so3(Vec3(0.002, 0.01, -0.005));
  static_cast<void>(rig.push_back({led_camera(684.1), R, -(R * Vec3(0.6, 0.002, -0.001))}));
  return rig;
}

inline TargetModel target_of(const std::vector<Vec3>& p_T, const std::vector<Vec3>& normals_T = {}) {
  TargetModel target;
  for (std::size_t i = 0; i < p_T.size(); ++i) {
    TargetFeature f;
    f.id = static_cast<std::uint16_t>(i + 1);
    f.p_T = p_T[i];
    if (!normals_T.empty()) f.normal_T = normals_T[i];
    static_cast<void>(target.features.push_back(f));
  }
  return target;
}

/// That of D_C1.
inline TargetModel eight_leds() {
  return target_of({{-0.42, -0.40, -0.90},
                    {0.45, -0.38, -0.96},
                    {0.40, 0.43, -0.88},
                    {-0.44, 0.41, -1.02},
                    {0.80, 0.12, -0.58},
                    {-0.79, -0.10, -0.52},
                    {-0.12, -0.80, -0.60},
                    {0.15, 0.78, -0.50}});
}

/// That of D_S1.
inline TargetModel four_leds() {
  constexpr double a = 0.353553;
  return target_of({{-a, -a, -0.92}, {a, -a, -0.92}, {a, a, -0.92}, {-a, a, -0.92}});
}

/// 16 on the six faces of a box, seen only from in front of their face, at no regular places.
inline TargetModel sixteen_leds() {
  std::vector<Vec3> p, n;
  const auto put = [&](const Vec3& where, const Vec3& normal) {
    p.push_back(where);
    n.push_back(normal);
  };
  const Vec3 x(1.0, 0.0, 0.0), y(0.0, 1.0, 0.0), z(0.0, 0.0, 1.0);
  put({-0.61, -0.52, -0.70}, -z);
  put({0.55, -0.60, -0.72}, -z);
  put({0.38, 0.47, -0.70}, -z);
  put({0.70, -0.44, -0.31}, x);
  put({0.72, 0.51, 0.12}, x);
  put({0.70, -0.13, 0.58}, x);
  put({-0.70, 0.33, -0.52}, -x);
  put({-0.71, -0.58, 0.08}, -x);
  put({-0.70, 0.41, 0.55}, -x);
  put({-0.27, 0.70, -0.15}, y);
  put({0.48, 0.72, 0.44}, y);
  put({-0.50, -0.70, 0.37}, -y);
  put({0.22, -0.71, -0.19}, -y);
  put({-0.33, -0.20, 0.70}, z);
  put({0.46, 0.30, 0.72}, z);
  put({0.08, -0.59, 0.70}, z);
  return target_of(p, n);
}

struct SpotScenario {
  double noise_px = 0.2;
  std::size_t clutter = 0;  ///< spots, in each camera
  std::size_t hidden = 0;   ///< markers, the same in each camera
  double near_share = 0.3;  ///< of the clutter, close to the target (glints)
  double range_from_m = 4.0;
  double range_to_m = 12.0;
  double turn = 3.1;  ///< largest angle of the attitude
};

/// Draws poses and their spots.
class SpotSimulation {
 public:
  explicit SpotSimulation(std::uint64_t seed) : g_(seed, 5), normal_(seed) {}

  Pose pose(const SpotScenario& s) {
    Vec3 axis = normal_.vec3();
    while (axis.norm() < 1e-3) axis = normal_.vec3();
    const double range = s.range_from_m + (s.range_to_m - s.range_from_m) * g_.uniform();
    const double u = 0.5 * (g_.uniform() - 0.5), v = 0.4 * (g_.uniform() - 0.5);
    return {exp_so3(s.turn * g_.uniform() * axis.normalized()), range * Vec3(u, v, 1.0)};
  }

  RigSpots spots(const CameraRig& rig, const TargetModel& target, const Pose& pose, const SpotScenario& s) {
    std::vector<bool> hidden(target.features.size(), false);
    for (std::size_t k = 0; k < s.hidden; ++k) hidden[g_.below(static_cast<std::uint32_t>(hidden.size()))] = true;
    RigSpots out;
    for (std::size_t c = 0; c < rig.size(); ++c) {
      const Pose pose_K = in_camera(rig[c], pose);
      std::vector<LightSpot> list;
      Vec2 middle;
      if (rig[c].model.project(pose_K.t_CT, middle) != Status::ok) continue;
      const double reach_px = 1.2 * rig[c].model.intrinsics().fu / pose_K.t_CT.z();
      for (std::size_t m = 0; m < target.features.size(); ++m) {
        const TargetFeature& f = target.features[m];
        Vec2 uv;
        if (hidden[m] || !faces(f, camera_centre_T(pose_K), 0.15)) continue;
        if (rig[c].model.project(Vec3(pose_K.R_CT * f.p_T + pose_K.t_CT), uv) != Status::ok) continue;
        uv += s.noise_px * Vec2(normal_(), normal_());
        if (rig[c].model.in_image(uv)) list.push_back(spot(uv, s));
      }
      markers_[c] = list.size();
      for (std::size_t k = 0; k < s.clutter && list.size() < config::max_spots; ++k) {
        const bool near = g_.uniform() < s.near_share;
        const double u = g_.uniform(), v = g_.uniform();
        Vec2 uv(640.0 * u, 480.0 * v);
        if (near) uv = middle + reach_px * Vec2(2.0 * u - 1.0, 2.0 * v - 1.0);
        if (rig[c].model.in_image(uv)) list.push_back(spot(uv, s));
      }
      std::sort(list.begin(), list.end(), [](const LightSpot& a, const LightSpot& b) { return a.flux > b.flux; });
      for (const LightSpot& l : list) static_cast<void>(out[c].push_back(l));
    }
    return out;
  }
  /// Spots of markers in the last picture of a camera.
  [[nodiscard]] std::size_t markers(std::size_t camera) const { return markers_[camera]; }

 private:
  LightSpot spot(const Vec2& uv, const SpotScenario& s) {
    LightSpot out;
    out.uv_px = uv;
    out.sigma_px = s.noise_px;
    out.flux = 10.0 * g_.uniform();  // of no help: clutter is as strong
    return out;
  }
  Generator g_;
  Normal normal_;
  std::array<std::size_t, config::max_cameras> markers_{};
};

/// Angle between two attitudes, rad.
inline double angle_between(const Mat3& a, const Mat3& b) { return log_so3(a * b.transpose()).norm(); }

}  // namespace relnav::test
