#include "hil/evaluate/evaluation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "hil/evaluate/chi_square.hpp"
#include "hil/evaluate/rotation.hpp"

namespace relnav::hil {
namespace {

constexpr double rate_window_s = 1.0;
constexpr std::size_t fewest_half_window_frames = 5;
constexpr double band_probability = 0.95;

template <typename Range, typename ErrorOf>
ErrorStatistics statistics_of(const Range& range, ErrorOf error_of) {
  ErrorStatistics s;
  if (range.empty()) return s;
  const auto n = static_cast<double>(range.size());
  Vec3 sum2 = Vec3::Zero();
  s.max_time = range.front().time;
  for (const auto& item : range) {
    const Vec3 error = error_of(item);
    const double norm = error.norm();
    s.mean += norm / n;
    sum2 += error.cwiseAbs2();
    s.max_axis = s.max_axis.cwiseMax(error.cwiseAbs());
    if (norm > s.max) {
      s.max = norm;
      s.max_time = item.time;
    }
    s.last = norm;
  }
  s.rms = std::sqrt(sum2.sum() / n);
  s.rms_axis = (sum2 / n).cwiseSqrt();
  return s;
}

double largest_distance(const std::vector<Vec3>& points) {
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) largest = std::max(largest, (points[i] - points[j]).norm());
  }
  return largest;
}

// Aligned pairs: `truth` and `estimate` name the same target frame and body point, in metres of the truth.
struct Aligned {
  Trajectory truth;
  Trajectory estimate;
};

Aligned common_poses(const Trajectory& truth, const Trajectory& estimate, const Association& association) {
  Aligned common;
  for (const auto& pair : association.pairs) {
    common.truth.push_back(truth[pair.truth]);
    common.estimate.push_back(estimate[pair.estimate]);
  }
  return common;
}

std::optional<double> rms_by_attitudes(const Aligned& poses, bool with_scale) {
  Similarity similarity;
  try {
    similarity = fit_similarity(poses.truth, poses.estimate, with_scale, true);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
  const Trajectory estimate = apply_similarity(similarity, poses.estimate);
  double sum = 0.0;
  for (std::size_t i = 0; i < estimate.size(); ++i)
    sum += (camera_centre(poses.truth[i]) - camera_centre(estimate[i])).squaredNorm();
  return std::sqrt(sum / static_cast<double>(estimate.size()));
}

void align_to_start(Aligned& poses, Evaluation& evaluation) {
  evaluation.body_point = fit_body_point(poses.truth, poses.estimate);
  const Mat3 truth_start = poses.truth.front().R_CT.transpose();
  const Mat3 estimate_start = poses.estimate.front().R_CT.transpose();
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    poses.truth[i].t_CT += poses.truth[i].R_CT * evaluation.body_point->b_T;
    poses.estimate[i].t_CT *= evaluation.body_point->scale;
    poses.truth[i].R_CT = poses.truth[i].R_CT * truth_start;
    poses.estimate[i].R_CT = poses.estimate[i].R_CT * estimate_start;
  }
}

