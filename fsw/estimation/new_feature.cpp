#include "fsw/estimation/new_feature.hpp"

#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/inverse_depth.hpp"
#include "fsw/estimation/measurement_model.hpp"

namespace relnav {
namespace {

/// A feature used less often than this tells nothing of its neighbourhood.
constexpr std::uint32_t known_after = 5;
/// Two points of a target differ in depth by this many times their distance, 1 sigma: edges, and parts that stand apart.
constexpr double steepness = 3.0;
/// Least distance that counts, over the target's relief.
constexpr double least_distance = 0.3;
constexpr double too_far = 100.0;      ///< start ranges: no part of the mean depth of a scene
constexpr double enough_depths = 4.0;  ///< for a mean depth of the scene

struct Depth {
  double depth_m = 1.0;  ///< distance from the camera
  double sigma_m = 1.0;  ///< of what no state knows
};

struct Neighbour {
  const Feature* feature = nullptr;
  double distance_m = 0.0;  ///< from the new point, at its own depth
  double depth_m = 0.0;
};
using Neighbours = BoundedVector<Neighbour, DepthTerms::capacity()>;

/// Nearest first.
void insert(Neighbours& nearest, const Neighbour& n) {
  if (nearest.full()) {
    if (n.distance_m >= nearest[nearest.size() - 1].distance_m) return;
    nearest.pop_back();
  }
  RELNAV_ASSERT(nearest.push_back(n) == Status::ok);
  for (std::size_t k = nearest.size() - 1; k > 0 && nearest[k].distance_m < nearest[k - 1].distance_m; --k) {
    const Neighbour closer = nearest[k];
    nearest[k] = nearest[k - 1];
    nearest[k - 1] = closer;
  }
}

Neighbours neighbours_of(const Vec2& uv_px, const CameraModel& camera, const PoseLinearisation& pose,
                         const FilterState& state, const NewFeatureSettings& settings) {
  Neighbours nearest;
  const double rad_per_px = 1.0 / camera.intrinsics().fu;
  for (const Feature& f : state.features()) {
    if (f.found < known_after) continue;
    const Vec3 p_C = pose.R_CT * feature_point_T(f, settings.range_m) + pose.t_CT;
    Vec2 uv_f_px;
    if (camera.project(p_C, uv_f_px) != Status::ok) continue;
    const double depth_m = p_C.norm();
    insert(nearest, {&f, (uv_f_px - uv_px).norm() * rad_per_px * depth_m, depth_m});
  }
  return nearest;
}

/// Weighted mean of the neighbours' depths, and row 5 (rho) of the new block's dependence on pose and neighbours.
Depth depth_among(const Neighbours& nearest, const PoseLinearisation& pose, const NewFeatureSettings& settings,
                  NewFeature& out) {
  const double least_m = least_distance * settings.relief * pose.t_CT.norm();
  std::array<double, DepthTerms::capacity()> weight{};
  double weights = 0.0;
  double depths = 0.0;
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    weight[k] = 1.0 / (nearest[k].distance_m * nearest[k].distance_m + least_m * least_m);
    weights += weight[k];
    depths += weight[k] * nearest[k].depth_m;
  }
  Depth depth;
  depth.depth_m = depths / weights;
  depth.sigma_m = steepness * std::sqrt(static_cast<double>(nearest.size()) / weights);

  const double drho_ddepth = -1.0 / (depth.depth_m * depth.depth_m);
  Mat<1, 6> d_pose = Mat<1, 6>::Zero();  // d rho / d[dt_CT dphi_C]
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const Feature& f = *nearest[k].feature;
    Mat<3, 6> J_point;
    const Vec3 rotated_C = pose.R_CT * feature_point_T(f, settings.range_m, J_point);
    const Vec3 towards_C = (rotated_C + pose.t_CT) / nearest[k].depth_m;
    const double share = drho_ddepth * weight[k] / weights;
    d_pose.block<1, 3>(0, 0) += share * towards_C.transpose();
    d_pose.block<1, 3>(0, 3) -= share * (towards_C.transpose() * cross_matrix(rotated_C));
    DepthTerm term;
    term.offset = f.offset;
    term.size = f.size;
    term.J = share * (J_point.transpose() * (pose.R_CT.transpose() * towards_C));
    RELNAV_ASSERT(out.depth_terms.push_back(term) == Status::ok);
  }
  out.J_motion.block<1, 6>(5, 0) = d_pose * pose.J;
  return depth;
}

