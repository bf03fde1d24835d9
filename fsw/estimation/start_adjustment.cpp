#include "fsw/estimation/start_adjustment.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/attitude/so3.hpp"
#include "fsw/math/covariance_kernels.hpp"
#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

constexpr double huber_sigma = 2.5;
constexpr double min_depth_fraction = 0.2;  ///< of a track's prior depth that a step may reach
constexpr double max_damping = 1e6;
/// Tracks whose depth priors together count as one: the depths of a surface go together, and independent priors on all of
/// them would flatten the relief and speed up the rate (joint modes are biased along the bas-relief ambiguity).
constexpr double relief_sharing = 10.0;
/// Matching errors repeat from frame to frame; the evidence counts them as if they were new each time by about this much.
constexpr double evidence_temperature = 5.0;
constexpr double small_gain = 0.2;  ///< of the cost (half a chi-square)
constexpr int steps_after_mirror = 3;
constexpr std::uint32_t min_frames_to_beat = 16;  ///< before this no hypothesis is given up
constexpr std::size_t at_rest = 2;                ///< hypothesis that the target hardly turns
constexpr double worst_cost = std::numeric_limits<double>::infinity();

/// Huber's rho (half a square inside) and its weight for a normalised residual length.
double huber_cost(double length) {
  return length <= huber_sigma ? 0.5 * length * length : huber_sigma * (length - 0.5 * huber_sigma);
}
double huber_weight(double length) { return length <= huber_sigma ? 1.0 : huber_sigma / length; }

/// Inverse of a symmetric positive definite 3 x 3 whose diagonal is raised by the factor 1 + damping (adjugate).
Mat3 damped_inverse(const Mat3& H, double damping) {
  const double f = 1.0 + damping;
  const double a = H(0, 0) * f;
  const double b = H(1, 1) * f;
  const double c = H(2, 2) * f;
  const double d = H(1, 0);
  const double e = H(2, 0);
  const double g = H(2, 1);
  Mat3 adjugate;
  adjugate << b * c - g * g, e * g - d * c, d * g - e * b,  //
      e * g - d * c, a * c - e * e, d * e - a * g,          //
      d * g - e * b, d * e - a * g, a * b - d * d;
  const double determinant = a * adjugate(0, 0) + d * adjugate(1, 0) + e * adjugate(2, 0);
  return adjugate / determinant;
}

MatrixView view_of(Mat<12, 12>& m) { return {m.data(), 12, 12, 12}; }

}  // namespace

void StartAdjustment::begin(const Prior& prior) {
  prior_ = prior;
  for (Track& t : tracks_) t.used = false;
  keyframes_ = 0;
  frames_seen_ = 0;
  stride_ = 1;
  for (Hypothesis& h : hypotheses_) {
    h = Hypothesis{};
    h.theta.head<3>() = prior.c_C;
    h.omega_sigma_rad_s = prior.omega_sigma_rad_s;
  }
  hypotheses_[at_rest].omega_sigma_rad_s = prior.rest_sigma_rad_s;
}

void StartAdjustment::add_track(SlotHandle slot, double t_s, const Vec3& p, double xy_sigma, double rho_sigma) {
  Track& track = tracks_[slot.index];
  track.slot = slot;
  track.used = true;
  track.t_s = t_s;
  track.prior = p;
  const double w_xy = 1.0 / (xy_sigma * xy_sigma);
  track.weight = Vec3(w_xy, w_xy, 1.0 / (relief_sharing * rho_sigma * rho_sigma));
  for (std::size_t k = 0; k < keyframes_; ++k) observed_[k][slot.index].sigma = 0.0;
  for (Hypothesis& h : hypotheses_) h.p[slot.index] = p;
  if (t_s > 0.0) return;
  // A body bulges toward its viewer: the middle starts nearer than the rim. A starting value only, no prior: it tells the
  // first hypothesis which sign to try first, the second one tries the other.
  const Vec2 offset = p.head<2>() - prior_.c_C.head<2>() / prior_.c_C.z();
  const double r2 = offset.squaredNorm() / (2.0 * prior_.half_extent * prior_.half_extent);
  const double bulge = prior_.relief * (std::min(r2, 1.0) - 0.5);
  hypotheses_[0].p[slot.index](2) /= 1.0 + bulge;
  hypotheses_[1].p[slot.index](2) /= 1.0 - bulge;
}

