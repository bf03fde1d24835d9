#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include "hil/montecarlo/campaign.hpp"
#include "hil/montecarlo/campaign_summary.hpp"
#include "hil/simulation/scenario_file.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/progress.hpp"

namespace relnav::hil {
namespace {

struct MontecarloOptions {
  std::string scenario;
  std::uint64_t runs = 0;
  std::string out;
  CampaignPlan plan;
  bool merge = false;
  bool slice = false;
};

unsigned usable_cpus() { return std::max(1U, std::thread::hardware_concurrency()); }

int merge(const CampaignFolder& folder) {
  const CampaignMerge merged = merge_campaign(folder);
  if (merged.missing > 0) {
    std::fprintf(stderr, "relnav: %s: %llu of %llu runs have no result yet, the first is %llu\n",
                 folder.path("summary.json").c_str(), static_cast<unsigned long long>(merged.missing),
                 static_cast<unsigned long long>(folder.identity().runs),
                 static_cast<unsigned long long>(*merged.first_missing));
  }
  std::printf("%llu runs, %llu failed, of these %llu with an error, summary in %s\n",
              static_cast<unsigned long long>(merged.results), static_cast<unsigned long long>(merged.failures),
              static_cast<unsigned long long>(merged.errors), folder.path("report.html").c_str());
  return merged.missing > 0 || merged.errors > 0 ? exit_fault : exit_done;
}

int run(const MontecarloOptions& o) {
  CampaignPlan plan = o.plan;
  // What cannot be flown is told before anything is begun.
  if (plan.program == CampaignPlan().program) plan.scenario_seed = read_scenario(o.scenario).seed;
  const CampaignFolder folder(o.out, campaign_identity(o.scenario, o.runs, RELNAV_VERSION),
                              o.slice ? CampaignUse::beside_others : CampaignUse::alone);
  catch_interrupts();
  std::optional<Progress> progress;  // from when results of before have been looked at
  const CampaignProgress done = run_campaign(folder, plan, [&](const CampaignProgress& p) {
    if (!progress) progress.emplace("run");
    if (p.to_do > 0) progress->show(p.done, p.to_do, std::to_string(p.failed) + " failed");
    return !interrupted();
  });
  if (progress) progress->finish();
  const double n = static_cast<double>(done.done);
  std::printf("%llu runs done, %llu were there; %.1f s, %.2f runs/s, %.3f s CPU a run\n",
              static_cast<unsigned long long>(done.done), static_cast<unsigned long long>(done.there), done.wall_s,
              done.wall_s > 0.0 ? n / done.wall_s : 0.0, n > 0.0 ? done.cpu_s / n : 0.0);
  if (done.interrupted) {
    std::fprintf(stderr, "relnav: interrupted with %llu runs to do; the same command goes on\n",
                 static_cast<unsigned long long>(done.to_do - done.done));
    return exit_fault;
  }
  return o.slice ? exit_done : merge(folder);
}

CLI::Validator positive_seconds() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0.0;
        return good ? std::string() : "'" + text + "' (expected a positive number of seconds)";
      },
      "S");
}

}  // namespace

void add_montecarlo_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<MontecarloOptions>();
  o->plan.jobs = usable_cpus();
  CLI::App* command =
      app.add_subcommand("montecarlo", "Many runs of a scenario with its dispersions, and what came of them");
  command->add_option("--out", o->out, "Folder of the campaign; one of the same campaign is gone on with")->required();
  CLI::Option* merging = command->add_flag("--merge", o->merge, "Only summarise what slices have left in --out");
  CLI::Option* scenario = command->add_option("--scenario", o->scenario, "What is flown, and what is dispersed");
  CLI::Option* runs = command->add_option("--runs", o->runs, "Runs of the whole campaign; more than before extend it")
                          ->check(CLI::Range(std::uint64_t{1}, most_runs))
                          ->option_text("N");
  command->add_option("--jobs", o->plan.jobs, "Runs at a time [processors]")
      ->check(CLI::Range(1U, 1024U))
      ->option_text("J");
  CLI::Option* first = command->add_option("--first", o->plan.first, "Only a slice, without a summary: its first run")
                           ->check(CLI::Range(std::uint64_t{0}, most_runs))
                           ->option_text("K");
  CLI::Option* count = command->add_option("--count", o->plan.count, "Runs of the slice, cut at the campaign's end")
                           ->check(CLI::Range(std::uint64_t{1}, most_runs))
                           ->option_text("M");
  first->needs(count);
  count->needs(first);
  command->add_option("--time-limit", o->plan.time_limit_s, "A run that takes longer is ended as an error [none]")
      ->check(positive_seconds())
      ->option_text("S");
  command->add_flag("--errors-again", o->plan.errors_again, "Do runs that ended in an error once more");
  command->add_option("--program", o->plan.program)->group("");  // what stands in for relnav sim in tests
  merging->excludes(scenario)->excludes(runs)->excludes(first)->excludes(count);
  command->callback([o, scenario, runs, first, &exit_status] {
    if (o->merge) {
      exit_status = merge(CampaignFolder(o->out, CampaignUse::alone));
      return;
    }
    if (scenario->count() == 0) throw CLI::RequiredError("--scenario");
    if (runs->count() == 0) throw CLI::RequiredError("--runs");
    o->slice = first->count() > 0;
    exit_status = run(*o);
  });
}

}  // namespace relnav::hil
