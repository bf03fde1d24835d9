#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>

#include "hil/replay/run_folder.hpp"
#include "hil/scenarios/random_scenario.hpp"
#include "hil/scenarios/stereo_scenarios.hpp"
#include "hil/scenarios/table1_scenario.hpp"
#include "hil/tool/commands.hpp"

namespace relnav::hil {
namespace {

struct Kind {
  const char* description;
  double sigma_px;            // when none is given
  std::size_t largest_count;  // table1: beyond, the cube drifts out of the image
  std::function<Scenario(const ScenarioOptions&)> make;
};

std::map<std::string, Kind> kinds() {
  return {
      {"table1",
       {"One camera: Table 1 of Yue, Hou 2010, a cube 100 m ahead for 6000 s (--count: epochs, 5 s apart [1201])", 1.0,
        table1_epochs, table1_scenario}},
      {"stereo-noise",
       {"Two cameras: Chen, Chen, Wang 2015, noise swept from 0 to --sigma at 4.2 m (--count: epochs a level [200])",
        2.0, 10000, stereo_noise_scenario}},
      {"stereo-pose",
       {"Two cameras: Chen, Chen, Wang 2015, angles and range swept (--count: epochs a pose [50])", 1.0, 10000,
        stereo_pose_scenario}},
      {"random",
       {"One camera: eight points, attitudes over all of SO(3), a quarter at 180 deg (--count: poses [10000])", 1.0,
        100000, [](const ScenarioOptions& o) { return random_scenario(RandomTarget::eight_points, o); }}},
      {"random-cube",
       {"One camera: the same with the visible vertices of a cube", 1.0, 100000,
        [](const ScenarioOptions& o) { return random_scenario(RandomTarget::cube, o); }}},
  };
}

struct ScenarioCommandOptions {
  std::string out;
  ScenarioOptions scenario;
  bool force = false;
};

CLI::Validator noise() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0.0;
        return good ? std::string() : "'" + text + "' (expected a non-negative number of pixels)";
      },
      "PX");
}

int run(const ScenarioCommandOptions& o, const Kind& kind) {
  const Scenario scenario = kind.make(o.scenario);
  prepare_run_folder(o.out, o.force);
  write_scenario(scenario, o.out);
  std::size_t rows = 0;
  for (const ObservationEpoch& epoch : scenario.observations) rows += epoch.rows.size();
  std::printf("%zu epochs, %zu observations, in %s\n", scenario.truth.size(), rows, o.out.c_str());
  return exit_done;
}

}  // namespace

void add_scenario_command(CLI::App& app, int& exit_status) {
  CLI::App* command = app.add_subcommand("scenario", "Input with known truth for relnav solve, after the papers");
  command->require_subcommand(1);
  for (const auto& [name, kind] : kinds()) {
    const auto o = std::make_shared<ScenarioCommandOptions>();
    o->scenario.sigma_px = kind.sigma_px;
    CLI::App* one = command->add_subcommand(name, kind.description);
    one->add_option("--out", o->out, "Folder for cam0.yaml (cam1.yaml), target.yaml, observations.csv and truth.tum")
        ->required();
    one->add_option("--seed", o->scenario.seed, "Of noise and poses: the same seed gives the same bytes")
        ->option_text("N [1]");
    one->add_option("--sigma", o->scenario.sigma_px, "Noise of each pixel coordinate, 1 sigma")
        ->check(noise())
        ->option_text(kind.sigma_px > 1.0 ? "PX [2]" : "PX [1]");
    one->add_option("--count", o->scenario.count, "Length of the scenario, see above")
        ->check(CLI::Range(std::size_t{1}, kind.largest_count))
        ->option_text("N");
    one->add_flag("--force", o->force, "Use a folder that is not empty; files of an earlier run are replaced");
    one->callback([o, chosen = kind, &exit_status] { exit_status = run(*o, chosen); });
  }
}

}  // namespace relnav::hil
