#include "fsw/estimation/noncoop_filter.hpp"

#include <cmath>

#include "fsw/attitude/so3.hpp"
#include "fsw/estimation/inverse_depth.hpp"

namespace relnav {
namespace {

constexpr double deg = 0.017453292519943295;

/// Pixels from the image border inside which no feature is expected.
constexpr double image_margin_px = 10.0;
/// A patch seen more obliquely than this against its first view has turned away: cos(65 deg).
constexpr double min_cos_view_change = 0.42;
/// Gauss-Newton steps per frame of each start hypothesis.
constexpr int steps_per_frame = 2;
/// Posterior probability from which on a start hypothesis has won.
constexpr double decided_probability = 0.99;
/// First view: the patch defines the point, but light and view change its look afterwards, mostly in common to all later
/// matches of the feature (0.2 to 0.3 px against the truth on rendered foil). Taken as noise of the first view.
constexpr double first_view_sigma_px = 0.25;

[[nodiscard]] bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }
[[nodiscard]] bool is_valid_sigma(double sigma) { return std::isfinite(sigma) && sigma >= 0.0; }

}  // namespace

NoncoopConfig NoncoopConfig::defaults(MotionKind motion) {
  NoncoopConfig c;
  c.motion = motion;
  if (motion == MotionKind::rigid_target) {
    c.rate_sigma_rad_s = 3.0 * deg;
    c.velocity_sigma_per_range = 0.05;
    c.acceleration_psd_per_range = 0.0005;
    c.angular_psd = 0.03 * deg;
    c.start_angular_psd = 0.1 * deg;
    c.rest_sigma_rad_s = 0.15 * deg;
    c.relief_per_extent = 1.0;
    c.min_relief = 0.03;
  } else {
    c.rate_sigma_rad_s = 0.5;
    c.velocity_sigma_per_range = 0.5;
    c.acceleration_psd_per_range = 0.5;
    c.angular_psd = 0.35;
    c.relief_per_extent = 0.0;
    c.min_relief = 0.5;
  }
  return c;
}

Status NoncoopFilter::configure(const NoncoopConfig& config, const CameraModel& camera) {
  const RansacConfig& ransac = config.ransac;
  bool valid = is_positive(config.range_m) && is_valid_sigma(config.range_sigma_m) &&
               is_valid_sigma(config.rate_sigma_rad_s) && is_valid_sigma(config.velocity_sigma_per_range) &&
               is_valid_sigma(config.acceleration_psd_per_range) && is_valid_sigma(config.angular_psd) &&
               is_valid_sigma(config.relief_per_extent) && is_valid_sigma(config.min_relief) &&
               is_positive(config.pixel_sigma_px) && is_positive(config.gate_chi2) &&
               is_valid_sigma(config.linearity_threshold) && is_valid_sigma(config.start_duration_s) &&
               config.start_frames > 0 && ransac.confidence > 0.0 && ransac.confidence < 1.0 &&
               is_positive(ransac.threshold_sigma) && ransac.max_hypotheses > 0;
  if (config.motion == MotionKind::rigid_target) {
    // The start adjustment divides by these.
    valid = valid && is_positive(config.rate_sigma_rad_s) && is_positive(config.velocity_sigma_per_range) &&
            is_positive(config.min_relief) && is_positive(config.start_angular_psd) &&
            is_positive(config.start_pixel_sigma_px) && is_positive(config.rest_sigma_rad_s);
  }
  if (!valid) return Status::invalid_argument;
  config_ = config;
  camera_ = camera;
  generator_ = Generator(config.seed);
  return Status::ok;
}

const MotionModel& NoncoopFilter::model() const {
  if (config_.motion == MotionKind::rigid_target) return rigid_motion_;
  return camera_motion_;
}

