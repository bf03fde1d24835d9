#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "hil/montecarlo/campaign_folder.hpp"

namespace relnav::hil {

struct CampaignPlan {
  std::string program = "/proc/self/exe";  ///< started as `PROGRAM sim --scenario FILE --run K --result FILE`
  std::uint64_t first = 0;                 ///< the slice of the campaign to do
  std::uint64_t count = most_runs;         ///< cut at its end
  unsigned jobs = 1;
  double time_limit_s = 0.0;                   ///< a run that takes longer is ended, outcome error; 0: none
  std::optional<std::uint64_t> scenario_seed;  ///< names the seeds of runs that leave no result
  bool errors_again = false;                   ///< runs with outcome error are done once more
};

struct CampaignProgress {
  std::uint64_t to_do = 0;   ///< runs without a result at the start
  std::uint64_t done = 0;    ///< of these
  std::uint64_t failed = 0;  ///< of those done, see is_failure()
  std::uint64_t there = 0;   ///< runs with a result at the start
  double cpu_s = 0.0;        ///< of the runs' processes
  double wall_s = 0.0;       ///< of all this
  bool interrupted = false;
};

/// Does the runs of the plan that have no result yet, each as a process of its own, `jobs` at a time. A run that crashes, hangs
/// or leaves no result becomes one with outcome error. `go_on` is asked about ten times a second; when it says no, running
/// processes are ended and their runs stay undone. Throws InputError when a run says that its input is unusable (exit status 2),
/// or when results are of another scenario than the others.
CampaignProgress run_campaign(const CampaignFolder& folder, const CampaignPlan& plan,
                              const std::function<bool(const CampaignProgress&)>& go_on);

}  // namespace relnav::hil
