#include "fsw/estimation/start_bundle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/attitude/so3.hpp"
#include "fsw/math/covariance_kernels.hpp"
#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

/// Cauchy's loss halves the weight of a residual of this many sigmas.
constexpr double loss_scale = 1.5;
constexpr double loss_scale2 = loss_scale * loss_scale;
/// Matching errors last about three keyframes (measured against the truth: correlation 0.2 to 0.6 after a frame, gone after
/// one to two seconds), so an observation counts for a third of a new one.
constexpr double temperature = 3.0;
constexpr double most_excess = 1e12;  ///< of a squared residual: the product over a track's keyframes stays in range
constexpr double least_rho_fraction = 0.05;  ///< of a track's prior inverse depth that a step may reach
constexpr double most_rho_fraction = 5.0;
constexpr std::size_t min_observations = 3;  ///< a track that has ended with fewer says nothing
constexpr double worst_cost = std::numeric_limits<double>::infinity();

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

MatrixView theta_view(Mat<12, 12>& m) { return {m.data(), 12, 12, 12}; }

}  // namespace

// ---- tracks and frames ----

void StartBundle::begin(const Prior& prior) {
  prior_ = prior;
  for (Track& t : tracks_) t.used = t.live = false;
  track_of_slot_.fill(static_cast<std::uint16_t>(max_tracks));
  keyframes_ = 0;
  frames_seen_ = 0;
  stride_ = 1;
  used_tracks_ = 0.0;
}

std::size_t StartBundle::track_of(SlotHandle slot) const {
  const std::size_t j = track_of_slot_[slot.index];
  return j < max_tracks && tracks_[j].slot == slot ? j : max_tracks;
}

std::size_t StartBundle::observations_of(std::size_t track) const {
  std::size_t count = 0;
  for (std::size_t k = 0; k < keyframes_; ++k) count += observed_[track][k].sigma > 0.0 ? 1U : 0U;
  return count;
}

void StartBundle::count_tracks() {
  used_tracks_ = 0.0;
  for (const Track& t : tracks_) used_tracks_ += t.used ? 1.0 : 0.0;
}

std::size_t StartBundle::free_track() const {
  std::size_t best = max_tracks;
  std::size_t fewest = max_keyframes + 1;
  for (std::size_t j = 0; j < max_tracks; ++j) {
    if (!tracks_[j].used) return j;
    if (tracks_[j].live) continue;
    const std::size_t count = observations_of(j);
    if (count < fewest) {
      fewest = count;
      best = j;
    }
  }
  RELNAV_ASSERT(best < max_tracks);  // fewer features than tracks: one has ended
  return best;
}

std::size_t StartBundle::add_track(SlotHandle slot, double t_s, const Vec3& p, double xy_sigma, double rho_sigma) {
  const std::size_t j = free_track();
  track_of_slot_[slot.index] = static_cast<std::uint16_t>(j);
  Track& track = tracks_[j];
  track.slot = slot;
  track.used = track.live = true;
  track.t_s = t_s;
  track.prior = p;
  const double xy_information = 1.0 / (xy_sigma * xy_sigma);
  track.information = Vec3(xy_information, xy_information, 1.0 / (rho_sigma * rho_sigma));
  for (Observation& o : observed_[j]) o.sigma = 0.0;
  count_tracks();
  return j;
}

void StartBundle::end_track(SlotHandle slot) {
  const std::size_t j = track_of(slot);
  if (j == max_tracks) return;
  tracks_[j].live = false;
  tracks_[j].used = observations_of(j) >= min_observations;
  track_of_slot_[slot.index] = static_cast<std::uint16_t>(max_tracks);
  count_tracks();
}

void StartBundle::thin_keyframes() {
  for (std::size_t k = 0; 2 * k < max_keyframes; ++k) frame_t_s_[k] = frame_t_s_[2 * k];
  keyframes_ = max_keyframes / 2;
  stride_ *= 2;
  for (std::size_t j = 0; j < max_tracks; ++j) {
    Track& track = tracks_[j];
    if (!track.used) continue;
    for (std::size_t k = 0; k < keyframes_; ++k) observed_[j][k] = observed_[j][2 * k];
    track.used = track.live || observations_of(j) >= min_observations;
  }
  count_tracks();
}

void StartBundle::begin_frame(double t_s) {
  // The newest frame stands last. It stays only when its turn in the stride has come; else the next one takes its place.
  const bool keep_last = keyframes_ == 0 || (frames_seen_ - 1) % stride_ == 0;
  if (keep_last && keyframes_ == max_keyframes) thin_keyframes();
  if (keep_last) ++keyframes_;
  ++frames_seen_;
  frame_t_s_[keyframes_ - 1] = t_s;
  for (auto& observations : observed_) observations[keyframes_ - 1].sigma = 0.0;
}

