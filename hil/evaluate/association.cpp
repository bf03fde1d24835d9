#include "hil/evaluate/association.hpp"

#include <algorithm>
#include <cstdlib>

namespace relnav::hil {
namespace {

std::int64_t distance_ns(Time a, Time b) { return std::abs((a - b).ns); }

std::size_t nearest(const Trajectory& trajectory, Time time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time,
                                      [](const TimedPose& pose, Time t) { return pose.time < t; });
  if (after == trajectory.end()) return trajectory.size() - 1;
  const auto index = static_cast<std::size_t>(after - trajectory.begin());
  if (index > 0 && distance_ns(trajectory[index - 1].time, time) <= distance_ns(trajectory[index].time, time))
    return index - 1;
  return index;
}

}  // namespace

Duration median_period(const Trajectory& trajectory) {
  if (trajectory.size() < 2) return {0};
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < trajectory.size(); ++i) steps.push_back((trajectory[i].time - trajectory[i - 1].time).ns);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return {*middle};
}

Association associate(const Trajectory& truth, const Trajectory& estimate) {
  constexpr std::int64_t longest_ns = 5'000'000;
  Association association;
  association.tolerance.ns = longest_ns;
  for (const Trajectory* trajectory : {&truth, &estimate}) {
    const std::int64_t half = median_period(*trajectory).ns / 2;
    if (half > 0) association.tolerance.ns = std::min(association.tolerance.ns, half);
  }
  std::size_t used = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::size_t j = estimate.empty() ? 0 : nearest(estimate, truth[i].time);
    // Mutual: the estimate's own nearest truth must be this one, so that no pose serves twice.
    if (!estimate.empty() && distance_ns(truth[i].time, estimate[j].time) <= association.tolerance.ns &&
        nearest(truth, estimate[j].time) == i) {
      association.pairs.push_back({i, j});
      ++used;
    } else {
      association.missing.push_back(i);
    }
  }
  association.estimates_without_truth = estimate.size() - used;
  return association;
}

}  // namespace relnav::hil