void StartAdjustment::drop_track(SlotHandle slot) {
  Track& track = tracks_[slot.index];
  if (track.used && track.slot == slot) track.used = false;
}

bool StartAdjustment::has_track(SlotHandle slot) const {
  const Track& track = tracks_[slot.index];
  return track.used && track.slot == slot;
}

void StartAdjustment::begin_frame(double t_s) {
  // The newest frame stands last. It stays only when its turn in the stride has come; else the next one takes its place.
  const bool keep_last = keyframes_ == 0 || (frames_seen_ - 1) % stride_ == 0;
  if (keep_last && keyframes_ == max_keyframes) {
    for (std::size_t k = 0; 2 * k < max_keyframes; ++k) {
      frame_t_s_[k] = frame_t_s_[2 * k];
      observed_[k] = observed_[2 * k];
    }
    keyframes_ = max_keyframes / 2;
    stride_ *= 2;
  }
  if (keep_last) ++keyframes_;
  ++frames_seen_;
  frame_t_s_[keyframes_ - 1] = t_s;
  for (Observation& o : observed_[keyframes_ - 1]) o.sigma = 0.0;
}

void StartAdjustment::observe(SlotHandle slot, const Vec2& xy, double sigma) {
  if (keyframes_ == 0 || !has_track(slot)) return;
  observed_[keyframes_ - 1][slot.index] = {xy(0), xy(1), sigma};
}

StartAdjustment::FrameMotion StartAdjustment::motion_at(const Theta& theta, double t_s) {
  const Vec3 phi = t_s * theta.segment<3>(6) + (0.5 * t_s * t_s) * theta.segment<3>(9);
  return {exp_so3(phi), left_jacobian_so3(phi), theta.head<3>() + t_s * theta.segment<3>(3)};
}

double StartAdjustment::alpha_sigma() const {
  // A rate that walks with density q strays by q sqrt(T) over T; a constant alpha does the same with q / sqrt(T).
  return prior_.angular_psd / std::sqrt(std::max(span_s(), 1.0));
}

StartAdjustment::Theta StartAdjustment::prior_weights(const Hypothesis& h) const {
  const double share =
      h.omega_sigma_rad_s / prior_.omega_sigma_rad_s;  // a target at rest does not accelerate much either
  const double sigma[4] = {prior_.c_sigma_m, prior_.v_sigma_m_s, h.omega_sigma_rad_s, share * alpha_sigma()};
  Theta w;
  for (int k = 0; k < theta_size; ++k) w(k) = 1.0 / (sigma[k / 3] * sigma[k / 3]);
  return w;
}

StartAdjustment::Theta StartAdjustment::prior_mean() const {
  Theta mean = Theta::Zero();
  mean.head<3>() = prior_.c_C;
  return mean;
}

