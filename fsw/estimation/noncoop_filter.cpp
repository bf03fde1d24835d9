#include "fsw/estimation/noncoop_filter.hpp"

#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/inverse_depth.hpp"
#include "fsw/estimation/new_feature.hpp"
#include "fsw/estimation/start_handover.hpp"

namespace relnav {
namespace {

constexpr double degree = 0.017453292519943295;

/// Pixels from the image border inside which no feature is expected.
constexpr double image_margin_px = 10.0;
/// A patch seen more obliquely than this against its first view has turned away: cos(65 deg).
constexpr double min_cos_view_change = 0.42;
/// Gauss-Newton steps per frame of each start hypothesis.
constexpr int steps_per_frame = 2;
/// Posterior probability from which on a start hypothesis has won.
constexpr double decided_probability = 0.99;
/// Where the centre of mass may lie beside the middle of what is seen, over the target's relief, 1 sigma.
constexpr double centre_offset = 0.5;
/// How far the line of sight's own direction lets its length vary, over the square of the relief.
constexpr double centre_depth = 0.125;
constexpr double least_centre_depth = 1e-3;  ///< over the range

}  // namespace

Status NoncoopFilter::configure(const NoncoopConfig& config, const CameraModel& camera) {
  const Status status = config.validate();
  if (status != Status::ok) return status;
  config_ = config;
  camera_ = camera;
  rigid_motion_ = RigidTargetMotion(config.inertia);
  generator_ = Generator(config.seed);
  return Status::ok;
}

const MotionModel& NoncoopFilter::model() const {
  if (is_rigid()) return rigid_motion_;
  return camera_motion_;
}

void NoncoopFilter::start(Time time, const Vec3& los_C, double half_extent) {
  time_ = time;
  relief_ = std::max(config_.min_relief, config_.relief_per_extent * half_extent);
  const Vec3 t_CT = is_rigid() ? Vec3(config_.range_m * los_C) : Vec3(Vec3::Zero());
  const MotionState motion = model().at_rest(config_.chart, Mat3::Identity(), t_CT);

  StartAdjustment::Prior prior;
  prior.motion.c_C = t_CT;
  prior.motion.c_lateral_sigma_m = centre_offset * relief_ * config_.range_m;
  prior.motion.c_along_sigma_m = std::max(least_centre_depth, centre_depth * relief_ * relief_) * config_.range_m;
  prior.motion.v_sigma_m_s = config_.velocity_sigma_per_range * config_.range_m;
  prior.motion.omega_sigma_rad_s = config_.rate_sigma_rad_s;
  prior.motion.angular_psd = config_.start_angular_psd;
  prior.rest_sigma_rad_s = config_.rest_sigma_rad_s;
  prior.half_extent = half_extent;
  prior.relief = relief_;

  Mat12 P = Mat12::Zero();
  const Mat3 I = Mat3::Identity();
  if (is_rigid()) {
    const double lateral = prior.motion.c_lateral_sigma_m;
    const double along = prior.motion.c_along_sigma_m;
    P.diagonal().head<3>() << lateral * lateral, lateral * lateral, along * along;
  }
  P.block<3, 3>(6, 6) = prior.motion.v_sigma_m_s * prior.motion.v_sigma_m_s * I;
  P.block<3, 3>(9, 9) = config_.rate_sigma_rad_s * config_.rate_sigma_rad_s * I;
  state_.reset(motion, P);

  start_time_ = time;
  start_frames_ = 0;
  starting_ = is_rigid();
  start_valid_ = false;
  if (starting_) start_.begin(prior);
}

void NoncoopFilter::add_scale_uncertainty() {
  if (!(config_.range_sigma_m > 0.0)) return;
  // All lengths grow together by the relative amount kappa: dx = g kappa.
  std::array<double, config::max_states> g{};
  for (int k = 0; k < 3; ++k) g[static_cast<std::size_t>(k)] = state_.motion.position(k);
  for (const Feature& f : state_.features()) {
    const auto first = static_cast<std::size_t>(f.offset);
    for (std::size_t k = 0; k < 3; ++k) g[first + k] = f.y(static_cast<int>(k));
    if (f.size == 6) g[first + 5] = -f.y(5);
  }
  const double kappa = config_.range_sigma_m / config_.range_m;
  MatrixView P = state_.P();
  for (int c = 0; c < P.cols; ++c) {
    for (int r = 0; r < P.rows; ++r) {
      P(r, c) += kappa * kappa * g[static_cast<std::size_t>(r)] * g[static_cast<std::size_t>(c)];
    }
  }
}

Status NoncoopFilter::predict(Time time, const Vec3& camera_rate_C) {
  const double dt_s = (time - time_).seconds();
  if (!(dt_s > 0.0)) return Status::out_of_order;
  time_ = time;
  Mat12 F;
  Mat12 Q;
  const ProcessNoise noise{config_.acceleration_psd_per_range * config_.range_m, config_.angular_psd};
  model().propagate(state_.motion, dt_s, noise, camera_rate_C, F, Q);
  predict_motion(state_.P(), F, Q);
  if (config_.feature_walk_px2_per_deg > 0.0) let_features_walk(dt_s);
  return Status::ok;
}

void NoncoopFilter::let_features_walk(double dt_s) {
  const double turned_deg = state_.motion.rate.norm() * dt_s / degree;
  const double walk_rad = std::sqrt(config_.feature_walk_px2_per_deg * turned_deg) / camera_.intrinsics().fu;
  const PoseLinearisation pose = model().pose(state_.motion);
  for (std::size_t i = 0; i < state_.features().size(); ++i) {
    const double distance_m = (pose.R_CT * feature_point_T(state_.features()[i], config_.range_m) + pose.t_CT).norm();
    state_.loosen(i, walk_rad * distance_m);
  }
}

void NoncoopFilter::predict_features(FeaturePredictions& predictions) {
  predictions.clear();
  const PoseLinearisation pose = model().pose(state_.motion);
  const Vec3 r_TC = -(pose.R_CT.transpose() * pose.t_CT);
  const double floor_px2 = config_.pixel_sigma_px * config_.pixel_sigma_px;
  for (Feature& f : state_.features()) {
    PredictedImage predicted;
    bool visible = predict_image(camera_, pose, f, predicted) == Status::ok;
    visible = visible && camera_.in_image(predicted.uv_px, image_margin_px);
    if (visible) {
      const Vec3 X_T = feature_point_T(f, config_.range_m);
      const Vec3 before = X_T - f.r_TC0;
      const Vec3 now = X_T - r_TC;
      visible = before.dot(now) > min_cos_view_change * before.norm() * now.norm();
    }
    if (!visible) {
      if (f.unseen_in_a_row < 0xFFFF) ++f.unseen_in_a_row;
      continue;
    }
    f.unseen_in_a_row = 0;
    FeaturePrediction p;
    p.slot = f.slot;
    p.uv_px = predicted.uv_px;
    p.S_px2 = image_covariance(state_, predicted.H) + floor_px2 * Mat2::Identity();
    p.warp = appearance_warp(f, pose);
    if (predictions.push_back(p) != Status::ok) return;  // as many slots as features: cannot overflow
  }
}

Mat2 NoncoopFilter::appearance_warp(const Feature& f, const PoseLinearisation& pose) const {
  // Plane through the point, facing the camera of the first view: d X = s (J_ray - r n' J_ray / n' r) d uv0 with n || r.
  Vec3 ray_C0;
  Mat<3, 2> J_ray_uv;
  if (camera_.unproject(f.uv0_px, ray_C0, J_ray_uv) != Status::ok) return Mat2::Identity();
  const Vec3 X_T = feature_point_T(f, config_.range_m);
  const double distance0 = (X_T - f.r_TC0).norm();
  const double scale = distance0 / ray_C0.norm();
  const Vec3 n = ray_C0.normalized();
  const Mat<3, 2> dX_C0 = scale * (J_ray_uv - n * (n.transpose() * J_ray_uv));
  Vec2 uv_px;
  Mat23 J_uv_p;
  if (camera_.project(Vec3(pose.R_CT * X_T + pose.t_CT), uv_px, J_uv_p) != Status::ok) return Mat2::Identity();
  return J_uv_p * (pose.R_CT * (f.R_CT0.transpose() * dX_C0));
}

bool NoncoopFilter::linearise(const CompatibleMatch& match, const PoseLinearisation& pose,
                              Innovation& innovation) const {
  PredictedImage predicted;
  if (predict_image(camera_, pose, state_.features()[match.feature], predicted) != Status::ok) return false;
  innovation.H = predicted.H;
  innovation.nu_px = match.uv_px - predicted.uv_px;
  innovation.variance_px2 = match.sigma_px * match.sigma_px;
  Mat2 S = image_covariance(state_, predicted.H);
  S(0, 0) += innovation.variance_px2;
  S(1, 1) += innovation.variance_px2;
  const double det = S(0, 0) * S(1, 1) - S(0, 1) * S(0, 1);
  if (!(det > 0.0)) return false;
  const Vec2& nu = innovation.nu_px;
  const double mahalanobis2 = (S(1, 1) * nu(0) * nu(0) - 2.0 * S(0, 1) * nu(0) * nu(1) + S(0, 0) * nu(1) * nu(1)) / det;
  if (config_.robust_sigma > 0.0) {
    innovation.variance_px2 *= 1.0 + mahalanobis2 / (config_.robust_sigma * config_.robust_sigma);
  }
  return mahalanobis2 < config_.gate_chi2;
}

FilterUpdate NoncoopFilter::update(const FeatureMatches& matches) {
  FilterUpdate out;
  out.verdict.fill(MatchVerdict::incompatible);
  gather_compatible(matches, out);

  ekf_.prepare(state_, innovations_);
  const RansacResult low =
      one_point_ransac(config_.ransac, generator_, camera_, model(), state_, compatible_, innovations_, ekf_);
  out.hypotheses = low.hypotheses;
  for (std::size_t i = 0; i < compatible_.size(); ++i) {
    if (low.inlier[i]) out.verdict[match_of_[i]] = MatchVerdict::low_innovation;
  }

  if (starting_ && adjust_start(matches)) {
    // The adjusted start holds this frame already; its robust loss has judged what the gate let through.
    for (std::size_t i = 0; i < compatible_.size(); ++i) {
      if (!low.inlier[i]) out.verdict[match_of_[i]] = MatchVerdict::high_innovation;
    }
    out.inliers = out.compatible;
  } else {
    update_with_inliers(low, out);
  }
  record_use(out);
  if (!is_rigid()) undo_mirrored_scale();
  if (!starting_) convert_linear_features();
  Mat3 J;
  out.chart_switched = state_.motion.attitude.switch_if_due(J);
  if (out.chart_switched) transform_block(state_.P(), 3, J);
  return out;
}

void NoncoopFilter::gather_compatible(const FeatureMatches& matches, FilterUpdate& out) {
  compatible_.clear();
  innovations_.clear();
  const double floor_px2 = config_.pixel_sigma_px * config_.pixel_sigma_px;
  const PoseLinearisation pose = model().pose(state_.motion);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Feature* f = state_.find(matches[i].slot);
    if (f == nullptr) continue;
    CompatibleMatch match;
    match.feature = static_cast<std::size_t>(f - state_.features().begin());
    match.uv_px = matches[i].uv_px;
    match.sigma_px = std::sqrt(floor_px2 + matches[i].sigma_px * matches[i].sigma_px);
    Innovation innovation;
    if (!linearise(match, pose, innovation)) continue;
    match_of_[compatible_.size()] = i;
    out.verdict[i] = MatchVerdict::outlier;
    if (compatible_.push_back(match) != Status::ok || innovations_.push_back(innovation) != Status::ok) break;
  }
  out.compatible = static_cast<int>(compatible_.size());
}