void add_rates(const Aligned& poses, Evaluation& evaluation) {
  const std::size_t n = poses.truth.size();
  const double period = median_period(poses.truth).seconds();
  if (n < 3 || !(period > 0.0)) return;
  auto half = static_cast<std::size_t>(std::llround(0.5 * rate_window_s / period));
  half = std::min(std::max(half, fewest_half_window_frames), (n - 1) / 2);
  evaluation.rate_window.ns = static_cast<std::int64_t>(2 * half) * median_period(poses.truth).ns;
  const auto rate_between = [](const TimedPose& a, const TimedPose& b) {
    return Vec3(rotation_vector(b.R_CT * a.R_CT.transpose()) / (b.time - a.time).seconds());
  };
  double truth_angle = 0.0;
  double estimate_angle = 0.0;
  double angle_time = 0.0;
  for (std::size_t i = half; i + half < n; ++i) {
    const std::size_t a = i - half;
    const std::size_t b = i + half;
    const double span = (poses.truth[b].time - poses.truth[a].time).seconds();
    if (span > 1.5 * evaluation.rate_window.seconds()) continue;  // a gap
    EpochRate rate;
    rate.time = poses.truth[i].time;
    rate.truth_omega_C = rate_between(poses.truth[a], poses.truth[b]);
    rate.estimate_omega_C = rate_between(poses.estimate[a], poses.estimate[b]);
    rate.truth_v_C = (poses.truth[b].t_CT - poses.truth[a].t_CT) / span;
    rate.estimate_v_C = (poses.estimate[b].t_CT - poses.estimate[a].t_CT) / span;
    if (a % (2 * half) == 0) {
      truth_angle += rate.truth_omega_C.norm() * span;
      estimate_angle += rate.estimate_omega_C.norm() * span;
      angle_time += span;
    }
    evaluation.rates.push_back(rate);
  }
  if (angle_time > 0.0) {
    evaluation.truth_mean_rate = truth_angle / angle_time;
    evaluation.estimate_mean_rate = estimate_angle / angle_time;
  }
  evaluation.rate =
      statistics_of(evaluation.rates, [](const EpochRate& r) { return Vec3(r.truth_omega_C - r.estimate_omega_C); });
  evaluation.velocity =
      statistics_of(evaluation.rates, [](const EpochRate& r) { return Vec3(r.truth_v_C - r.estimate_v_C); });
}

// d' P^-1 d, or nothing when P is not positive definite (to rounding).
template <int N>
std::optional<double> normalised_square(const Mat<N>& d, const Mat<N, N>& P) {
  const Mat<N> scale = P.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) return std::nullopt;
  const Mat<N, N> correlation = scale.cwiseInverse().asDiagonal() * P * scale.cwiseInverse().asDiagonal();
  const Eigen::LLT<Mat<N, N>> llt(correlation);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Mat<N> whitened = llt.matrixL().solve(Mat<N>(d.cwiseQuotient(scale)));
  return whitened.squaredNorm();
}

std::optional<double> nees_of(const Evaluation& evaluation, const Aligned& poses, std::size_t i, const Mat6& P) {
  const Vec3 dphi = evaluation.epochs[i].attitude;
  if (evaluation.align == AlignMode::start) {
    return normalised_square<3>(dphi, Mat3(P.bottomRightCorner<3, 3>()));
  }
  Vec6 d;
  d << poses.truth[i].t_CT - poses.estimate[i].t_CT, dphi;
  if (!evaluation.similarity) return normalised_square<6>(d, P);
  // Aligned t' = s t - R' t_a with R' = R R_a'; hence dt' = s dt + [R' t_a x] dphi.
  Mat6 J = Mat6::Identity();
  J.topLeftCorner<3, 3>() *= evaluation.similarity->scale;
  J.topRightCorner<3, 3>() = cross_matrix(poses.estimate[i].R_CT * evaluation.similarity->t);
  return normalised_square<6>(d, Mat6(J * P * J.transpose()));
}

