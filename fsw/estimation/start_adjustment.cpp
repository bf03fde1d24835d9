#include "fsw/estimation/start_adjustment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/math/covariance_kernels.hpp"
#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

constexpr std::size_t max_tracks = StartBundle::max_tracks;
constexpr double first_damping = 1e-3;
constexpr double least_damping = 1e-9;
constexpr double most_damping = 1e6;
constexpr double small_gain = 0.1;  ///< of the cost (half a chi-square)
constexpr int steps_after_reseed = 3;
constexpr std::uint32_t frames_between_reseeds = 8;  ///< before that in each: whichever settled first would be believed
constexpr std::size_t at_rest = 2;                   ///< hypothesis that the target hardly turns
constexpr double most_excess_energy = 50.0;          ///< beyond it a weight is zero
constexpr double nearest_mirrored_depth = 0.3;       ///< over the mean depth
constexpr double worst_energy = std::numeric_limits<double>::infinity();

MatrixView view_of(Mat<12, 12>& m) { return {m.data(), 12, 12, 12}; }

}  // namespace

void StartAdjustment::begin(const Prior& prior) {
  bundle_.begin(prior.motion);
  relief_ = prior.relief;
  half_extent_ = prior.half_extent;
  for (Hypothesis& h : hypotheses_) {
    h = Hypothesis{};
    h.theta.head<3>() = prior.motion.c_C;
    h.omega_sigma_rad_s = prior.motion.omega_sigma_rad_s;
    h.damping = first_damping;
  }
  hypotheses_[at_rest].omega_sigma_rad_s = prior.rest_sigma_rad_s;
}

void StartAdjustment::add_track(SlotHandle slot, double t_s, const Vec3& p, double xy_sigma, double rho_sigma) {
  const std::size_t j = bundle_.add_track(slot, t_s, p, xy_sigma, rho_sigma);
  for (Hypothesis& h : hypotheses_) h.p[j] = p;
  if (t_s > 0.0) return;
  // A body bulges toward its viewer: the middle starts nearer than the rim. A starting value only, no prior: it tells the
  // first hypothesis which sign to try first, the second one tries the other.
  const Vec3& c_C = bundle_.prior().c_C;
  const Vec2 offset = p.head<2>() - c_C.head<2>() / c_C.z();
  const double r2 = offset.squaredNorm() / (2.0 * half_extent_ * half_extent_);
  const double bulge = relief_ * (std::min(r2, 1.0) - 0.5);
  hypotheses_[0].p[j](2) /= 1.0 + bulge;
  hypotheses_[1].p[j](2) /= 1.0 - bulge;
}

bool StartAdjustment::step(Hypothesis& h) {
  bundle_.linearise(h.theta, h.p, h.omega_sigma_rad_s, normal_);
  h.cost = normal_.cost;
  Theta d_theta;
  if (!std::isfinite(normal_.cost) || !bundle_.solve(normal_, h.damping, d_theta, tried_)) {
    h.damping = std::min(most_damping, 10.0 * h.damping);
    return true;
  }
  const Theta theta = h.theta + d_theta;
  for (std::size_t j = 0; j < max_tracks; ++j) {
    if (!bundle_.is_used(j)) continue;
    tried_[j] += h.p[j];
    bundle_.clamp_depth(j, tried_[j]);
  }
  const double cost = bundle_.cost_of(theta, tried_, h.omega_sigma_rad_s);
  if (!(cost <= h.cost)) {
    h.damping = std::min(most_damping, 10.0 * h.damping);
    return true;
  }
  const double gain = h.cost - cost;
  h.damping = std::max(least_damping, 0.1 * h.damping);
  h.theta = theta;
  h.p = tried_;
  h.cost = cost;
  return gain > small_gain;
}