void NoncoopFilter::start(Time time, const Vec3& los_C, double half_extent) {
  const bool rigid = config_.motion == MotionKind::rigid_target;
  time_ = time;
  relief_ = std::max(config_.min_relief, config_.relief_per_extent * half_extent);
  const Vec3 t_CT = rigid ? Vec3(config_.range_m * los_C) : Vec3(Vec3::Zero());
  const MotionState motion = model().at_rest(config_.chart, Mat3::Identity(), t_CT);

  Mat12 P = Mat12::Zero();
  const Mat3 I = Mat3::Identity();
  if (rigid) {
    // Where inside the target its centre of mass lies is unknown in all directions.
    const double sigma = relief_ * config_.range_m;
    P.block<3, 3>(0, 0) = sigma * sigma * I;
  }
  const double sigma_v = config_.velocity_sigma_per_range * config_.range_m;
  P.block<3, 3>(6, 6) = sigma_v * sigma_v * I;
  P.block<3, 3>(9, 9) = config_.rate_sigma_rad_s * config_.rate_sigma_rad_s * I;
  state_.reset(motion, P);

  start_time_ = time;
  start_frames_ = 0;
  starting_ = rigid;
  StartAdjustment::Prior prior;
  prior.c_C = t_CT;
  prior.half_extent = half_extent;
  prior.relief = relief_;
  prior.c_sigma_m = relief_ * config_.range_m;
  prior.v_sigma_m_s = sigma_v;
  prior.omega_sigma_rad_s = config_.rate_sigma_rad_s;
  prior.rest_sigma_rad_s = config_.rest_sigma_rad_s;
  prior.angular_psd = config_.start_angular_psd;
  start_valid_ = false;
  start_.begin(prior);
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
  model().propagate(state_.motion_lin, dt_s, noise, camera_rate_C, F, Q);
  predict_motion(state_.P(), F, Q);
  return Status::ok;
}

