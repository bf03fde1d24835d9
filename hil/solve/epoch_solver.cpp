#include "hil/solve/epoch_solver.hpp"

#include <chrono>
#include <stdexcept>

#include "fsw/estimation/scaled_motor_solver.hpp"
#include "fsw/estimation/scaled_pose_solver.hpp"

namespace relnav::hil {
namespace {

telemetry::Estimator estimator_of(CooperativeMethod method, std::size_t cameras) {
  switch (method) {
    case CooperativeMethod::motor: return telemetry::Estimator::motor;
    case CooperativeMethod::orthogonal: return telemetry::Estimator::orthogonal;
    case CooperativeMethod::least_squares: break;
  }
  return cameras == 2 ? telemetry::Estimator::stereo_least_squares : telemetry::Estimator::mono_least_squares;
}

}  // namespace

EpochSolver::EpochSolver(const SolveSetup& setup, const CameraRig& rig, const TargetModel& target) : setup_(setup) {
  setup_.config.acquisition.solver.switching = setup.switching;
  if (estimator_.configure(setup_.config, rig, target) != Status::ok)
    throw std::runtime_error("the estimator refuses this rig and target for the method asked for");
  report_.estimator = estimator_of(setup.config.method, rig.size());
}

Status EpochSolver::solve_double(const PoseObservations& observations, const Pose* prior) {
  if (setup_.switching || prior == nullptr) return estimator_.solve(observations, prior, solution_);
  solution_.used.fill(false);
  for (std::size_t i = 0; i < observations.size(); ++i) solution_.used[i] = true;
  return solve_pose(estimator_.rig(), estimator_.target(), observations, solution_.used, *prior,
                    setup_.config.acquisition.solver, solution_.estimate);
}

Status EpochSolver::solve_narrow(const PoseObservations& observations, const Pose* prior) {
  Pose start;
  if (prior != nullptr) {
    start = *prior;
    solution_.used.fill(false);
    for (std::size_t i = 0; i < observations.size(); ++i) solution_.used[i] = true;
  } else {
    const Status status = estimator_.solve(observations, nullptr, solution_);
    if (status != Status::ok) return status;
    start = solution_.estimate.pose;
  }
  const auto run = [&](auto scalar) {
    return solve_scaled_pose<decltype(scalar)>(estimator_.rig(), estimator_.target(), observations, solution_.used,
                                               start, setup_.config.acquisition.solver, solution_.estimate);
  };
  Status status = setup_.scalar == SolveScalar::in_float ? run(float()) : run(FixedQ47());
  if (status == Status::ok && is_alarming(solution_.estimate, setup_.config.outliers)) status = Status::inconsistent;
  // A start that was too far off, or outliers: once more without it, as CooperativeEstimator does. Acquisition is in double.
  return status != Status::ok && prior != nullptr && setup_.switching ? solve_narrow(observations, nullptr) : status;
}

Status EpochSolver::solve_narrow_motor(const PoseObservations& observations) {
  // Judged in double, where its covariance comes from as well; the pose is that of the narrow arithmetic.
  Status status = estimator_.solve(observations, nullptr, solution_);
  if (status != Status::ok) return status;
  PoseEstimate& e = solution_.estimate;
  const auto run = [&](auto scalar) {
    return solve_scaled_motor<decltype(scalar)>(estimator_.rig(), estimator_.target(), observations,
                                                setup_.config.lines, e.pose);
  };
  status = setup_.scalar == SolveScalar::in_float ? run(float()) : run(FixedQ47());
  if (status != Status::ok) return status;
  const Mat6 covariance = e.covariance;
  status = assess_pose(estimator_.rig(), estimator_.target(), observations, solution_.used, Pose(e.pose), e);
  e.covariance = covariance;
  return status;
}

const app::StepReport& EpochSolver::solve(Time time, const PoseObservations& observations) {
  const auto begin = std::chrono::steady_clock::now();
  const Pose* prior = has_previous_ ? &previous_ : nullptr;
  solution_ = CooperativeSolution();
  Status status = Status::ok;
  if (setup_.scalar == SolveScalar::in_double) {
    status = solve_double(observations, prior);
  } else if (setup_.config.method == CooperativeMethod::motor) {
    status = solve_narrow_motor(observations);
  } else {
    status = solve_narrow(observations, prior);
  }
  report_.times = app::StageTimes();
  report_.times.update_ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - begin).count();
  report_.times.total_ns = report_.times.update_ns;
  report(time, observations, status);
  return report_;
}

void EpochSolver::report(Time time, const PoseObservations& observations, Status status) {
  report_.status = status;
  report_.mode = status == Status::ok ? app::Mode::track : app::Mode::lost;
  report_.features = report_.matched = static_cast<std::uint16_t>(observations.size());
  report_.inliers = 0;
  report_.test_ratio = 0.0;
  report_.state = RelativeState();
  report_.state.time = time;
  has_previous_ = status == Status::ok;
  const PoseEstimate& e = solution_.estimate;
  if (status != Status::ok) {
    filter_.restart();
  } else {
    if (!filter_.has_started() || filter_.predict(time) != Status::ok || filter_.update(e) != Status::ok) {
      filter_.start(time, e);
    }
    report_.state = filter_.output();
    previous_ = e.pose;
  }
  if (status != Status::ok && status != Status::ambiguous && status != Status::inconsistent) return;
  report_.test_ratio = e.degrees_of_freedom > 0 ? e.chi2 / static_cast<double>(e.degrees_of_freedom) : 0.0;
  if (status == Status::inconsistent) return;
  report_.state.t_CT = e.pose.t_CT;
  report_.state.R_CT = e.pose.R_CT;
  report_.state.pose_covariance = e.covariance;
  report_.inliers = static_cast<std::uint16_t>(e.used);
}

}  // namespace relnav::hil