void StartBundle::observe(SlotHandle slot, const Vec2& xy, double sigma) {
  const std::size_t j = track_of(slot);
  if (keyframes_ == 0 || j == max_tracks) return;
  observed_[j][keyframes_ - 1] = {xy(0), xy(1), sigma};
}

void StartBundle::clamp_depth(std::size_t track, Vec3& p) const {
  const double rho = tracks_[track].prior(2);
  p(2) = std::clamp(p(2), least_rho_fraction * rho, most_rho_fraction * rho);
}

// ---- cost ----

Vec3 StartBundle::rotation_vector_C(const Theta& theta, double t_s) {
  return t_s * theta.segment<3>(6) + (0.5 * t_s * t_s) * theta.segment<3>(9);
}

Vec3 StartBundle::centre_C(const Theta& theta, double t_s) { return theta.head<3>() + t_s * theta.segment<3>(3); }

StartBundle::FrameMotion StartBundle::motion_at(const Theta& theta, double t_s) {
  const Vec3 phi = rotation_vector_C(theta, t_s);
  return {exp_so3(phi), left_jacobian_so3(phi), centre_C(theta, t_s)};
}

void StartBundle::frame_motions(const Theta& theta, std::array<FrameMotion, max_keyframes>& frames) const {
  for (std::size_t k = 0; k < keyframes_; ++k) frames[k] = motion_at(theta, frame_t_s_[k]);
}

StartBundle::Theta StartBundle::prior_information(double omega_sigma_rad_s) const {
  // A rate that walks with density q strays by q sqrt(T) over T; a constant alpha does the same with q / sqrt(T). A target
  // that is nearly at rest does not accelerate much either.
  const double share = omega_sigma_rad_s / prior_.omega_sigma_rad_s;
  const double alpha_sigma = share * prior_.angular_psd / std::sqrt(std::max(span_s(), 1.0));
  const double sigma[4] = {prior_.c_lateral_sigma_m, prior_.v_sigma_m_s, omega_sigma_rad_s, alpha_sigma};
  Theta information;
  for (int k = 0; k < theta_size; ++k) information(k) = 1.0 / (sigma[k / 3] * sigma[k / 3]);
  information(2) = 1.0 / (prior_.c_along_sigma_m * prior_.c_along_sigma_m);
  return information;
}

StartBundle::Theta StartBundle::prior_error(const Theta& theta) const {
  Theta error = -theta;
  error.head<3>() += prior_.c_C;
  return error;
}

Vec3 StartBundle::track_information(const Track& track) const {
  return {track.information(0), track.information(1), track.information(2) / used_tracks_};
}

double StartBundle::log_prior_volume(double omega_sigma_rad_s) const {
  const Theta information = prior_information(omega_sigma_rad_s);
  double sum = 0.0;
  for (int k = 0; k < theta_size; ++k) sum += 0.5 * math::log(information(k));
  return sum;
}

double StartBundle::cost_of(const Theta& theta, const Points& p, double omega_sigma_rad_s) const {
  const Theta error = prior_error(theta);
  double cost = 0.5 * error.dot(prior_information(omega_sigma_rad_s).cwiseProduct(error));
  std::array<FrameMotion, max_keyframes> frames;
  frame_motions(theta, frames);
  for (std::size_t j = 0; j < max_tracks; ++j) {
    const Track& track = tracks_[j];
    if (!track.used) continue;
    const double rho = p[j](2);
    const Vec3 track_error = track.prior - p[j];
    cost += 0.5 * track_error.dot(track_information(track).cwiseProduct(track_error));
    const FrameMotion anchor = motion_at(theta, track.t_s);
    const Vec3 x = anchor.R.transpose() * (Vec3(p[j](0), p[j](1), 1.0) - rho * anchor.c);
    double product = 1.0;
    for (std::size_t k = 0; k < keyframes_; ++k) {
      const Observation& o = observed_[j][k];
      if (!(o.sigma > 0.0)) continue;
      const Vec3 h = frames[k].R * x + rho * frames[k].c;
      if (!(h.z() > 0.0)) return worst_cost;
      const Vec2 r(o.x - h.x() / h.z(), o.y - h.y() / h.z());
      product *= 1.0 + std::min(r.squaredNorm() / (o.sigma * o.sigma * loss_scale2), most_excess);
    }
    cost += (0.5 * loss_scale2 / temperature) * math::log(product);
  }
  return cost;
}

