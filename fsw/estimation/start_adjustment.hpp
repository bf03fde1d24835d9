#pragma once
#include <array>

#include "fsw/base/status.hpp"
#include "fsw/estimation/start_bundle.hpp"

namespace relnav {

/// Batch adjustment of the first seconds of a rigid target's motion, one Gauss-Newton step at a time.
///
/// Why: far away, rate times relief is what the image shows (bas-relief ambiguity), and its mirror image fits almost as
/// well. A filter linearised at rate zero and flat relief sees neither and settles on a wrong pair for good. The motion
/// of the first seconds has only twelve parameters (StartBundle), so all of it can be relinearised in every frame at the
/// price of a filter update.
///
/// Three hypotheses are adjusted side by side: turning, turning the other way with the relief turned over, hardly turning.
/// They are weighed by Laplace's approximation of their evidence over theta. The depths do not enter it: a fast rate with
/// flat relief and a slow one with deep relief explain the same flow, and a volume factor per track would let the number
/// of tracks decide between them.
class StartAdjustment {
 public:
  static constexpr std::size_t hypothesis_count = 3;
  using Theta = StartBundle::Theta;
  using Mat12 = StartBundle::Mat12;

  struct Prior {
    StartBundle::Prior motion;
    double rest_sigma_rad_s = 0.1;  ///< rate of a target that hardly turns
    double half_extent = 0.1;       ///< apparent half width over distance
    double relief = 0.1;            ///< depth spread over distance
  };

  void begin(const Prior& prior);
  /// Follows a feature first seen at time t_s (from the first frame) at p = (x y rho); sigmas of x, y and of rho.
  void add_track(SlotHandle slot, double t_s, const Vec3& p, double xy_sigma, double rho_sigma);
  void end_track(SlotHandle slot) { bundle_.end_track(slot); }
  void begin_frame(double t_s) { bundle_.begin_frame(t_s); }
  void observe(SlotHandle slot, const Vec2& xy, double sigma) { bundle_.observe(slot, xy, sigma); }
  /// Improves every hypothesis by at most `steps` damped Gauss-Newton steps.
  void improve(int steps);

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
  [[nodiscard]] bool has_track(SlotHandle slot) const { return bundle_.track_of(slot) < StartBundle::max_tracks; }
  [[nodiscard]] double span_s() const { return bundle_.span_s(); }

 private:
  struct Hypothesis {
    Theta theta = Theta::Zero();
    StartBundle::Points p{};
    double omega_sigma_rad_s = 1.0;
    double damping = 1e-3;
    double cost = 0.0;
  };
  /// One damped Gauss-Newton step. False when it has gained so little that the hypothesis can be left for this frame.
  bool step(Hypothesis& hypothesis);
  /// The two that turn start again from the best of all and from its mirror image.
  void reseed();
  void mirror(const Hypothesis& from, Hypothesis& to) const;
  void take(const Hypothesis& best, const Mat12& L, Result& out) const;

  StartBundle bundle_;
  double relief_ = 0.1;
  double half_extent_ = 0.1;
  std::array<Hypothesis, hypothesis_count> hypotheses_{};
  StartBundle::Normal normal_;
  StartBundle::Points tried_{};  ///< scratch of step()
};

}  // namespace relnav