/// On the target at its own distance: goes with it.
Depth depth_of_target(const PoseLinearisation& pose, const NewFeatureSettings& settings, NewFeature& out) {
  const double distance_m = pose.t_CT.norm();
  Mat<1, 6> d_pose = Mat<1, 6>::Zero();
  d_pose.block<1, 3>(0, 0) = (-1.0 / (distance_m * distance_m * distance_m)) * pose.t_CT.transpose();
  out.J_motion.block<1, 6>(5, 0) = d_pose * pose.J;
  return {distance_m, settings.relief * distance_m};
}

/// In an unknown scene: its mean inverse depth so far, wide enough to reach infinity.
Depth depth_of_scene(const PoseLinearisation& pose, const FilterState& state, const NewFeatureSettings& settings) {
  double sum = 0.0;
  double count = 0.0;
  for (const Feature& f : state.features()) {
    const double depth_m = (pose.R_CT * feature_point_T(f, settings.range_m) + pose.t_CT).norm();
    if (!(depth_m > 0.0) || depth_m > too_far * settings.range_m) continue;
    sum += 1.0 / depth_m;
    count += 1.0;
  }
  const double depth_m = count > enough_depths ? count / sum : settings.range_m;
  return {depth_m, settings.relief * depth_m};
}

}  // namespace

Status make_new_feature(const Vec2& uv_px, const CameraModel& camera, const PoseLinearisation& pose,
                        const FilterState& state, const NewFeatureSettings& settings, NewFeature& out) {
  Vec3 ray_C;
  Mat<3, 2> J_ray_uv;
  const Status status = camera.unproject(uv_px, ray_C, J_ray_uv);
  if (status != Status::ok) return status;
  if (!(ray_C.z() > 0.0)) return Status::outside_domain;
  out = NewFeature{};
  out.ray_C = ray_C / ray_C.z();

  // r_TC = -R' t: dr = -R' dt - R' [t x] dphi. Ray in T: d(R' ray) = R' [ray x] dphi. pose.J takes the chart to (dt, dphi).
  const Mat3 R_TC = pose.R_CT.transpose();
  Feature& f = out.feature;
  f.uv0_px = uv_px;
  f.R_CT0 = pose.R_CT;
  f.r_TC0 = -(R_TC * pose.t_CT);
  f.y.head<3>() = f.r_TC0;
  Mat23 J_angles;
  inverse_depth::angles_of(Vec3(R_TC * ray_C), f.y(3), f.y(4), J_angles);
  Mat<5, 6> J_pose = Mat<5, 6>::Zero();
  J_pose.block<3, 3>(0, 0) = -R_TC;
  J_pose.block<3, 3>(0, 3) = -(R_TC * cross_matrix(pose.t_CT));
  J_pose.block<2, 3>(3, 3) = J_angles * (R_TC * cross_matrix(ray_C));
  out.J_motion.block<5, 6>(0, 0) = J_pose * pose.J;

  Depth depth;
  if (settings.on_target) {
    const Neighbours nearest = neighbours_of(uv_px, camera, pose, state, settings);
    depth = nearest.empty() ? depth_of_target(pose, settings, out) : depth_among(nearest, pose, settings, out);
  } else {
    depth = depth_of_scene(pose, state, settings);
  }
  f.y(5) = 1.0 / depth.depth_m;

  const Mat2 J_angles_uv = J_angles * (R_TC * J_ray_uv);
  out.noise.block<2, 2>(3, 3) =
      (settings.first_view_sigma_px * settings.first_view_sigma_px) * (J_angles_uv * J_angles_uv.transpose());
  const double rho_sigma = depth.sigma_m * f.y(5) * f.y(5);
  out.noise(5, 5) = rho_sigma * rho_sigma;
  return Status::ok;
}

}  // namespace relnav