void NoncoopFilter::update_with_inliers(const RansacResult& low, FilterUpdate& out) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < compatible_.size(); ++i) {
    if (low.inlier[i]) innovations_[kept++] = innovations_[i];
  }
  innovations_.truncate(kept);
  const UpdateResult first = ekf_.apply(state_, innovations_);
  out.status = first.status;
  out.nis = first.nis;
  out.rows = first.rows;
  if (first.status != Status::ok) {
    for (MatchVerdict& v : out.verdict) {
      if (v == MatchVerdict::low_innovation) v = MatchVerdict::outlier;
    }
    return;
  }
  out.inliers = static_cast<int>(kept);

  // Second half (Civera 2010): what the first update has made predictable is rescued.
  const PoseLinearisation pose = model().pose(state_.motion);
  innovations_.clear();
  for (std::size_t i = 0; i < compatible_.size(); ++i) {
    Innovation innovation;
    if (low.inlier[i] || !linearise(compatible_[i], pose, innovation)) continue;
    out.verdict[match_of_[i]] = MatchVerdict::high_innovation;
    if (innovations_.push_back(innovation) != Status::ok) break;
  }
  const UpdateResult second = ekf_.apply(state_, innovations_);
  out.status = second.status;
  if (second.status == Status::ok) {
    out.inliers += second.rows / 2;
    return;
  }
  for (MatchVerdict& v : out.verdict) {
    if (v == MatchVerdict::high_innovation) v = MatchVerdict::outlier;
  }
}