void StartAdjustment::linearise(const Hypothesis& at, Normal& out) const {
  out.A.setZero();
  out.b.setZero();
  out.cost = 0.0;
  for (Mat3& H : out.H) H.setZero();
  const Theta weights = prior_weights(at);
  const Theta prior_error = prior_mean() - at.theta;
  out.A.diagonal() = weights;
  out.b = weights.cwiseProduct(prior_error);
  out.cost += 0.5 * prior_error.dot(out.b);
  std::array<FrameMotion, max_keyframes> frames;
  for (std::size_t k = 0; k < keyframes_; ++k) frames[k] = motion_at(at.theta, frame_t_s_[k]);

  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    const Track& track = tracks_[j];
    if (!track.used) continue;
    const Vec3& p = at.p[j];
    const double rho = p(2);
    const Vec3 track_error = track.prior - p;
    out.W[j].setZero();
    out.H[j] = track.weight.asDiagonal();
    out.g[j] = track.weight.cwiseProduct(track_error);
    out.cost += 0.5 * track_error.dot(out.g[j]);

    const FrameMotion anchor = motion_at(at.theta, track.t_s);
    const Vec3 x = Vec3(p(0), p(1), 1.0) - rho * anchor.c;
    const Mat3 X_anchor = cross_matrix(x) * anchor.Jl;
    for (std::size_t k = 0; k < keyframes_; ++k) {
      const Observation& o = observed_[k][j];
      if (!(o.sigma > 0.0)) continue;
      const FrameMotion& f = frames[k];
      const double t_s = frame_t_s_[k];
      const Mat3 M = f.R * anchor.R.transpose();
      const Vec3 q = M * x;
      const Vec3 h = q + rho * f.c;
      if (!(h.z() > 0.0)) {
        out.cost = worst_cost;
        return;
      }
      const double iz = 1.0 / h.z();
      const Vec2 r(o.x - h.x() * iz, o.y - h.y() * iz);
      const double length = r.norm() / o.sigma;
      const double weight = huber_weight(length) / (o.sigma * o.sigma);
      out.cost += huber_cost(length);

      Mat23 J_xy_h;
      J_xy_h << iz, 0.0, -h.x() * iz * iz, 0.0, iz, -h.y() * iz * iz;
      const Mat3 turn_now = -(cross_matrix(q) * f.Jl);
      const Mat3 turn_then = M * X_anchor;
      Mat<3, 12> J_h;
      J_h.block<3, 3>(0, 0) = rho * (Mat3::Identity() - M);
      J_h.block<3, 3>(0, 3) = rho * (t_s * Mat3::Identity() - track.t_s * M);
      J_h.block<3, 3>(0, 6) = t_s * turn_now + track.t_s * turn_then;
      J_h.block<3, 3>(0, 9) = (0.5 * t_s * t_s) * turn_now + (0.5 * track.t_s * track.t_s) * turn_then;
      const Mat<2, 12> J = J_xy_h * J_h;
      Mat3 J_h_p;
      J_h_p.leftCols<2>() = M.leftCols<2>();
      J_h_p.col(2) = f.c - M * anchor.c;
      const Mat23 J_p = J_xy_h * J_h_p;

      for (int c = 0; c < theta_size; ++c) {
        const double j0 = weight * J(0, c);
        const double j1 = weight * J(1, c);
        for (int row = c; row < theta_size; ++row) out.A(row, c) += j0 * J(0, row) + j1 * J(1, row);
        out.b(c) += j0 * r(0) + j1 * r(1);
        for (int k3 = 0; k3 < 3; ++k3) out.W[j](c, k3) += j0 * J_p(0, k3) + j1 * J_p(1, k3);
      }
      out.H[j] += weight * (J_p.transpose() * J_p);
      out.g[j] += weight * (J_p.transpose() * r);
    }
  }
}

double StartAdjustment::cost_of(const Hypothesis& at) const {
  const Theta theta_error = prior_mean() - at.theta;
  double cost = 0.5 * theta_error.dot(prior_weights(at).cwiseProduct(theta_error));
  std::array<FrameMotion, max_keyframes> frames;
  for (std::size_t k = 0; k < keyframes_; ++k) frames[k] = motion_at(at.theta, frame_t_s_[k]);
  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    const Track& track = tracks_[j];
    if (!track.used) continue;
    const double rho = at.p[j](2);
    if (!(rho > 0.0) || rho * min_depth_fraction > track.prior(2)) return worst_cost;
    const Vec3 prior_error = track.prior - at.p[j];
    cost += 0.5 * prior_error.dot(track.weight.cwiseProduct(prior_error));
    const FrameMotion anchor = motion_at(at.theta, track.t_s);
    const Vec3 x = anchor.R.transpose() * (Vec3(at.p[j](0), at.p[j](1), 1.0) - rho * anchor.c);
    for (std::size_t k = 0; k < keyframes_; ++k) {
      const Observation& o = observed_[k][j];
      if (!(o.sigma > 0.0)) continue;
      const Vec3 h = frames[k].R * x + rho * frames[k].c;
      if (!(h.z() > 0.0)) return worst_cost;
      const Vec2 r(o.x - h.x() / h.z(), o.y - h.y() / h.z());
      cost += huber_cost(r.norm() / o.sigma);
    }
  }
  return cost;
}

