#pragma once
#include <array>

#include "fsw/base/slot_pool.hpp"
#include "fsw/config.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// The observations of a rigid target's first seconds and the cost of a motion that is to explain them.
///
/// Model, times from the first frame, T placed there with axes parallel to C:
///   centre c(t) = c + v t, attitude R_CT(t) = Exp(omega t + alpha t^2 / 2), theta = [c v omega alpha] (12);
///   a track p = (x y rho) first seen at t_a: n = (x y 1), h(t) = R(t) R(t_a)' (n - rho c(t_a)) + rho c(t), rho = 1 / depth.
/// Residuals are normalised image coordinates under Cauchy's loss s^2/2 log(1 + r^2 / s^2) (glints that slide must not
/// count), tempered: matching errors repeat from frame to frame, and each of them is worth a fraction of a new one.
/// Priors: theta; x, y of every track's first sight; and the depths of all tracks together as if they were one track. Depths
/// of a surface go together: a prior of its own on each would flatten the relief and speed up the rate.
///
/// Tracks of features that are gone keep their observations while there is room. Fixed memory, no allocation.
class StartBundle {
 public:
  static constexpr int theta_size = 12;
  static constexpr std::size_t max_keyframes = 16;
  static constexpr std::size_t max_tracks =
      2 * config::max_features;  ///< of features in the filter, and of some that are gone
  using Theta = Mat<12>;
  using Mat12 = Mat<12, 12>;
  using Points = std::array<Vec3, max_tracks>;  ///< x, y, rho of every track

  struct Prior {
    Vec3 c_C = Vec3::Zero();  ///< m. Its distance is the scale of everything
    double c_lateral_sigma_m = 1.0;
    double c_along_sigma_m = 1.0;  ///< along the optical axis
    double v_sigma_m_s = 1.0;
    double omega_sigma_rad_s = 1.0;
    double angular_psd = 0.0;  ///< rad/s^1.5: how much the rate may stray; sets the spread of alpha
  };
  /// Gauss-Newton normal equations, the tracks' part in blocks.
  struct Normal {
    Mat12 A = Mat12::Zero();  ///< lower triangle
    Theta b = Theta::Zero();
    std::array<Mat<12, 3>, max_tracks> W{};  ///< theta against track
    std::array<Mat3, max_tracks> H{};        ///< track blocks
    Points g{};
    double cost = 0.0;
  };

  /// The model's motion since the first frame: rotation vector of R_CT (rad) and centre (m), in C.
  [[nodiscard]] static Vec3 rotation_vector_C(const Theta& theta, double t_s);
  [[nodiscard]] static Vec3 centre_C(const Theta& theta, double t_s);

  void begin(const Prior& prior);
  [[nodiscard]] const Prior& prior() const { return prior_; }
  /// Follows a feature first seen at time t_s (from the first frame) at p = (x y rho); sigmas of x, y and of rho. Its index.
  std::size_t add_track(SlotHandle slot, double t_s, const Vec3& p, double xy_sigma, double rho_sigma);
  /// The feature will not be seen again; what was seen of it still counts.
  void end_track(SlotHandle slot);
  /// Opens a frame's column of observations. Frames are thinned evenly once max_keyframes are stored.
  void begin_frame(double t_s);
  void observe(SlotHandle slot, const Vec2& xy, double sigma);

  /// Index of the feature's track, or max_tracks.
  [[nodiscard]] std::size_t track_of(SlotHandle slot) const;
  /// Index of the track of whatever feature is in a slot, or max_tracks.
  [[nodiscard]] std::size_t track_in_slot(std::size_t slot) const { return track_of_slot_[slot]; }
  /// Whether the index holds a track whose observations count.
  [[nodiscard]] bool is_used(std::size_t track) const { return tracks_[track].used; }
  [[nodiscard]] double first_time_s(std::size_t track) const { return tracks_[track].t_s; }
  [[nodiscard]] double span_s() const { return keyframes_ == 0 ? 0.0 : frame_t_s_[keyframes_ - 1]; }
  [[nodiscard]] std::uint32_t frames_seen() const { return frames_seen_; }

  // Cost and equations for a hypothesis whose rate has the given prior sigma. Infinite where a point lies behind the camera.
  [[nodiscard]] double cost_of(const Theta& theta, const Points& p, double omega_sigma_rad_s) const;
  void linearise(const Theta& theta, const Points& p, double omega_sigma_rad_s, Normal& out) const;
  /// S = A - sum W H^-1 W' (lower triangle), b = b - sum W H^-1 g, diagonals raised by the factor 1 + damping.
  void reduce(const Normal& normal, double damping, Mat12& S, Theta& b) const;
  /// Damped step. False when the reduced matrix is not positive definite.
  [[nodiscard]] bool solve(const Normal& normal, double damping, Theta& d_theta, Points& d_p) const;
  /// H^-1 of a track: covariance of its point when theta is known.
  [[nodiscard]] static Mat3 point_covariance(const Normal& normal, std::size_t track);
  /// Half the logarithm of the determinant of theta's prior information.
  [[nodiscard]] double log_prior_volume(double omega_sigma_rad_s) const;
  /// Keeps a point's depth within bounds about its prior.
  void clamp_depth(std::size_t track, Vec3& p) const;

 private:
  struct Track {
    SlotHandle slot;
    bool used = false;
    bool live = false;  ///< its feature is in the filter
    double t_s = 0.0;
    Vec3 prior = Vec3::Zero();        ///< x, y, rho
    Vec3 information = Vec3::Zero();  ///< inverse variances; that of rho is shared by all tracks
  };
  struct Observation {
    double x = 0.0;
    double y = 0.0;
    double sigma = 0.0;  ///< 0: not seen
  };
  struct FrameMotion {
    Mat3 R;
    Mat3 Jl;  ///< left Jacobian of the rotation vector
    Vec3 c;
  };
  [[nodiscard]] static FrameMotion motion_at(const Theta& theta, double t_s);
  void frame_motions(const Theta& theta, std::array<FrameMotion, max_keyframes>& frames) const;
  [[nodiscard]] Theta prior_information(double omega_sigma_rad_s) const;
  [[nodiscard]] Theta prior_error(const Theta& theta) const;
  [[nodiscard]] Vec3 track_information(const Track& track) const;
  [[nodiscard]] std::size_t observations_of(std::size_t track) const;
  [[nodiscard]] std::size_t free_track() const;
  void thin_keyframes();
  void count_tracks();

  Prior prior_;
  std::array<Track, max_tracks> tracks_{};
  std::array<std::uint16_t, config::max_features> track_of_slot_{};
  std::array<double, max_keyframes> frame_t_s_{};
  std::array<std::array<Observation, max_keyframes>, max_tracks> observed_{};
  std::size_t keyframes_ = 0;
  std::uint32_t frames_seen_ = 0;
  std::uint32_t stride_ = 1;
  double used_tracks_ = 0.0;
};

}  // namespace relnav
