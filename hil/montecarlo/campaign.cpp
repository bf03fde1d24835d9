#include "hil/montecarlo/campaign.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <ctime>
#include <list>
#include <stdexcept>

#include "hil/montecarlo/run_process.hpp"
#include "hil/montecarlo/scenario_check.hpp"
#include "hil/simulation/scenario_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

using CampaignClock = std::chrono::steady_clock;

double seconds_since(CampaignClock::time_point start) {
  return std::chrono::duration<double>(CampaignClock::now() - start).count();
}

// SIGCHLD waits until it is asked for.
class ChildSignal {
 public:
  ChildSignal() {
    ::sigemptyset(&set_);
    ::sigaddset(&set_, SIGCHLD);
    ::sigprocmask(SIG_BLOCK, &set_, &before_);
  }
  ChildSignal(const ChildSignal&) = delete;
  ChildSignal& operator=(const ChildSignal&) = delete;
  ~ChildSignal() { ::sigprocmask(SIG_SETMASK, &before_, nullptr); }
  void wait() const {
    constexpr timespec patience{0, 100'000'000};
    static_cast<void>(::sigtimedwait(&set_, nullptr, &patience));
  }

 private:
  sigset_t set_{};
  sigset_t before_{};
};

struct RunningRun {
  std::uint64_t run;
  CampaignClock::time_point start;
  RunProcess process;
  bool too_long = false;
};

class CampaignLoop {
 public:
  CampaignLoop(const CampaignFolder& folder, const CampaignPlan& plan)
      : folder_(folder), plan_(plan), first_(plan.first), end_(plan.first) {
    const std::uint64_t runs = folder.identity().runs;
    if (plan.first >= runs) {
      throw InputError(folder.path("campaign.json"), 0, "there is no run " + std::to_string(plan.first),
                       "--first below " + std::to_string(runs));
    }
    end_ = plan.first + std::min(plan.count, runs - plan.first);
    look_at_results();
  }

  CampaignProgress run(const std::function<bool(const CampaignProgress&)>& go_on) {
    const ChildSignal child_signal;
    std::uint64_t next = first_;
    while (true) {
      while (running_.size() < plan_.jobs && (next = next_undone(next)) < end_) start(next++);
      progress_.wall_s = seconds_since(start_);
      if (!go_on(progress_)) {
        progress_.interrupted = progress_.done < progress_.to_do;
        running_.clear();
        return progress_;
      }
      if (running_.empty()) return progress_;
      child_signal.wait();
      end_late_ones();
      collect();
    }
  }

 private:
  void look_at_results() {
    finished_.assign(end_ - first_, false);
    std::uint64_t missing_here = 0;
    folder_.visit_results(first_, end_ - first_, [&](std::uint64_t run, const RunResult* result) {
      if (result != nullptr) check_.add(*result, folder_.result_path(run));
      const bool done = result != nullptr && !(plan_.errors_again && result->outcome == RunOutcome::error);
      finished_[run - first_] = done;
      missing_here += done ? 0U : 1U;
      if (run % runs_in_a_pack != runs_in_a_pack - 1 && run != end_ - 1) return;
      missing_.push_back(missing_here);
      progress_.to_do += missing_here;
      if (missing_here == 0) pack_thousand_of(run);  // killed before it came to that
      missing_here = 0;
    });
    progress_.there = end_ - first_ - progress_.to_do;
  }

  [[nodiscard]] std::uint64_t next_undone(std::uint64_t run) const {
    while (run < end_ && finished_[run - first_]) ++run;
    return run;
  }

  void start(std::uint64_t run) {
    folder_.prepare(run);
    running_.push_back({run, CampaignClock::now(),
                        RunProcess(plan_.program, {"sim", "--scenario", folder_.identity().scenario, "--run",
                                                   std::to_string(run), "--result", folder_.part_path(run)})});
  }

  void end_late_ones() {
    if (plan_.time_limit_s <= 0.0) return;
    for (RunningRun& r : running_) {
      if (r.too_long || seconds_since(r.start) <= plan_.time_limit_s) continue;
      r.too_long = true;
      r.process.kill();
    }
  }

  void collect() {
    for (auto at = running_.begin(); at != running_.end();) {
      const auto end = at->process.poll();
      if (!end) {
        ++at;
        continue;
      }
      progress_.cpu_s += end->cpu_s;
      judge(*at, *end);
      const std::uint64_t run = at->run;
      at = running_.erase(at);
      ++progress_.done;
      if (--missing_[run / runs_in_a_pack - first_ / runs_in_a_pack] == 0) pack_thousand_of(run);
    }
  }

  void judge(const RunningRun& r, const ProcessEnd& end) {
    std::string problem;
    if (r.too_long) {
      problem = format_text("took longer than %.9g s", plan_.time_limit_s);
    } else if (end.signal != 0) {
      const char* name = ::sigabbrev_np(end.signal);
      problem =
          "ended by signal " + std::to_string(end.signal) + (name != nullptr ? std::string(" (SIG") + name + ")" : "");
    } else if (end.exit_status == 2) {
      std::string said = r.process.first_complaint();
      if (said.starts_with("relnav: ")) said.erase(0, std::strlen("relnav: "));
      throw std::runtime_error("run " + std::to_string(r.run) + ": " +
                               (said.empty() ? "its input is unusable (exit status 2)" : said));
    } else if (end.exit_status > 2) {
      problem = "ended with exit status " + std::to_string(end.exit_status);
    } else {
      const auto result = folder_.accept(r.run);
      if (result) {
        check_.add(*result, folder_.result_path(r.run));
        if (is_failure(result->outcome)) ++progress_.failed;
        return;
      }
      problem = "ended with exit status " + std::to_string(end.exit_status) + " and without a result";
    }
    ++progress_.failed;
    RunResult result;
    result.run = r.run;
    result.version = folder_.identity().version;
    if (plan_.scenario_seed) result.seed = seed_of_run(*plan_.scenario_seed, {r.run});
    result.problem = problem;
    folder_.keep_error(result, seconds_since(r.start));
  }

  // Others may be at work on what lies outside of the slice.
  void pack_thousand_of(std::uint64_t run) const {
    const std::uint64_t start = run - run % runs_in_a_pack;
    if (start >= first_ && start + runs_in_a_pack <= end_) folder_.pack(run / runs_in_a_pack);
  }

  const CampaignFolder& folder_;
  const CampaignPlan& plan_;
  std::uint64_t first_;
  std::uint64_t end_;
  CampaignClock::time_point start_ = CampaignClock::now();
  std::vector<bool> finished_;          // of the slice, at the start
  std::vector<std::uint64_t> missing_;  // of each thousand of the slice
  std::list<RunningRun> running_;
  CampaignProgress progress_;
  ScenarioCheck check_;
};

}  // namespace

CampaignProgress run_campaign(const CampaignFolder& folder, const CampaignPlan& plan,
                              const std::function<bool(const CampaignProgress&)>& go_on) {
  if (::access(plan.program.c_str(), X_OK) != 0)
    throw InputError(plan.program, 0, "cannot be started", "an executable program");
  return CampaignLoop(folder, plan).run(go_on);
}

}  // namespace relnav::hil