void NoncoopFilter::record_use(const FilterUpdate& out) {
  for (Feature& f : state_.features()) {
    const bool searched_for = f.unseen_in_a_row == 0;
    f.lost_in_a_row = searched_for ? static_cast<std::uint16_t>(f.lost_in_a_row + 1) : std::uint16_t{0};
    if (searched_for) ++f.expected;
  }
  for (std::size_t i = 0; i < compatible_.size(); ++i) {
    const MatchVerdict v = out.verdict[match_of_[i]];
    if (v != MatchVerdict::low_innovation && v != MatchVerdict::high_innovation) continue;
    Feature& f = state_.features()[compatible_[i].feature];
    f.lost_in_a_row = 0;
    ++f.found;
  }
}

void NoncoopFilter::undo_mirrored_scale() {
  std::size_t negative = 0;
  for (const Feature& f : state_.features()) {
    if (f.size == 6 && f.y(5) < 0.0) ++negative;
  }
  if (2 * negative > state_.features().size()) state_.negate_scale();
}

void NoncoopFilter::convert_linear_features() {
  const PoseLinearisation pose = model().pose(state_.motion);
  const Vec3 r_TC = -(pose.R_CT.transpose() * pose.t_CT);
  for (std::size_t i = 0; i < state_.features().size(); ++i) {
    const Feature& f = state_.features()[i];
    if (f.size != 6) continue;
    const double variance = state_.P_at(f.offset + 5, f.offset + 5);
    if (!(variance > 0.0)) continue;
    if (inverse_depth::euclidean_linearity_index(f.y, std::sqrt(variance), r_TC) < config_.linearity_threshold) {
      state_.make_euclidean(i);
    }
  }
}