void add_nees(const Aligned& poses, const std::vector<TimedCovariance>& covariances, Evaluation& evaluation) {
  constexpr std::int64_t same_stamp_ns = 1000;
  std::map<std::int64_t, const Mat6*> by_time;
  for (const TimedCovariance& covariance : covariances) by_time[covariance.time.ns] = &covariance.P;
  NeesStatistics nees;
  nees.degrees_of_freedom = evaluation.align == AlignMode::start ? 3 : 6;
  double sum = 0.0;
  const double tail = 0.5 * (1.0 - band_probability);
  nees.epoch_low = chi_square_quantile(tail, nees.degrees_of_freedom);
  nees.epoch_high = chi_square_quantile(1.0 - tail, nees.degrees_of_freedom);
  // Referred to the first epoch there is no error at it.
  for (std::size_t i = evaluation.align == AlignMode::start ? 1 : 0; i < evaluation.epochs.size(); ++i) {
    const auto found = by_time.lower_bound(poses.estimate[i].time.ns - same_stamp_ns);
    if (found == by_time.end() || found->first > poses.estimate[i].time.ns + same_stamp_ns) {
      ++nees.without_covariance;
      continue;
    }
    const auto value = nees_of(evaluation, poses, i, *found->second);
    if (!value) {
      ++nees.not_positive_definite;
      continue;
    }
    evaluation.epochs[i].nees = value;
    sum += *value;
    ++nees.epochs;
    if (*value >= nees.epoch_low && *value <= nees.epoch_high) nees.inside += 1.0;
  }
  if (nees.epochs > 0) {
    const auto n = static_cast<double>(nees.epochs);
    nees.mean = sum / n;
    nees.inside /= n;
    nees.mean_low = chi_square_quantile(tail, n * nees.degrees_of_freedom) / n;
    nees.mean_high = chi_square_quantile(1.0 - tail, n * nees.degrees_of_freedom) / n;
  }
  evaluation.nees = nees;
}

}  // namespace

Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate,
                    const std::vector<TimedCovariance>* covariances, AlignMode align) {
  Evaluation evaluation;
  evaluation.align = align;
  evaluation.truth_poses = truth.size();
  evaluation.estimate_poses = estimate.size();
  evaluation.association = associate(truth, estimate);
  for (const std::size_t i : evaluation.association.missing) evaluation.missing.push_back(truth[i].time);
  if (evaluation.association.pairs.empty()) {
    throw std::runtime_error("truth and estimate have no epoch in common (stamps must agree within " +
                             std::to_string(evaluation.association.tolerance.ns) + " ns)");
  }
  Aligned poses = common_poses(truth, estimate, evaluation.association);
  for (std::size_t i = 1; i < poses.truth.size(); ++i) {
    evaluation.angle_turned += rotation_vector(poses.truth[i].R_CT * poses.truth[i - 1].R_CT.transpose()).norm();
  }
  const bool in_T = align == AlignMode::se3 || align == AlignMode::sim3;
  std::vector<Vec3> path;
  for (const TimedPose& pose : poses.truth) path.push_back(in_T ? camera_centre(pose) : pose.t_CT);
  evaluation.extent = largest_distance(path);
  if (in_T) {
    const bool with_scale = align == AlignMode::sim3;
    evaluation.similarity = fit_similarity(poses.truth, poses.estimate, with_scale);
    evaluation.position_rms_by_attitudes = rms_by_attitudes(poses, with_scale);
    poses.estimate = apply_similarity(*evaluation.similarity, poses.estimate);
  } else if (align == AlignMode::start) {
    align_to_start(poses, evaluation);
  }
  for (std::size_t i = 0; i < poses.truth.size(); ++i) {
    const TimedPose& t = poses.truth[i];
    const TimedPose& e = poses.estimate[i];
    EpochError error;
    error.time = t.time;
    error.position = in_T ? Vec3(camera_centre(t) - camera_centre(e)) : Vec3(t.t_CT - e.t_CT);
    error.attitude = rotation_vector(t.R_CT * e.R_CT.transpose());
    evaluation.epochs.push_back(error);
  }
  evaluation.position = statistics_of(evaluation.epochs, [](const EpochError& e) { return e.position; });
  evaluation.attitude = statistics_of(evaluation.epochs, [](const EpochError& e) { return e.attitude; });
  add_rates(poses, evaluation);
  if (covariances != nullptr) add_nees(poses, *covariances, evaluation);
  return evaluation;
}

const char* to_string(AlignMode align) {
  switch (align) {
    case AlignMode::none: return "none";
    case AlignMode::se3: return "se3";
    case AlignMode::sim3: return "sim3";
    case AlignMode::start: return "start";
  }
  return "?";
}

}  // namespace relnav::hil