void StartBundle::linearise(const Theta& theta, const Points& p, double omega_sigma_rad_s, Normal& out) const {
  const Theta information = prior_information(omega_sigma_rad_s);
  const Theta error = prior_error(theta);
  out.A.setZero();
  out.A.diagonal() = information;
  out.b = information.cwiseProduct(error);
  out.cost = 0.5 * error.dot(out.b);
  std::array<FrameMotion, max_keyframes> frames;
  frame_motions(theta, frames);

  for (std::size_t j = 0; j < max_tracks; ++j) {
    const Track& track = tracks_[j];
    if (!track.used) continue;
    const double rho = p[j](2);
    const Vec3 track_error = track.prior - p[j];
    const Vec3 point_information = track_information(track);
    Mat<12, 3>& W = out.W[j];
    W.setZero();
    out.H[j] = point_information.asDiagonal();
    out.g[j] = point_information.cwiseProduct(track_error);
    out.cost += 0.5 * track_error.dot(out.g[j]);

    const double ta_s = track.t_s;
    const FrameMotion anchor = motion_at(theta, ta_s);
    const Vec3 x = Vec3(p[j](0), p[j](1), 1.0) - rho * anchor.c;
    const Mat3 X_anchor = cross_matrix(x) * anchor.Jl;
    double product = 1.0;
    for (std::size_t k = 0; k < keyframes_; ++k) {
      const Observation& o = observed_[j][k];
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
      const double pixel_information = 1.0 / (o.sigma * o.sigma);
      const double excess = 1.0 + std::min(r.squaredNorm() * pixel_information / loss_scale2, most_excess);
      product *= excess;
      const double weight = pixel_information / (excess * temperature);

      Mat23 J_h;  // d(x, y) / d h
      J_h << iz, 0.0, -h.x() * iz * iz, 0.0, iz, -h.y() * iz * iz;
      const Mat23 J_h_M = J_h * M;
      const Mat23 turn_now = -((J_h * cross_matrix(q)) * f.Jl);
      const Mat23 turn_then = J_h_M * X_anchor;
      Mat<2, 12> J;
      J.block<2, 3>(0, 0) = rho * (J_h - J_h_M);
      J.block<2, 3>(0, 3) = rho * (t_s * J_h - ta_s * J_h_M);
      J.block<2, 3>(0, 6) = t_s * turn_now + ta_s * turn_then;
      J.block<2, 3>(0, 9) = (0.5 * t_s * t_s) * turn_now + (0.5 * ta_s * ta_s) * turn_then;
      Mat23 J_p;
      J_p.leftCols<2>() = J_h_M.leftCols<2>();
      J_p.col(2) = J_h * f.c - J_h_M * anchor.c;

      for (int c = 0; c < theta_size; ++c) {
        const double j0 = weight * J(0, c);
        const double j1 = weight * J(1, c);
        for (int row = c; row < theta_size; ++row) out.A(row, c) += j0 * J(0, row) + j1 * J(1, row);
        out.b(c) += j0 * r(0) + j1 * r(1);
        for (int i = 0; i < 3; ++i) W(c, i) += j0 * J_p(0, i) + j1 * J_p(1, i);
      }
      out.H[j] += weight * (J_p.transpose() * J_p);
      out.g[j] += weight * (J_p.transpose() * r);
    }
    out.cost += (0.5 * loss_scale2 / temperature) * math::log(product);
  }
}

// ---- solution ----

void StartBundle::reduce(const Normal& normal, double damping, Mat12& S, Theta& b) const {
  S = normal.A;
  b = normal.b;
  for (int k = 0; k < theta_size; ++k) S(k, k) *= 1.0 + damping;
  for (std::size_t j = 0; j < max_tracks; ++j) {
    if (!tracks_[j].used) continue;
    const Mat<12, 3> WH = normal.W[j] * damped_inverse(normal.H[j], damping);
    for (int c = 0; c < theta_size; ++c) {
      for (int r = c; r < theta_size; ++r) S(r, c) -= WH.row(r).dot(normal.W[j].row(c));
    }
    b -= WH * normal.g[j];
  }
}

bool StartBundle::solve(const Normal& normal, double damping, Theta& d_theta, Points& d_p) const {
  Mat12 S;
  Theta b;
  reduce(normal, damping, S, b);
  if (cholesky_lower(theta_view(S)) != Status::ok) return false;
  solve_lower(theta_view(S), {b.data(), static_cast<std::size_t>(theta_size)});
  for (int c = theta_size - 1; c >= 0; --c) {  // L' d = y
    double sum = b(c);
    for (int r = c + 1; r < theta_size; ++r) sum -= S(r, c) * d_theta(r);
    d_theta(c) = sum / S(c, c);
  }
  for (std::size_t j = 0; j < max_tracks; ++j) {
    if (!tracks_[j].used) continue;
    d_p[j] = damped_inverse(normal.H[j], damping) * (normal.g[j] - normal.W[j].transpose() * d_theta);
  }
  return true;
}

Mat3 StartBundle::point_covariance(const Normal& normal, std::size_t track) {
  return damped_inverse(normal.H[track], 0.0);
}

}  // namespace relnav