void StartAdjustment::eliminate_tracks(const Normal& normal, double damping, Mat12& S, Theta& b) {
  for (std::size_t j = 0; j < normal.H.size(); ++j) {
    if (!(normal.H[j](0, 0) > 0.0)) continue;
    const Mat3 inverse = damped_inverse(normal.H[j], damping);
    const Mat<12, 3> WH = normal.W[j] * inverse;
    for (int c = 0; c < theta_size; ++c) {
      for (int r = c; r < theta_size; ++r) S(r, c) -= WH.row(r).dot(normal.W[j].row(c));
    }
    b -= WH * normal.g[j];
  }
}

bool StartAdjustment::solve(const Normal& normal, double damping, Theta& d_theta,
                            std::array<Vec3, config::max_features>& d_p) {
  Mat12 S = normal.A;
  Theta b = normal.b;
  for (int k = 0; k < theta_size; ++k) S(k, k) *= 1.0 + damping;
  eliminate_tracks(normal, damping, S, b);
  if (cholesky_lower(view_of(S)) != Status::ok) return false;
  solve_lower(view_of(S), {b.data(), static_cast<std::size_t>(theta_size)});
  for (int c = theta_size - 1; c >= 0; --c) {  // L' d = y
    double sum = b(c);
    for (int r = c + 1; r < theta_size; ++r) sum -= S(r, c) * d_theta(r);
    d_theta(c) = sum / S(c, c);
  }
  for (std::size_t j = 0; j < normal.H.size(); ++j) {
    if (!(normal.H[j](0, 0) > 0.0)) continue;
    d_p[j] = damped_inverse(normal.H[j], damping) * (normal.g[j] - normal.W[j].transpose() * d_theta);
  }
  return true;
}

bool StartAdjustment::step(Hypothesis& hypothesis) {
  linearise(hypothesis, normal_);
  hypothesis.cost = normal_.cost;
  Theta d_theta;
  std::array<Vec3, config::max_features> d_p{};
  if (!std::isfinite(normal_.cost) || !solve(normal_, hypothesis.damping, d_theta, d_p)) {
    hypothesis.damping = std::min(max_damping, 10.0 * hypothesis.damping);
    return true;
  }
  Hypothesis tried = hypothesis;
  tried.theta += d_theta;
  for (std::size_t j = 0; j < d_p.size(); ++j) {
    if (!tracks_[j].used) continue;
    const double prior_rho = tracks_[j].prior(2);
    tried.p[j] += d_p[j];
    tried.p[j](2) = std::clamp(tried.p[j](2), 0.05 * prior_rho, prior_rho / min_depth_fraction);
  }
  tried.cost = cost_of(tried);
  if (!(tried.cost <= hypothesis.cost)) {
    hypothesis.damping = std::min(max_damping, 10.0 * hypothesis.damping);
    return true;
  }
  const double gain = hypothesis.cost - tried.cost;
  tried.damping = std::max(1e-9, 0.1 * hypothesis.damping);
  hypothesis = tried;
  return gain > small_gain;
}

void StartAdjustment::mirror(const Hypothesis& from, Hypothesis& to) const {
  // Turned over about the mean depth, turning the other way: the same picture but for perspective.
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    if (!tracks_[j].used) continue;
    sum += 1.0 / from.p[j](2);
    count += 1.0;
  }
  if (!(count > 0.0)) return;
  const double mean = sum / count;
  to = from;
  to.damping = 1e-3;
  to.theta(2) = 2.0 * mean - from.theta(2);
  for (const int k : {6, 7, 9, 10}) to.theta(k) = -from.theta(k);
  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    if (!tracks_[j].used) continue;
    const double z = std::max(2.0 * mean - 1.0 / from.p[j](2), 0.3 * mean);
    to.p[j](2) = 1.0 / z;
  }
}