void StartAdjustment::mirror(const Hypothesis& from, Hypothesis& to) const {
  // Turned over about the mean depth, turning the other way: the same picture but for perspective.
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t j = 0; j < max_tracks; ++j) {
    if (!bundle_.is_used(j)) continue;
    sum += 1.0 / from.p[j](2);
    count += 1.0;
  }
  if (!(count > 0.0)) return;
  const double mean = sum / count;
  to.theta = from.theta;
  to.p = from.p;
  to.damping = first_damping;
  to.theta(2) = 2.0 * mean - from.theta(2);
  for (const int k : {6, 7, 9, 10}) to.theta(k) = -from.theta(k);
  for (std::size_t j = 0; j < max_tracks; ++j) {
    if (!bundle_.is_used(j)) continue;
    to.p[j](2) = 1.0 / std::max(2.0 * mean - 1.0 / from.p[j](2), nearest_mirrored_depth * mean);
  }
}

void StartAdjustment::reseed() {
  const std::size_t better = hypotheses_[0].cost <= hypotheses_[1].cost ? 0 : 1;
  Hypothesis& best = hypotheses_[better];
  const Hypothesis& rest = hypotheses_[at_rest];
  if (rest.cost < best.cost) {  // both that turn have strayed, about a wrong axis for one
    best.theta = rest.theta;
    best.p = rest.p;
    best.damping = first_damping;
    best.cost = rest.cost;
  }
  Hypothesis& other = hypotheses_[1 - better];
  mirror(best, other);
  for (int i = 0; i < steps_after_reseed; ++i) {  // or it would be judged before it has settled
    if (!step(other)) break;
  }
}

void StartAdjustment::improve(int steps) {
  for (Hypothesis& h : hypotheses_) {
    for (int i = 0; i < steps; ++i) {
      if (!step(h)) break;
    }
  }
  const std::uint32_t frame = bundle_.frames_seen();
  if (frame < frames_between_reseeds || frame % frames_between_reseeds == 0) reseed();
}

void StartAdjustment::take(const Hypothesis& best, const Mat12& L, Result& out) const {
  Mat12 factor = L;
  Mat12 B = Mat12::Identity();
  solve_right_transposed(view_of(factor), view_of(B));  // B = L^-T
  out.theta = best.theta;
  out.covariance = B.lazyProduct(B.transpose());
  for (std::size_t slot = 0; slot < out.tracks.size(); ++slot) {
    const std::size_t j = bundle_.track_in_slot(slot);
    if (j == max_tracks) continue;
    TrackResult& t = out.tracks[slot];
    t.p = best.p[j];
    t.covariance = StartBundle::point_covariance(normal_, j);
    t.dp_dtheta = -(t.covariance * normal_.W[j].transpose());
    t.t_s = bundle_.first_time_s(j);
  }
}

Status StartAdjustment::result(Result& out) {
  std::array<double, hypothesis_count> energy{};
  double least = worst_energy;
  for (std::size_t i = 0; i < hypothesis_count; ++i) {
    const Hypothesis& h = hypotheses_[i];
    out.thetas[i] = h.theta;
    energy[i] = worst_energy;
    bundle_.linearise(h.theta, h.p, h.omega_sigma_rad_s, normal_);
    if (!std::isfinite(normal_.cost)) continue;
    Mat12 L;
    Theta ignored;
    bundle_.reduce(normal_, 0.0, L, ignored);
    if (cholesky_lower(view_of(L)) != Status::ok) continue;
    // Laplace: cost + 1/2 log det(Hessian) - 1/2 log det(prior information).
    energy[i] = normal_.cost - bundle_.log_prior_volume(h.omega_sigma_rad_s);
    for (int k = 0; k < StartBundle::theta_size; ++k) energy[i] += math::log(L(k, k));
    if (!(energy[i] < least)) continue;
    least = energy[i];
    take(h, L, out);
  }
  if (!std::isfinite(least)) return Status::no_convergence;
  double sum = 0.0;
  for (std::size_t i = 0; i < hypothesis_count; ++i) {
    const double excess = energy[i] - least;
    out.weights[i] = excess < most_excess_energy ? math::exp(-excess) : 0.0;
    sum += out.weights[i];
  }
  for (double& weight : out.weights) weight /= sum;
  return Status::ok;
}

}  // namespace relnav
