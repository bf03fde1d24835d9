#include "fsw/estimation/pose_outliers.hpp"

#include "fsw/base/generator.hpp"
#include "fsw/math/chi_square.hpp"

namespace relnav {
namespace {

constexpr std::size_t least_observations = 5;
constexpr std::size_t subset_size = 4;
constexpr int refinements = 3;

std::size_t count_of(const ObservationMask& used, std::size_t size) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < size; ++i) count += used[i] ? 1U : 0U;
  return count;
}

struct Problem {
  const CameraRig& rig;
  const TargetModel& target;
  const PoseObservations& observations;
  const AcquisitionSettings& acquisition;
  const OutlierSettings& settings;
  std::size_t least = least_observations;  ///< observations that must remain

  [[nodiscard]] double residual2(std::size_t i, const Pose& pose) const {
    Vec2 r;
    constexpr double far_off = 1e12;
    return whitened_residual(rig, target, observations[i], pose, r) == Status::ok ? r.squaredNorm() : far_off;
  }
  Status solve(const ObservationMask& used, const Pose& start, PoseEstimate& out) const {
    return solve_pose(rig, target, observations, used, start, acquisition.solver, out);
  }
};

/// Leaves out the worst, one by one.
bool drop_worst(const Problem& problem, const Pose& start, ObservationMask& used, PoseEstimate& out) {
  PoseEstimate estimate;
  Pose pose = start;
  for (std::size_t left = count_of(used, problem.observations.size()); left >= problem.least; --left) {
    if (problem.solve(used, pose, estimate) != Status::ok) return false;
    if (!is_alarming(estimate, problem.settings)) {
      out = estimate;
      return true;
    }
    pose = estimate.pose;
    std::size_t worst = 0;
    double most = -1.0;
    for (std::size_t i = 0; i < problem.observations.size(); ++i) {
      if (!used[i]) continue;
      const double r2 = problem.residual2(i, pose);
      if (r2 > most) {
        most = r2;
        worst = i;
      }
    }
    used[worst] = false;
  }
  return false;
}

/// All of `candidates` that agree with a pose; their number.
std::size_t agreeing(const Problem& problem, const ObservationMask& candidates, const Pose& pose,
                     ObservationMask& agree) {
  const double gate2 = problem.settings.gate_sigma * problem.settings.gate_sigma;
  std::size_t count = 0;
  agree.fill(false);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    agree[i] = candidates[i] && problem.residual2(i, pose) < gate2;
    count += agree[i] ? 1U : 0U;
  }
  return count;
}

bool find_consensus(const Problem& problem, ObservationMask& used, PoseEstimate& out) {
  BoundedVector<std::size_t, config::max_observations> pool;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (used[i]) RELNAV_ASSERT(pool.push_back(i) == Status::ok);
  }
  Generator generator(problem.settings.seed);
  std::size_t most = problem.least - 1;
  ObservationMask best_mask{};
  PoseEstimate best;
  for (int h = 0; h < problem.settings.max_hypotheses && most < pool.size(); ++h) {
    // The first four of a shuffle.
    ObservationMask subset{};
    for (std::size_t k = 0; k < subset_size; ++k) {
      const std::size_t other = k + generator.below(static_cast<std::uint32_t>(pool.size() - k));
      const std::size_t drawn = pool[other];
      pool[other] = pool[k];
      pool[k] = drawn;
      subset[drawn] = true;
    }
    AcquiredPose acquired;
    if (acquire_pose(problem.rig, problem.target, problem.observations, subset, problem.acquisition, acquired) !=
        Status::ok) {
      continue;
    }
    for (const PoseEstimate* candidate : {&acquired.best, &acquired.other}) {
      if (candidate == &acquired.other && !acquired.ambiguous) continue;
      PoseEstimate estimate = *candidate;
      ObservationMask agree{};
      std::size_t count = agreeing(problem, used, estimate.pose, agree);
      for (int k = 0; k < refinements && count >= problem.least; ++k) {
        if (problem.solve(agree, estimate.pose, estimate) != Status::ok) {
          count = 0;
          break;
        }
        count = agreeing(problem, used, estimate.pose, agree);
      }
      if (count <= most || problem.solve(agree, estimate.pose, estimate) != Status::ok) continue;
      if (is_alarming(estimate, problem.settings)) continue;
      most = count;
      best_mask = agree;
      best = estimate;
    }
  }
  if (most < problem.least) return false;
  used = best_mask;
  out = best;
  return true;
}

}  // namespace

bool is_alarming(const PoseEstimate& estimate, const OutlierSettings& settings) {
  return estimate.degrees_of_freedom > 0 &&
         !(estimate.chi2 <= chi2_point(estimate.degrees_of_freedom, settings.alarm_z));
}

Status reject_outliers(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                       const Pose& start, const AcquisitionSettings& acquisition, const OutlierSettings& settings,
                       ObservationMask& used, PoseEstimate& out) {
  const std::size_t count = count_of(used, observations.size());
  if (count < least_observations) return Status::too_few_features;
  Problem problem{rig, target, observations, acquisition, settings};
  const auto share = static_cast<std::size_t>(settings.least_share * static_cast<double>(count) + 0.999);
  problem.least = std::max(least_observations, share);
  ObservationMask mask = used;
  PoseEstimate estimate;
  if (!drop_worst(problem, start, mask, estimate)) {
    mask = used;
    if (!find_consensus(problem, mask, estimate)) return Status::inconsistent;
  }
  used = mask;
  out = estimate;
  return Status::ok;
}

}  // namespace relnav