Expected<SlotHandle> NoncoopFilter::add_feature(const Vec2& uv_px) {
  const NewFeatureSettings settings{is_rigid(), config_.range_m, relief_, config_.first_view_sigma_px};
  NewFeature fresh;
  const Status status = make_new_feature(uv_px, camera_, model().pose(state_.motion), state_, settings, fresh);
  if (status != Status::ok) return status;
  const Expected<SlotHandle> slot = state_.add(fresh.feature, fresh.J_motion, fresh.depth_terms, fresh.noise);
  if (slot && starting_) {
    const double length = fresh.ray_C.norm();  // distance over depth
    const Vec3 p(fresh.ray_C.x(), fresh.ray_C.y(), fresh.feature.y(5) * length);
    start_.add_track(slot.value(), since_start_s(), p, config_.first_view_sigma_px / camera_.intrinsics().fu,
                     std::sqrt(fresh.noise(5, 5)) * length);
  }
  return slot;
}

void NoncoopFilter::drop_spent_features(BoundedVector<SlotHandle, config::max_features>& dropped) {
  const bool full = !state_.has_room();
  for (std::size_t k = state_.features().size(); k > 0; --k) {
    const std::size_t i = k - 1;
    const Feature& f = state_.features()[i];
    const bool young = f.expected < 10;
    const bool unreliable = f.expected >= 6 && 2U * f.found < f.expected;
    const bool lost = f.lost_in_a_row > (young ? 3 : 12);
    const bool gone = f.unseen_in_a_row > (full ? 5 : 50);
    const bool behind_infinity = f.size == 6 && !(f.y(5) > 0.02 / config_.range_m) && is_rigid();
    if (!(unreliable || lost || gone || behind_infinity)) continue;
    if (dropped.push_back(f.slot) != Status::ok) return;
    if (starting_) start_.end_track(f.slot);
    state_.remove(i);
  }
}

