#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "hil/io/atomic_file.hpp"
#include "hil/replay/summary.hpp"
#include "hil/replay/telemetry_link.hpp"
#include "hil/report/report.hpp"
#include "hil/simulation/run_verdict.hpp"
#include "hil/simulation/simulation.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/progress.hpp"
#include "platform/files/flight_words.hpp"
#include "platform/files/input_error.hpp"
#ifdef RELNAV_HAS_RENDERER
#include "hil/render/scene_image_maker.hpp"
#endif

namespace relnav::hil {
namespace {

struct SimOptions {
  std::string scenario;
  std::string out;
  std::string result;
  std::string tlm;
  std::string capture;
  std::string rate = "max";
  std::uint64_t run = 0;
  double duration_s = 0.0;  ///< 0: the scenario's
  bool force = false;
};

ImageMakerFactory image_makers() {
#ifdef RELNAV_HAS_RENDERER
  return make_scene_image_maker;
#else
  return nullptr;
#endif
}

const char* mode_name(app::NavigationKind navigation) {
  for (const auto& [name, kind] : mode_words) {
    if (kind == navigation) return name;
  }
  return "";
}

RunDescription description_of(const SimulationScenario& scenario, const SimulationPlan& plan) {
  RunDescription d;
  d.dataset = scenario.path;
  d.mode = mode_name(scenario.navigation);
  d.target = scenario.target_file;
  if (scenario.navigation == app::NavigationKind::noncoop) {
    d.motion = scenario.flight.navigator.filter.motion == MotionKind::rigid_target ? "rigid-target" : "camera";
    d.range_m = scenario.flight.navigator.filter.range_m;
    d.range_sigma_m = scenario.flight.navigator.filter.range_sigma_m;
  }
  d.frames_listed = plan.frames.size();
  d.width_px = static_cast<std::uint32_t>(plan.told_rig[0].model.intrinsics().width_px);
  d.height_px = static_cast<std::uint32_t>(plan.told_rig[0].model.intrinsics().height_px);
  return d;
}

void write_files(const SimOptions& o, const SimulationScenario& scenario, const SimulationPlan& plan,
                 const ReplayOutcome& outcome, const RunHistory& history, const RunVerdict& verdict) {
  const RunDescription description = description_of(scenario, plan);
  const RunHistory last = last_kind_of(history);
  const auto evaluation = evaluate_run(last, plan.truth_at_stamps, alignment_of(last));
  const Evaluation* judged = evaluation ? &*evaluation : nullptr;
  OutputFile truth(o.out + "/truth.tum");
  truth.line(trajectory_header);
  for (const TimedPose& pose : plan.truth_at_stamps) truth.line(trajectory_line(pose));
  OutputFile(o.out + "/summary.json").write(summary_json(description, outcome, history, judged));
  std::vector<ReportFigure> figures;
  for (const ReferenceFigure& f : scenario.reference) {
    const auto reached = verdict.figures.find(f.name);
    figures.push_back(
        {f.name, reached == verdict.figures.end() ? std::nan("") : reached->second, f.paper, f.must, f.goal});
  }
  OutputFile(o.out + "/report.html")
      .write(report_html(description, outcome, history, judged, &plan.truth_at_stamps, figures));
}

int run(const SimOptions& o) {
  if (o.out.empty() && o.result.empty())
    throw InputError("relnav sim", 0, "nothing to write", "--out DIR or --result FILE");
  if (!o.tlm.empty()) static_cast<void>(parse_udp_url(o.tlm));
  // All input is looked at before any output is touched.
  const auto begin = std::chrono::steady_clock::now();
  SimulationScenario scenario = read_scenario(o.scenario, {o.run});
  if (o.duration_s > 0.0) scenario.duration_s = std::min(scenario.duration_s, o.duration_s);
  TelemetryLink link;
  if (!o.tlm.empty()) link.add_udp(o.tlm);
  Simulation simulation(scenario, image_makers(), o.rate == "real", link);

  RunHistory history;
  std::optional<RunFiles> files;
  if (!o.out.empty()) {
    prepare_run_folder(o.out, o.force);
    files.emplace(o.out);
    link.open(o.out + "/telemetry.bin", [&](std::span<const std::uint8_t> packet) {
      const std::string line = event_log_line(packet, telemetry::PacketConfig{});
      if (line.empty()) return;
      files->add_event(line);
      history.events.push_back({history.frames.empty() ? Time{simulation_start_ns} : history.frames.back().time, line});
    });
  }
  std::optional<SimulatedCapture> capture;
  if (!o.capture.empty()) {
    prepare_run_folder(o.capture, o.force);
    capture.emplace(o.capture, scenario, simulation.plan());
    simulation.record_into(*capture);
  }

  catch_interrupts();
  Progress progress;
  const ReplayOutcome outcome =
      run_replay(simulation.driver(), simulation.cameras(), files ? &*files : nullptr, history,
                 [&](std::size_t done, std::size_t listed, const app::StepReport& report) {
                   if (!link.problem().empty()) throw std::runtime_error(link.problem());
                   progress.show(done, listed, report);
                   return !interrupted();
                 });
  progress.finish();
  RunVerdict verdict = judge_run(scenario, outcome, history, simulation.plan().truth_at_stamps);
  if (scenario.lines.heartbeat) verdict.figures["heartbeats"] = static_cast<double>(simulation.heartbeats());
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // An interrupted run is no result.
  const bool whole = outcome.end != ReplayOutcome::End::interrupted;
  const std::string result = result_json(scenario, {o.run}, verdict, wall_s);
  if (!o.out.empty()) {
    write_files(o, scenario, simulation.plan(), outcome, history, verdict);
    OutputFile(o.out + "/result.json").write(result);
  }
  if (!o.result.empty() && whole) write_atomically(o.result, result);
  const bool good = verdict.end == RunEnd::tracked || verdict.end == RunEnd::regained;
  if (!verdict.problem.empty()) std::fprintf(stderr, "relnav: %s\n", verdict.problem.c_str());
  if (!o.out.empty()) {
    std::printf("%s: %zu of %zu frames, %zu poses, %s, in %.2f s, results in %s\n", scenario.name.c_str(),
                history.frames.size(), simulation.plan().frames.size(), outcome.poses, to_string(verdict.end), wall_s,
                o.out.c_str());
  }
  return good && whole ? exit_done : exit_fault;
}

}  // namespace

void add_sim_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<SimOptions>();
  CLI::App* command = app.add_subcommand("sim", "The flight loop against simulated dynamics and rendered frames");
  command->add_option("--scenario", o->scenario, "Scenario, YAML (docs/simulation.md)")->required();
  command->add_option("--out", o->out, "Folder for the results");
  command->add_option("--result", o->result, "File for what the run came to, one object of JSON; may do without --out");
  command
      ->add_option("--run", o->run, "Which run of a campaign: its seed and dispersions; 0: the scenario as it stands")
      ->option_text("N [0]");
  command->add_option("--for", o->duration_s, "Only the beginning: at most so many seconds of the scenario")
      ->check(CLI::Range(1e-3, 1e6))  // as duration_s
      ->option_text("SECONDS");
  command->add_option("--capture", o->capture,
                      "Folder for the frames and their truth, as a data set for relnav replay");
  command->add_option("--tlm", o->tlm, "Also send telemetry to udp://HOST:PORT");
  command->add_option("--rate", o->rate, "As fast as possible, or as fast as time goes [max]")
      ->check(CLI::IsMember({"max", "real"}));
  command->add_flag("--force", o->force, "Use folders that are not empty; files of an earlier run are replaced");
  command->callback([o, &exit_status] { exit_status = run(*o); });
}

}  // namespace relnav::hil
