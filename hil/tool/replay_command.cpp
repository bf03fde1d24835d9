#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "hil/io/camera_file.hpp"
#include "hil/io/input_error.hpp"
#include "hil/io/target_file.hpp"
#include "hil/replay/flight_driver.hpp"
#include "hil/replay/replay_run.hpp"
#include "hil/replay/summary.hpp"
#include "hil/replay/telemetry_link.hpp"
#include "hil/report/report.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/progress.hpp"
#include "platform/host/steady_clock.hpp"

namespace relnav::hil {
namespace {

/// A finite length; CLI11's own checks answer with the largest double written out.
CLI::Validator metres(const std::string& what, bool (*fits)(double)) {
  return CLI::Validator(
      [what, fits](std::string& text) {
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && fits(value);
        return good ? std::string() : "'" + text + "' (expected a " + what + " number of metres)";
      },
      "METRES");
}

struct Options {
  std::string dataset;
  std::string mode;
  std::string target;
  std::string config;
  std::string motion;  ///< empty: rigid-target
  double range_m = 0.0;
  double range_sigma_m = -1.0;
  std::string out;
  std::string tlm;
  std::string rate = "max";
  bool force = false;
};

void check(const Options& o) {
  const bool coop = o.mode != "noncoop";
  if (coop && (o.range_m > 0.0 || o.range_sigma_m >= 0.0 || !o.motion.empty()))
    throw InputError("--mode " + o.mode, 0, "takes no --range, --range-sigma or --motion",
                     "these with --mode noncoop only");
  if (!coop && !o.target.empty())
    throw InputError("--mode noncoop", 0, "takes no --target", "--target with a cooperative mode");
  if (!o.tlm.empty()) static_cast<void>(parse_udp_url(o.tlm));
}

RunDescription description_of(const Options& o, const FlightSetup& setup, std::size_t frames) {
  RunDescription d;
  d.dataset = o.dataset;
  d.mode = o.mode;
  d.target = setup.target_file;
  if (setup.navigation == app::NavigationKind::noncoop) d.motion = setup.rigid_target ? "rigid-target" : "camera";
  d.config = o.config;
  d.range_m = o.range_m;
  d.range_sigma_m = o.range_sigma_m < 0.0 ? 0.0 : o.range_sigma_m;
  d.frames_listed = frames;
  d.width_px = static_cast<std::uint32_t>(setup.camera.intrinsics.width_px);
  d.height_px = static_cast<std::uint32_t>(setup.camera.intrinsics.height_px);
  return d;
}

void write_results(const Options& o, const RunDescription& description, const ReplayOutcome& outcome,
                   const RunHistory& history, const Trajectory& truth) {
  const auto evaluation = evaluate_run(history, truth, o.mode == "noncoop" ? AlignMode::start : AlignMode::none);
  const Evaluation* judged = evaluation ? &*evaluation : nullptr;
  OutputFile(o.out + "/summary.json").write(summary_json(description, outcome, history, judged));
  OutputFile(o.out + "/report.html").write(report_html(description, outcome, history, judged, &truth));
}

void set_up_cooperative(const Options& o, FlightSetup& setup) {
  namespace fs = std::filesystem;
  const bool stereo = o.mode == "coop-stereo";
  setup.navigation = stereo ? app::NavigationKind::coop_stereo : app::NavigationKind::coop_mono;
  setup.target_file = o.target.empty() ? (fs::path(o.dataset) / "target.yaml").string() : o.target;
  setup.target = read_target_file(setup.target_file);
  if (!stereo) return;
  setup.second_file = (fs::path(o.dataset) / "mav0" / "cam1" / "sensor.yaml").string();
  setup.second = read_camera_file(setup.second_file, 1);
}

int run(const Options& o) {
  namespace fs = std::filesystem;
  check(o);
  // All input is looked at before the output folder is touched.
  const fs::path camera_folder = fs::path(o.dataset) / "mav0" / "cam0";
  if (!fs::is_directory(o.dataset))
    throw InputError(o.dataset, 0, "is no folder", "a data set in the EuRoC layout (mav0/cam0/data.csv)");
  FlightSetup setup;
  setup.camera_file = (camera_folder / "sensor.yaml").string();
  setup.camera = read_camera_file(setup.camera_file);
  setup.rigid_target = o.motion != "camera";
  setup.range_m = o.range_m;
  setup.range_sigma_m = o.range_sigma_m;
  setup.config_file = o.config;
  if (o.mode != "noncoop") set_up_cooperative(o, setup);
  const bool stereo = setup.navigation == app::NavigationKind::coop_stereo;
  const auto images_of = [&](const char* name) {
    return read_image_list((fs::path(o.dataset) / "mav0" / name).string());
  };
  std::vector<ImageEntry> images = images_of("cam0");
  Trajectory truth;
  const std::string truth_path = (fs::path(o.dataset) / "truth.tum").string();
  if (fs::exists(truth_path)) truth = read_trajectory(truth_path);
  std::vector<ImageEntry> second_images;
  if (stereo) second_images = images_of("cam1");
  const RunDescription description = description_of(o, setup, std::max(images.size(), second_images.size()));

  platform::host::SteadyClock clock;
  const Pace pace = o.rate == "real" ? Pace::real : Pace::max;
  // The light spots' centroids gain by every bit; corners and patches are made for eight.
  const Depth depth = o.mode == "noncoop" ? Depth::eight_bits : Depth::as_filed;
  ReplayCamera camera(std::move(images), description.width_px, description.height_px, clock, pace, depth);
  std::optional<ReplayCamera> second;
  if (stereo) {
    const CameraIntrinsics& c = setup.second.intrinsics;
    second.emplace(std::move(second_images), static_cast<std::uint32_t>(c.width_px),
                   static_cast<std::uint32_t>(c.height_px), clock, pace, depth);
  }
  ReplayCamera* const mate = second ? &*second : nullptr;
  TelemetryLink link;
  if (!o.tlm.empty()) link.add_udp(o.tlm);
  const auto loop = make_flight_driver(setup, camera, mate, link);

  prepare_run_folder(o.out, o.force);
  RunFiles files(o.out);
  link.open(o.out + "/telemetry.bin", [&](std::span<const std::uint8_t> packet) {
    const std::string line = event_log_line(packet, telemetry::PacketConfig{});
    if (!line.empty()) files.add_event(line);
  });

  catch_interrupts();
  RunHistory history;
  Progress progress;
  ReplayCameras cameras{&camera};
  if (mate != nullptr) cameras.push_back(mate);
  const ReplayOutcome outcome = run_replay(*loop, cameras, files, history,
                                           [&](std::size_t done, std::size_t listed, const app::StepReport& report) {
                                             if (!link.problem().empty()) throw std::runtime_error(link.problem());
                                             progress.show(done, listed, report);
                                             return !interrupted();
                                           });
  progress.finish();
  write_results(o, description, outcome, history, truth);
  if (!outcome.problem.empty()) std::fprintf(stderr, "relnav: %s\n", outcome.problem.c_str());
  std::printf("%zu of %zu frames, %zu poses, %u resets, results in %s\n", history.frames.size(),
              description.frames_listed, outcome.poses,
              history.frames.empty() ? 0U : history.frames.back().reset_counter, o.out.c_str());
  return exit_status_of(outcome);
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("replay", "The flight loop over captured frames");
  command
      ->add_option("--dataset", o->dataset,
                   "Folder in the EuRoC layout: mav0/cam0/{data.csv,data/,sensor.yaml}, optional truth.tum")
      ->required();
  command->add_option("--mode", o->mode, "What is estimated")
      ->required()
      ->check(CLI::IsMember({"noncoop", "coop-mono", "coop-stereo"}));
  command->add_option("--target", o->target, "Target model, YAML (coop-*) [SEQ/target.yaml]");
  command->add_option("--config", o->config, "Configuration of the flight loop, YAML");
  command->add_option("--motion", o->motion, "noncoop: which motion model [rigid-target]")
      ->check(CLI::IsMember({"rigid-target", "camera"}));
  command
      ->add_option("--range", o->range_m,
                   "noncoop: start range along the line of sight in m; it also sets the free scale")
      ->check(metres("positive", [](double value) { return value > 0.0; }));
  command->add_option("--range-sigma", o->range_sigma_m, "noncoop: 1 sigma of the start range in m")
      ->check(metres("non-negative", [](double value) { return value >= 0.0; }));
  command->add_option("--out", o->out, "Folder for the results")->required();
  command->add_option("--tlm", o->tlm, "Also send telemetry to udp://HOST:PORT");
  command->add_option("--rate", o->rate, "As fast as possible, or as fast as the frames came [max]")
      ->check(CLI::IsMember({"max", "real"}));
  command->add_flag("--force", o->force, "Use a folder that is not empty; files of an earlier run are replaced");
  command->callback([o, &exit_status] { exit_status = run(*o); });
}

}  // namespace relnav::hil