bool NoncoopFilter::adjust_start(const FeatureMatches& matches) {
  start_.begin_frame(since_start_s());
  for (const FeatureMatch& m : matches) {
    Vec3 ray_C;
    if (camera_.unproject(m.uv_px, ray_C) != Status::ok || !(ray_C.z() > 0.0)) continue;
    const double sigma_px =
        std::sqrt(config_.start_pixel_sigma_px * config_.start_pixel_sigma_px + m.sigma_px * m.sigma_px);
    start_.observe(m.slot, ray_C.head<2>() / ray_C.z(), sigma_px / camera_.intrinsics().fu);
  }
  start_.improve(steps_per_frame);
  ++start_frames_;
  start_valid_ = start_frames_ >= 2 && start_.result(start_result_) == Status::ok;
  if (start_valid_) {
    for (const Feature& f : state_.features()) RELNAV_ASSERT(start_.has_track(f.slot));
    take_over_start(start_result_, since_start_s(), config_.chart, state_);
    add_scale_uncertainty();
  }
  // Hand over for good once one hypothesis has won; a slow target far away may take longer, but not for ever.
  double best = 0.0;
  for (const double w : start_result_.weights) best = std::max(best, w);
  const bool decided = start_valid_ && best > decided_probability;
  const int patience = decided ? 1 : 3;
  if (start_frames_ >= patience * config_.start_frames && since_start_s() >= patience * config_.start_duration_s) {
    starting_ = false;
  }
  return start_valid_;
}

void NoncoopFilter::widen_by_prior(RelativeState& out) const {
  const Vec3 los_C = out.t_CT.normalized();
  const Mat3 across = Mat3::Identity() - los_C * los_C.transpose();
  const double speed = config_.velocity_sigma_per_range * config_.range_m;
  const double rate = config_.rate_sigma_rad_s;
  const double t = since_start_s();
  out.pose_covariance.topLeftCorner<3, 3>() += (speed * t * speed * t) * across;
  out.pose_covariance.bottomRightCorner<3, 3>() += (rate * t * rate * t) * across;
  out.rate_covariance.topLeftCorner<3, 3>() += (speed * speed) * across;
  out.rate_covariance.bottomRightCorner<3, 3>() += (rate * rate) * across;
}

RelativeState NoncoopFilter::output() const {
  RelativeState out;
  out.time = time_;
  const PoseLinearisation pose = model().pose(state_.motion);
  out.R_CT = pose.R_CT;
  out.t_CT = pose.t_CT;
  const Mat6 P_pose = state_.P_block<6, 6>(0, 0);
  out.pose_covariance = pose.J * P_pose * pose.J.transpose();
  Mat<6, 12> J_rates;
  model().rates(state_.motion, out.v_C, out.omega_C, J_rates);
  // lazyProduct: Eigen's own choice for these sizes is its blocked product, which brings malloc and a large stack frame.
  const Mat<6, 12> J_P = J_rates.lazyProduct(state_.P_block<12, 12>(0, 0));
  out.rate_covariance = J_P.lazyProduct(J_rates.transpose());
  if (starting_ && start_valid_) blend_start_hypotheses(start_result_, since_start_s(), out);
  if (starting_ && start_frames_ < config_.start_frames) widen_by_prior(out);
  return out;
}

}  // namespace relnav
