#pragma once
#include <array>

#include "fsw/base/slot_pool.hpp"
#include "fsw/base/status.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// Batch adjustment of the first seconds of a rigid target's motion, one Gauss-Newton step at a time.
///
/// Three hypotheses are adjusted side by side: turning with the relief one way, turning with it the other way, at rest.
/// They are compared by Laplace's approximation of their evidence, not by their cost: among fits of equal quality the
/// joint minimum favours fast rates with flat relief, since every depth has a prior of its own that likes flat.
///
/// Why: far away, rate times relief is what the image shows (bas-relief ambiguity), and its mirror image fits almost as
/// well. A filter linearised at rate zero and flat relief sees neither and settles on a wrong pair for good. The motion
/// of the first seconds has only twelve parameters, so all of it can be relinearised in every frame at the price of a few
/// filter updates, for both signs of the relief; the filter is then set to the better one with its covariance.
///
/// Model, times from the first frame, T placed there with axes parallel to C:
///   centre c(t) = c + v t, attitude R_CT(t) = Exp(omega t + alpha t^2 / 2), theta = [c v omega alpha] (12);
///   a track p = (x y rho) first seen at t_a: n = (x y 1), h(t) = R(t) R(t_a)' (n - rho c(t_a)) + rho c(t), rho = 1 / depth.
/// Residuals are normalised image coordinates, Huber-weighted; priors on theta and every track are part of the cost.
/// The tracks are eliminated (Schur complement), so a step costs one 12 x 12 Cholesky and a pass over the observations.
class StartAdjustment {
 public:
  static constexpr int theta_size = 12;
  static constexpr std::size_t max_keyframes = 16;
  using Theta = Mat<12>;
  using Mat12 = Mat<12, 12>;

  struct Prior {
    Vec3 c_C = Vec3::Zero();   ///< m
    double half_extent = 0.1;  ///< apparent half width over distance
    double relief = 0.1;       ///< depth spread over distance
    double c_sigma_m = 1.0;
    double v_sigma_m_s = 1.0;
    double omega_sigma_rad_s = 1.0;
    double rest_sigma_rad_s = 0.1;  ///< same for the hypothesis that the target hardly turns
    double angular_psd = 0.0;       ///< rad/s^1.5; sets how much alpha may be
  };

  void begin(const Prior& prior);
  /// A feature first seen at time t_s (from the first frame) at p = (x y rho), with the sigma of x, y and of rho.
  void add_track(SlotHandle slot, double t_s, const Vec3& p, double xy_sigma, double rho_sigma);
  void drop_track(SlotHandle slot);

  /// Opens a frame's column of observations. Frames are thinned evenly once max_keyframes are stored.
  void begin_frame(double t_s);
  void observe(SlotHandle slot, const Vec2& xy, double sigma);
  /// Improves every hypothesis by at most `steps` damped Gauss-Newton steps each.
  void improve(int steps);

  static constexpr std::size_t hypothesis_count = 3;

  /// What the best hypothesis says of one feature: p = (x y rho) at its first sight and its dependence on theta.
  struct TrackResult {
    Vec3 p = Vec3::Zero();
    Mat<3, 12> dp_dtheta = Mat<3, 12>::Zero();  ///< of the conditional mean
    Mat3 covariance = Mat3::Zero();             ///< of p given theta
    double t_s = 0.0;
  };
  struct Result {
    Theta theta = Theta::Zero();
    Mat12 covariance = Mat12::Identity();
    std::array<Theta, hypothesis_count> thetas{};            ///< of each hypothesis
    std::array<double, hypothesis_count> weights{};          ///< their posterior probabilities, sum 1
    std::array<TrackResult, config::max_features> tracks{};  ///< by slot index; valid where has_track()
  };
  /// no_convergence: no hypothesis has a finite, positive definite solution yet; `out` is then incomplete.
  Status result(Result& out);
  [[nodiscard]] bool has_track(SlotHandle slot) const;
  [[nodiscard]] double span_s() const { return keyframes_ == 0 ? 0.0 : frame_t_s_[keyframes_ - 1]; }

 private:
  struct Track {
    SlotHandle slot;
    bool used = false;
    double t_s = 0.0;
    Vec3 prior = Vec3::Zero();   ///< x, y, rho
    Vec3 weight = Vec3::Zero();  ///< inverse variances
  };
  struct Observation {
    double x = 0.0;
    double y = 0.0;
    double sigma = 0.0;  ///< 0: not seen
  };
  struct Hypothesis {
    Theta theta = Theta::Zero();
    std::array<Vec3, config::max_features> p{};  ///< tracks: x, y, rho
    double omega_sigma_rad_s = 1.0;
    double damping = 1e-3;
    double cost = 0.0;
    bool alive = true;  ///< still in the race
  };
  struct Normal {
    Mat12 A = Mat12::Zero();
    Theta b = Theta::Zero();
    std::array<Mat<12, 3>, config::max_features> W{};  ///< theta-track blocks
    std::array<Mat3, config::max_features> H{};        ///< track blocks; zero where there is no track
    std::array<Vec3, config::max_features> g{};
    double cost = 0.0;
  };
  struct FrameMotion {
    Mat3 R;
    Mat3 Jl;  ///< left Jacobian of the rotation vector
    Vec3 c;
  };
  [[nodiscard]] static FrameMotion motion_at(const Theta& theta, double t_s);
  [[nodiscard]] double alpha_sigma() const;
  void linearise(const Hypothesis& at, Normal& out) const;
  [[nodiscard]] double cost_of(const Hypothesis& at) const;
  /// Subtracts W H^-1 W' and W H^-1 g of every track from A and b (lower triangle); H is damped.
  static void eliminate_tracks(const Normal& normal, double damping, Mat12& S, Theta& b);
  /// Solves the damped normal equations; false when not positive definite.
  [[nodiscard]] static bool solve(const Normal& normal, double damping, Theta& d_theta,
                                  std::array<Vec3, config::max_features>& d_p);
  /// One damped Gauss-Newton step. False when it has gained so little that the hypothesis can be left for this frame.
  bool step(Hypothesis& hypothesis);
  void mirror(const Hypothesis& from, Hypothesis& to) const;

  Prior prior_;
  std::array<Track, config::max_features> tracks_{};
  std::array<double, max_keyframes> frame_t_s_{};
  std::array<std::array<Observation, config::max_features>, max_keyframes> observed_{};
  std::size_t keyframes_ = 0;
  std::uint32_t frames_seen_ = 0;
  std::uint32_t stride_ = 1;
  [[nodiscard]] Theta prior_weights(const Hypothesis& h) const;
  [[nodiscard]] Theta prior_mean() const;
  /// Minus the logarithm of the evidence, up to a constant common to all hypotheses. S: Cholesky factor of the reduced A.
  [[nodiscard]] double negative_log_evidence(const Hypothesis& h, const Normal& normal, const Mat12& L) const;

  std::array<Hypothesis, hypothesis_count> hypotheses_{};
  Normal normal_;
};

}  // namespace relnav
