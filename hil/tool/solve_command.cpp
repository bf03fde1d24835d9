#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "hil/replay/summary.hpp"
#include "hil/replay/telemetry_link.hpp"
#include "hil/report/report.hpp"
#include "hil/solve/solve_run.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/progress.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/target_file.hpp"

namespace relnav::hil {
namespace {

/// CLI11's own check takes NaN for positive.
CLI::Validator positive_px() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0.0;
        return good ? std::string() : "'" + text + "' (expected a positive number of pixels)";
      },
      "PX");
}

struct SolveOptions {
  std::string mode;
  std::vector<std::string> cameras;
  std::string target;
  std::string observations;
  std::string out;
  std::string method;
  std::string lines = "target";
  std::string scalar = "double";
  double sigma_px = 1.0;
  bool no_switching = false;
  bool force = false;
};

std::string method_of(const SolveOptions& o) {
  if (!o.method.empty()) return o.method;
  return o.mode == "coop-stereo" ? "ml" : "rodrigues";
}

SolveSetup setup_of(const SolveOptions& o) {
  const bool stereo = o.mode == "coop-stereo";
  const std::size_t needed = stereo ? 2 : 1;
  if (o.cameras.size() != needed)
    throw InputError(
        "--mode " + o.mode, 0,
        std::to_string(o.cameras.size()) + (o.cameras.size() == 1 ? " camera file given" : " camera files given"),
        std::to_string(needed) + (stereo ? " --camera options" : " --camera option"));
  const std::string method = method_of(o);
  if (stereo == (method == "rodrigues"))
    throw InputError("--method " + method, 0, "is not one of --mode " + o.mode,
                     stereo ? "ml, motor or orthogonal" : "rodrigues");
  if (o.no_switching && stereo)
    throw InputError("--no-switching", 0, "is not one of --mode coop-stereo", "--mode coop-mono");
  if (o.scalar != "double" && method == "orthogonal")
    throw InputError("--scalar", 0, "--method orthogonal runs in double only", "--scalar double, or --method motor");
  SolveSetup setup;
  if (method == "motor") setup.config.method = CooperativeMethod::motor;
  if (method == "orthogonal") setup.config.method = CooperativeMethod::orthogonal;
  setup.config.lines = o.lines == "all" ? MotorLines::all : MotorLines::target;
  if (o.scalar == "float") setup.scalar = SolveScalar::in_float;
  if (o.scalar == "fixed") setup.scalar = SolveScalar::in_fixed;
  setup.switching = !o.no_switching;
  return setup;
}

int run(const SolveOptions& o) {
  namespace fs = std::filesystem;
  // All input is looked at before the output folder is touched.
  const SolveSetup setup = setup_of(o);
  const CameraRig rig = read_camera_rig(o.cameras);
  const TargetModel target = read_target_file(o.target);
  const std::vector<ObservationEpoch> epochs = read_observations(o.observations, o.sigma_px);
  check_observations(o.observations, epochs, target, rig);
  Trajectory truth;
  const std::string truth_path = (fs::path(o.observations).parent_path() / "truth.tum").string();
  if (fs::exists(truth_path)) truth = read_trajectory(truth_path);
  RunDescription description;
  description.dataset = o.observations;
  description.mode = o.mode;
  description.target = o.target;
  description.method = method_of(o);
  description.frames_listed = epochs.size();
  description.width_px = static_cast<std::uint32_t>(rig[0].model.intrinsics().width_px);
  description.height_px = static_cast<std::uint32_t>(rig[0].model.intrinsics().height_px);

  prepare_run_folder(o.out, o.force);
  RunFiles files(o.out);
  TelemetryLink link;
  link.open(o.out + "/telemetry.bin", [&](std::span<const std::uint8_t> packet) {
    const std::string line = event_log_line(packet, telemetry::PacketConfig{});
    if (!line.empty()) files.add_event(line);
  });
  catch_interrupts();
  RunHistory history;
  Progress progress;
  const ReplayOutcome outcome = run_solve(setup, rig, target, o.observations, epochs, link, files, history,
                                          [&](std::size_t done, std::size_t listed, const app::StepReport& report) {
                                            if (!link.problem().empty()) throw std::runtime_error(link.problem());
                                            progress.show(done, listed, report);
                                            return !interrupted();
                                          });
  progress.finish();
  const auto evaluation = evaluate_run(history, truth, AlignMode::none);
  const Evaluation* judged = evaluation ? &*evaluation : nullptr;
  OutputFile(o.out + "/summary.json").write(summary_json(description, outcome, history, judged));
  OutputFile(o.out + "/report.html").write(report_html(description, outcome, history, judged, &truth));
  if (!outcome.problem.empty()) std::fprintf(stderr, "relnav: %s\n", outcome.problem.c_str());
  std::printf("%zu epochs, %zu poses, %zu without, results in %s\n", history.frames.size(), outcome.poses,
              history.frames.size() - outcome.poses, o.out.c_str());
  return exit_status_of(outcome);
}

}  // namespace

void add_solve_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<SolveOptions>();
  CLI::App* command = app.add_subcommand("solve", "Poses of a cooperative target from feature observations");
  command->add_option("--mode", o->mode, "One or two cameras")
      ->required()
      ->check(CLI::IsMember({"coop-mono", "coop-stereo"}));
  command->add_option("--camera", o->cameras, "Camera file; once a camera, in the order of their numbers")->required();
  command->add_option("--target", o->target, "Target model, YAML")->required();
  command->add_option("--observations", o->observations, "CSV: t_ns,cam,feature_id,u,v[,sigma]")->required();
  command->add_option("--out", o->out, "Folder for the results")->required();
  command
      ->add_option("--method", o->method,
                   "coop-mono: rodrigues. coop-stereo: ml (default), motor, orthogonal (closed forms)")
      ->check(CLI::IsMember({"rodrigues", "ml", "motor", "orthogonal"}));
  command
      ->add_option("--lines", o->lines,
                   "motor: the target's lines (or each feature to the next), or all pairs [target]")
      ->check(CLI::IsMember({"target", "all"}));
  command->add_option("--scalar", o->scalar, "Arithmetic of the solution; fixed: Q16.47 [double]")
      ->check(CLI::IsMember({"double", "float", "fixed"}));
  command->add_option("--sigma", o->sigma_px, "Noise of the observations in px, where the file does not say [1]")
      ->check(positive_px());
  command->add_flag(
      "--no-switching", o->no_switching,
      "coop-mono: stay in one Rodrigues set and take every start from the epoch before, to see what MSR is for");
  command->add_flag("--force", o->force, "Use a folder that is not empty; files of an earlier run are replaced");
  command->callback([o, &exit_status] { exit_status = run(*o); });
}

}  // namespace relnav::hil
