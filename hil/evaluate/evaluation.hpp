#pragma once
#include <optional>
#include <string>
#include <vector>

#include "hil/evaluate/alignment.hpp"
#include "hil/evaluate/association.hpp"
#include "hil/io/covariance_csv.hpp"
#include "hil/io/trajectory.hpp"

namespace relnav::hil {

enum class AlignMode { none, se3, sim3, start };

/// Errors at one common epoch after alignment.
struct EpochError {
  Time time;
  Vec3 position =
      Vec3::Zero();  ///< m of the truth; none, start: in C; se3, sim3: of the camera centre, in the truth's T
  Vec3 attitude = Vec3::Zero();  ///< rotation vector in C, rad: R_true = Exp([attitude x]) R_est
  std::optional<double> nees;
};

/// Rate over a window, by difference of poses: see RateStatistics.
struct EpochRate {
  Time time;
  Vec3 truth_omega_C = Vec3::Zero();  ///< rad/s
  Vec3 estimate_omega_C = Vec3::Zero();
  Vec3 truth_v_C = Vec3::Zero();  ///< m/s, of the aligned positions t_CT
  Vec3 estimate_v_C = Vec3::Zero();
};

struct ErrorStatistics {
  double rms = 0.0;
  double mean = 0.0;
  double max = 0.0;  ///< of the norm
  Time max_time;
  double last = 0.0;
  Vec3 rms_axis = Vec3::Zero();
  Vec3 max_axis = Vec3::Zero();
};

struct NeesStatistics {
  int degrees_of_freedom = 0;
  std::size_t epochs = 0;
  std::size_t without_covariance = 0;
  std::size_t not_positive_definite = 0;
  double mean = 0.0;
  double mean_low = 0.0, mean_high = 0.0;    ///< 95 % band of the mean, were the epochs independent
  double epoch_low = 0.0, epoch_high = 0.0;  ///< 95 % band of one epoch
  double inside = 0.0;                       ///< share of epochs inside it
};

struct Evaluation {
  AlignMode align = AlignMode::none;
  std::size_t truth_poses = 0;
  std::size_t estimate_poses = 0;
  Association association;
  std::vector<Time> missing;
  std::optional<Similarity> similarity;
  /// se3, sim3: RMS of the position, m, were the rotation taken from the attitudes instead of the positions. None when there is
  /// no such alignment: seen with its own attitudes the estimate then moves against the truth (a mirrored solution).
  std::optional<double> position_rms_by_attitudes;
  std::optional<BodyPointFit> body_point;
  std::vector<EpochError> epochs;
  ErrorStatistics position;
  ErrorStatistics attitude;
  double extent = 0.0;        ///< largest distance between two reference positions, m of the truth
  double angle_turned = 0.0;  ///< by the truth between first and last common epoch: sum of the steps, rad
  std::vector<EpochRate> rates;
  Duration rate_window;
  ErrorStatistics rate;          ///< rad/s, of the vector difference
  ErrorStatistics velocity;      ///< m/s
  double truth_mean_rate = 0.0;  ///< angle over time, windows end to end, rad/s
  double estimate_mean_rate = 0.0;
  std::optional<NeesStatistics> nees;
};

/// Throws std::runtime_error when there is no common epoch or the alignment is impossible.
[[nodiscard]] Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate,
                                  const std::vector<TimedCovariance>* covariances, AlignMode align);

[[nodiscard]] const char* to_string(AlignMode align);
[[nodiscard]] std::string evaluation_text(const Evaluation& evaluation);
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation);

}  // namespace relnav::hil