void StartAdjustment::improve(int steps) {
  for (Hypothesis& h : hypotheses_) {
    for (int i = 0; h.alive && i < steps; ++i) {
      if (!step(h)) break;
    }
  }
  // Both may settle on the same side. Once in a while the worse one restarts as the mirror image of the better.
  if (frames_seen_ % 8 == 0) {
    const std::size_t best = hypotheses_[0].cost <= hypotheses_[1].cost ? 0 : 1;  // the two that turn
    const Hypothesis& b = hypotheses_[best];
    Hypothesis& other = hypotheses_[1 - best];
    if (b.alive && other.alive && b.theta.segment<2>(6).dot(other.theta.segment<2>(6)) > 0.0) {
      mirror(b, other);
      for (int i = 0; i < steps_after_mirror; ++i) {  // or it would be judged before it has settled
        if (!step(other)) break;
      }
    }
  }
}

double StartAdjustment::negative_log_evidence(const Hypothesis& h, const Normal& normal, const Mat12& L) const {
  // Laplace: cost + 1/2 log det(Hessian) - 1/2 log det(prior weights), the Hessian split into tracks and reduced rest.
  double e = normal.cost;
  const Theta weights = prior_weights(h);
  for (int k = 0; k < theta_size; ++k) e += math::log(L(k, k)) - 0.5 * math::log(weights(k));
  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    if (!tracks_[j].used) continue;
    const Vec3& w = tracks_[j].weight;
    e += 0.5 * math::log(normal.H[j].determinant() / (w(0) * w(1) * w(2)));
  }
  return e;
}

Status StartAdjustment::result(Result& out) {
  std::array<double, hypothesis_count> energy{};
  double least = worst_cost;
  for (std::size_t i = 0; i < hypothesis_count; ++i) {
    const Hypothesis& h = hypotheses_[i];
    out.thetas[i] = h.theta;
    energy[i] = worst_cost;
    if (!h.alive) continue;
    linearise(h, normal_);
    if (!std::isfinite(normal_.cost)) continue;
    Mat12 L = normal_.A;
    Theta b = normal_.b;
    eliminate_tracks(normal_, 0.0, L, b);
    if (cholesky_lower(view_of(L)) != Status::ok) continue;
    energy[i] = negative_log_evidence(h, normal_, L);
    if (!(energy[i] < least)) continue;
    least = energy[i];
    Mat12 B = Mat12::Identity();
    solve_right_transposed(view_of(L), view_of(B));  // B = L^-T
    out.theta = h.theta;
    out.covariance = B.lazyProduct(B.transpose());
    for (std::size_t j = 0; j < tracks_.size(); ++j) {
      if (!tracks_[j].used) continue;
      TrackResult& t = out.tracks[j];
      t.p = h.p[j];
      t.covariance = damped_inverse(normal_.H[j], 0.0);
      t.dp_dtheta = -(t.covariance * normal_.W[j].transpose());
      t.t_s = tracks_[j].t_s;
    }
  }
  if (!std::isfinite(least)) return Status::no_convergence;
  double sum = 0.0;
  for (std::size_t i = 0; i < hypothesis_count; ++i) {
    const double excess = (energy[i] - least) / evidence_temperature;
    out.weights[i] = excess < 50.0 ? math::exp(-excess) : 0.0;
    sum += out.weights[i];
  }
  for (std::size_t i = 0; i < hypothesis_count; ++i) {
    out.weights[i] /= sum;
    // Beaten by so much that no later frame will turn it: its share of the time goes to nobody.
    if (frames_seen_ >= min_frames_to_beat && out.weights[i] < 1e-9) hypotheses_[i].alive = false;
  }
  return Status::ok;
}

}  // namespace relnav