void NoncoopFilter::predict_features(FeaturePredictions& predictions) {
  predictions.clear();
  const PoseLinearisation pose = model().pose(state_.motion);
  const PoseLinearisation pose_lin = model().pose(state_.motion_lin);
  const Vec3 r_TC = -(pose.R_CT.transpose() * pose.t_CT);
  const double floor_px2 = config_.pixel_sigma_px * config_.pixel_sigma_px;
  for (Feature& f : state_.features()) {
    PredictedImage predicted;
    bool visible = predict_image(camera_, pose, pose_lin, f, predicted) == Status::ok;
    visible = visible && camera_.in_image(predicted.uv_px, image_margin_px);
    if (visible) {
      const Vec3 X_T = euclidean_point_T(f);
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

Vec3 NoncoopFilter::euclidean_point_T(const Feature& f) const {
  if (f.size == 3) return f.y.head<3>();
  // A ray that points beyond infinity is treated as very far.
  const double least = 1e-3 / config_.range_m;
  const double rho = f.y(5) > least ? f.y(5) : least;
  return f.y.head<3>() + inverse_depth::ray_T(f.y(3), f.y(4)) / rho;
}

Mat2 NoncoopFilter::appearance_warp(const Feature& f, const PoseLinearisation& pose) const {
  // Plane through the point, facing the camera of the first view: d X = s (J_ray - r n' J_ray / n' r) d uv0 with n || r.
  Vec3 ray_C0;
  Mat<3, 2> J_ray_uv;
  if (camera_.unproject(f.uv0_px, ray_C0, J_ray_uv) != Status::ok) return Mat2::Identity();
  const Vec3 X_T = euclidean_point_T(f);
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
                              const PoseLinearisation& pose_lin, Innovation& innovation) const {
  PredictedImage predicted;
  if (predict_image(camera_, pose, pose_lin, state_.features()[match.feature], predicted) != Status::ok) return false;
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
  if (relinearise_due()) state_.relinearise();
  if (config_.motion == MotionKind::camera) undo_mirrored_scale();
  if (!starting_) convert_linear_features();
  switch_chart_if_due(out);
  return out;
}

void NoncoopFilter::gather_compatible(const FeatureMatches& matches, FilterUpdate& out) {
  compatible_.clear();
  innovations_.clear();
  const double floor_px2 = config_.pixel_sigma_px * config_.pixel_sigma_px;
  const PoseLinearisation pose = model().pose(state_.motion);
  const PoseLinearisation pose_lin = model().pose(state_.motion_lin);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Feature* f = state_.find(matches[i].slot);
    if (f == nullptr) continue;
    CompatibleMatch match;
    match.feature = static_cast<std::size_t>(f - state_.features().begin());
    match.uv_px = matches[i].uv_px;
    match.sigma_px = std::sqrt(floor_px2 + matches[i].sigma_px * matches[i].sigma_px);
    Innovation innovation;
    if (!linearise(match, pose, pose_lin, innovation)) continue;
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
  const PoseLinearisation pose_lin = model().pose(state_.motion_lin);
  innovations_.clear();
  for (std::size_t i = 0; i < compatible_.size(); ++i) {
    Innovation innovation;
    if (low.inlier[i] || !linearise(compatible_[i], pose, pose_lin, innovation)) continue;
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

bool NoncoopFilter::relinearise_due() const {
  if (config_.motion == MotionKind::camera) return true;  // plain EKF: the paper's
  const PoseLinearisation pose = model().pose(state_.motion);
  const PoseLinearisation pose_lin = model().pose(state_.motion_lin);
  const Mat3 difference = pose.R_CT * pose_lin.R_CT.transpose();
  constexpr double far_turned_cos = 0.9962;  // 5 deg
  constexpr double far_moved = 0.05;
  return 0.5 * (difference.trace() - 1.0) < far_turned_cos ||
         (pose.t_CT - pose_lin.t_CT).norm() > far_moved * pose.t_CT.norm();
}

void NoncoopFilter::convert_linear_features() {
  const PoseLinearisation pose = model().pose(state_.motion);
  const Vec3 r_TC = -(pose.R_CT.transpose() * pose.t_CT);
  for (std::size_t i = 0; i < state_.features().size(); ++i) {
    const Feature& f = state_.features()[i];
    if (f.size != 6) continue;
    const double variance = state_.P_at(f.offset + 5, f.offset + 5);
    if (!(variance > 0.0)) continue;
    if (inverse_depth::euclidean_linearity_index(f.y_lin, std::sqrt(variance), r_TC) < config_.linearity_threshold) {
      state_.make_euclidean(i);
    }
  }
}

void NoncoopFilter::switch_chart_if_due(FilterUpdate& update) {
  // Estimate and linearisation point may stand in different sets: only the latter's chart carries the covariance.
  Mat3 J;
  const bool estimate_switched = state_.motion.attitude.switch_if_due(J);
  update.chart_switched = state_.motion_lin.attitude.switch_if_due(J);
  if (update.chart_switched) transform_block(state_.P(), 3, J);
  update.chart_switched = update.chart_switched || estimate_switched;
}

NoncoopFilter::DepthPrior NoncoopFilter::depth_prior(const Vec2& uv_px, const PoseLinearisation& pose) const {
  if (config_.motion == MotionKind::camera) {
    // Unknown scene: its typical inverse depth, wide enough to reach infinity.
    double sum = 0.0;
    double count = 0.0;
    for (const Feature& f : state_.features()) {
      const Vec3 p_C = pose.R_CT * euclidean_point_T(f) + pose.t_CT;
      const double d = p_C.norm();
      if (!(d > 0.0) || d > 100.0 * config_.range_m) continue;
      sum += 1.0 / d;
      count += 1.0;
    }
    const double depth = count > 4.0 ? count / sum : config_.range_m;
    return {depth, relief_ * depth, 0.0};
  }
  // Near the target's centre, the nearer to a known neighbour the better known: surfaces rise no faster than ~45 deg.
  const double centre = pose.t_CT.norm();
  const double spread = relief_ * centre;
  double weight_sum = 1.0 / (spread * spread);
  double best_weight = weight_sum;
  double depth_sum = weight_sum * centre;
  const double px_to_rad = 1.0 / camera_.intrinsics().fu;
  for (const Feature& f : state_.features()) {
    if (f.found < 5) continue;
    const Vec3 p_C = pose.R_CT * euclidean_point_T(f) + pose.t_CT;
    Vec2 uv_f;
    if (camera_.project(p_C, uv_f) != Status::ok) continue;
    const double depth = p_C.norm();
    const double rise = (uv_f - uv_px).norm() * px_to_rad * depth;
    // rho's own sigma, or the Euclidean point's along the ray (trace as its bound).
    double own;
    if (f.size == 6) {
      own = std::sqrt(state_.P_at(f.offset + 5, f.offset + 5)) * depth * depth;
    } else {
      own = 0.05 * depth;
    }
    const double weight = 1.0 / (rise * rise + own * own);
    weight_sum += weight;
    depth_sum += weight * depth;
    if (weight > best_weight) best_weight = weight;
  }
  return {depth_sum / weight_sum, std::sqrt(1.0 / best_weight), 1.0};
}

Expected<SlotHandle> NoncoopFilter::add_feature(const Vec2& uv_px) {
  Vec3 ray_C;
  Mat<3, 2> J_ray_uv;
  const Status status = camera_.unproject(uv_px, ray_C, J_ray_uv);
  if (status != Status::ok) return status;

  const PoseLinearisation pose = model().pose(state_.motion);
  const Mat3 R_TC = pose.R_CT.transpose();
  const Vec3 r_TC = -(R_TC * pose.t_CT);
  const DepthPrior prior = depth_prior(uv_px, pose);

  Feature f;
  f.uv0_px = uv_px;
  f.R_CT0 = pose.R_CT;
  f.r_TC0 = r_TC;
  f.y.head<3>() = r_TC;
  Mat23 J_angles;
  inverse_depth::angles_of(Vec3(R_TC * ray_C), f.y(3), f.y(4), J_angles);
  const double rho = 1.0 / prior.depth_m;
  f.y(5) = rho;

  // The same point seen from the linearisation point's pose; Jacobians are taken there.
  const PoseLinearisation pose_lin = model().pose(state_.motion_lin);
  const Mat3 R_lin_TC = pose_lin.R_CT.transpose();
  f.y_lin.head<3>() = -(R_lin_TC * pose_lin.t_CT);
  inverse_depth::angles_of(Vec3(R_lin_TC * ray_C), f.y_lin(3), f.y_lin(4), J_angles);
  f.y_lin(5) = rho;

  // r_TC = -R' t: dr = -R' dt - R' [t x] dphi. Ray in T: d(R' ray) = R' [ray x] dphi. J_pose takes chart to (dt, dphi).
  Mat6 J_y_pose = Mat6::Zero();
  J_y_pose.block<3, 3>(0, 0) = -R_lin_TC;
  J_y_pose.block<3, 3>(0, 3) = -(R_lin_TC * cross_matrix(pose_lin.t_CT));
  J_y_pose.block<2, 3>(3, 3) = J_angles * (R_lin_TC * cross_matrix(ray_C));
  const double distance = pose_lin.t_CT.norm();
  if (prior.slope_along_los > 0.0 && distance > 0.0) {
    J_y_pose.block<1, 3>(5, 0) = (-(rho * rho) * prior.slope_along_los / distance) * pose_lin.t_CT.transpose();
  }
  Mat<6, 12> J_motion = Mat<6, 12>::Zero();
  J_motion.block<6, 6>(0, 0) = J_y_pose * pose_lin.J;

  Mat6 noise = Mat6::Zero();
  const Mat2 J_angles_uv = J_angles * (R_lin_TC * J_ray_uv);
  noise.block<2, 2>(3, 3) = (first_view_sigma_px * first_view_sigma_px) * (J_angles_uv * J_angles_uv.transpose());
  const double sigma_rho = prior.sigma_m * rho * rho;
  noise(5, 5) = sigma_rho * sigma_rho;
  const Expected<SlotHandle> slot = state_.add(f, J_motion, noise);
  if (slot && starting_) {
    const double length = ray_C.norm() / ray_C.z();
    const Vec3 p(ray_C.x() / ray_C.z(), ray_C.y() / ray_C.z(), rho * length);
    start_.add_track(slot.value(), (time_ - start_time_).seconds(), p, first_view_sigma_px / camera_.intrinsics().fu,
                     sigma_rho * length);
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
    const bool behind_infinity =
        f.size == 6 && !(f.y(5) > 0.02 / config_.range_m) && config_.motion == MotionKind::rigid_target;
    if (!(unreliable || lost || gone || behind_infinity)) continue;
    if (dropped.push_back(f.slot) != Status::ok) return;
    start_.drop_track(f.slot);
    state_.remove(i);
  }
}

bool NoncoopFilter::adjust_start(const FeatureMatches& matches) {
  start_.begin_frame((time_ - start_time_).seconds());
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
  if (start_valid_) take_over(start_result_);
  // Hand over for good once one hypothesis has won; a slow target far away may take longer, but not for ever.
  double best = 0.0;
  for (const double w : start_result_.weights) best = std::max(best, w);
  const bool decided = start_valid_ && best > decided_probability;
  const int patience = decided ? 1 : 3;
  const double span_s = (time_ - start_time_).seconds();
  if (start_frames_ >= patience * config_.start_frames && span_s >= patience * config_.start_duration_s) {
    starting_ = false;
  }
  return start_valid_;
}

void NoncoopFilter::take_over(const StartAdjustment::Result& start) {
  // theta = [c v omega alpha] plays the motion block's part while the features are rebuilt on it; the map from theta to
  // the motion states now is then one structured "prediction".
  const auto pose_at = [&start](double t_s, Vec3& phi, Vec3& t_CT) {
    phi = t_s * start.theta.segment<3>(6) + (0.5 * t_s * t_s) * start.theta.segment<3>(9);
    t_CT = start.theta.head<3>() + t_s * start.theta.segment<3>(3);
  };
  const double now_s = (time_ - start_time_).seconds();
  Vec3 phi;
  Vec3 t_CT;
  pose_at(now_s, phi, t_CT);
  MotionState motion = model().at_rest(config_.chart, exp_so3(phi), t_CT);
  motion.velocity = start.theta.segment<3>(3);
  motion.rate = start.theta.segment<3>(6) + now_s * start.theta.segment<3>(9);

  state_.begin_restore(motion, start.covariance);
  for (std::size_t i = 0; i < state_.features().size(); ++i) {
    Feature& f = state_.features()[i];
    RELNAV_ASSERT(start_.has_track(f.slot));  // every feature of a filter that is starting has its track
    const StartAdjustment::TrackResult& track = start.tracks[f.slot.index];
    Vec3 phi_a;
    Vec3 t_a_CT;
    pose_at(track.t_s, phi_a, t_a_CT);
    const Mat3 R_CT = exp_so3(phi_a);
    const Mat3 R_TC = R_CT.transpose();
    const Vec3 ray_C(track.p(0), track.p(1), 1.0);
    const double length = ray_C.norm();
    Vec6 y;
    y.head<3>() = -(R_TC * t_a_CT);
    Mat23 J_angles;
    inverse_depth::angles_of(Vec3(R_TC * ray_C), y(3), y(4), J_angles);
    y(5) = track.p(2) / length;

    const Mat3 Jl = left_jacobian_so3(phi_a);
    const Mat3 dphi_domega = track.t_s * Jl;
    const Mat3 dphi_dalpha = (0.5 * track.t_s * track.t_s) * Jl;
    Mat<6, 12> J = Mat<6, 12>::Zero();
    const Mat3 dr_dphi = -(R_TC * cross_matrix(t_a_CT));
    const Mat23 dangles_dphi = J_angles * (R_TC * cross_matrix(ray_C));
    J.block<3, 3>(0, 0) = -R_TC;
    J.block<3, 3>(0, 3) = -track.t_s * R_TC;
    J.block<3, 3>(0, 6) = dr_dphi * dphi_domega;
    J.block<3, 3>(0, 9) = dr_dphi * dphi_dalpha;
    J.block<2, 3>(3, 6) = dangles_dphi * dphi_domega;
    J.block<2, 3>(3, 9) = dangles_dphi * dphi_dalpha;
    // y through p = (x y rho) of the first sight: angles turn with the ray, inverse distance = rho / |ray|.
    Mat<6, 3> J_p = Mat<6, 3>::Zero();
    J_p.block<2, 2>(3, 0) = (J_angles * R_TC).leftCols<2>();
    J_p.block<1, 2>(5, 0) = (-y(5) / (length * length)) * track.p.head<2>().transpose();
    J_p(5, 2) = 1.0 / length;
    J += J_p.lazyProduct(track.dp_dtheta);
    const Mat6 noise = J_p * track.covariance * J_p.transpose();
    state_.restore(i, y, J, noise);
    f.R_CT0 = R_CT;
    f.r_TC0 = y.head<3>();
  }
  Mat12 F = Mat12::Zero();
  const Mat3 I = Mat3::Identity();
  const Mat3 dchart_dphi = state_.motion.attitude.error_jacobian_inverse() * left_jacobian_so3(phi);
  F.block<3, 3>(0, 0) = I;
  F.block<3, 3>(0, 3) = now_s * I;
  F.block<3, 3>(3, 6) = now_s * dchart_dphi;
  F.block<3, 3>(3, 9) = (0.5 * now_s * now_s) * dchart_dphi;
  F.block<3, 3>(6, 3) = I;
  F.block<3, 3>(9, 6) = I;
  F.block<3, 3>(9, 9) = now_s * I;
  predict_motion(state_.P(), F, Mat12::Zero());
  add_scale_uncertainty();
}

void NoncoopFilter::blend_start_hypotheses(RelativeState& out) const {
  // Mean and covariance of the mixture: until the data decide, the answer lies between the hypotheses and says so.
  const double t_s = (time_ - start_time_).seconds();
  const auto motion_of = [t_s](const StartAdjustment::Theta& theta) {
    Mat<12> m;  // t_CT, phi, v, omega
    m.segment<3>(0) = theta.segment<3>(0) + t_s * theta.segment<3>(3);
    m.segment<3>(3) = t_s * theta.segment<3>(6) + (0.5 * t_s * t_s) * theta.segment<3>(9);
    m.segment<3>(6) = theta.segment<3>(3);
    m.segment<3>(9) = theta.segment<3>(6) + t_s * theta.segment<3>(9);
    return m;
  };
  Mat<12> mean = Mat<12>::Zero();
  for (std::size_t i = 0; i < start_result_.weights.size(); ++i) {
    mean += start_result_.weights[i] * motion_of(start_result_.thetas[i]);
  }
  for (std::size_t i = 0; i < start_result_.weights.size(); ++i) {
    const Mat<12> d = motion_of(start_result_.thetas[i]) - mean;
    const Vec6 pose = d.head<6>();
    const Vec6 rate = d.tail<6>();
    out.pose_covariance += start_result_.weights[i] * (pose * pose.transpose());
    out.rate_covariance += start_result_.weights[i] * (rate * rate.transpose());
  }
  out.t_CT = mean.segment<3>(0);
  out.R_CT = exp_so3(mean.segment<3>(3));
  out.v_C = mean.segment<3>(6);
  out.omega_C = mean.segment<3>(9);
}

RelativeState NoncoopFilter::output() const {
  RelativeState out;
  out.time = time_;
  const PoseLinearisation pose = model().pose(state_.motion);
  out.R_CT = pose.R_CT;
  out.t_CT = pose.t_CT;
  const Mat6 P_pose = state_.P_block<6, 6>(0, 0);
  const PoseLinearisation pose_lin = model().pose(state_.motion_lin);
  out.pose_covariance = pose_lin.J * P_pose * pose_lin.J.transpose();
  Mat<6, 12> J_rates;
  model().rates(state_.motion, out.v_C, out.omega_C, J_rates);
  // lazyProduct: Eigen's own choice for these sizes is its blocked product, which brings malloc and a large stack frame.
  const Mat<6, 12> J_P = J_rates.lazyProduct(state_.P_block<12, 12>(0, 0));
  out.rate_covariance = J_P.lazyProduct(J_rates.transpose());
  if (starting_ && start_valid_) blend_start_hypotheses(out);
  return out;
}

}  // namespace relnav
