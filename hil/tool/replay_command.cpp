#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "hil/io/dataset.hpp"
#include "hil/replay/flight_driver.hpp"
#include "hil/replay/replay_camera.hpp"
#include "hil/replay/replay_run.hpp"
#include "hil/replay/summary.hpp"
#include "hil/replay/telemetry_link.hpp"
#include "hil/report/report.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/flight_options.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/progress.hpp"
#include "platform/files/input_error.hpp"
#include "platform/host/steady_clock.hpp"

namespace relnav::hil {
namespace {

struct ReplayOptions {
  FlightOptions flight;
  std::string out;
  std::string tlm;
  std::string rate = "max";
  bool force = false;
};

RunDescription description_of(const ReplayOptions& o, const FlightSetup& setup, std::size_t frames) {
  RunDescription d;
  d.dataset = o.flight.dataset;
  d.mode = o.flight.mode;
  d.target = setup.target_file;
  if (setup.navigation == app::NavigationKind::noncoop) d.motion = setup.rigid_target ? "rigid-target" : "camera";
  d.config = o.flight.config;
  d.range_m = o.flight.range_m;
  d.range_sigma_m = o.flight.range_sigma_m < 0.0 ? 0.0 : o.flight.range_sigma_m;
  d.frames_listed = frames;
  d.width_px = static_cast<std::uint32_t>(setup.camera.intrinsics.width_px);
  d.height_px = static_cast<std::uint32_t>(setup.camera.intrinsics.height_px);
  return d;
}

void write_results(const ReplayOptions& o, const RunDescription& description, const ReplayOutcome& outcome,
                   const RunHistory& history, const Trajectory& truth) {
  const auto evaluation = evaluate_run(history, truth, o.flight.mode == "noncoop" ? AlignMode::start : AlignMode::none);
  const Evaluation* judged = evaluation ? &*evaluation : nullptr;
  OutputFile(o.out + "/summary.json").write(summary_json(description, outcome, history, judged));
  OutputFile(o.out + "/report.html").write(report_html(description, outcome, history, judged, &truth));
}

int run(const ReplayOptions& o) {
  // All input is looked at before the output folder is touched.
  if (!o.tlm.empty()) static_cast<void>(parse_udp_url(o.tlm));
  FlightInput input = read_flight_input(o.flight);
  const FlightSetup& setup = input.setup;
  Trajectory truth;
  const std::string truth_path = (std::filesystem::path(folder_of_dataset(o.flight.dataset)) / "truth.tum").string();
  if (std::filesystem::exists(truth_path)) truth = read_trajectory(truth_path);
  const RunDescription description =
      description_of(o, setup, std::max(input.images.size(), input.second_images.size()));

  platform::host::SteadyClock clock;
  const Pace pace = o.rate == "real" ? Pace::real : Pace::max;
  ReplayCamera camera(std::move(input.images), description.width_px, description.height_px, clock, pace, input.depth);
  std::optional<ReplayCamera> second;
  if (setup.navigation == app::NavigationKind::coop_stereo) {
    const CameraIntrinsics& c = setup.second.intrinsics;
    second.emplace(std::move(input.second_images), static_cast<std::uint32_t>(c.width_px),
                   static_cast<std::uint32_t>(c.height_px), clock, pace, input.depth);
  }
  ReplayCamera* const mate = second ? &*second : nullptr;
  TelemetryLink link;
  if (!o.tlm.empty()) link.add_udp(o.tlm);
  const std::string& judged = setup.config_file.empty() ? setup.camera_file : setup.config_file;
  const auto loop = make_flight_driver(flight_config_of(setup), judged, clock, camera, mate, link);

  prepare_run_folder(o.out, o.force);
  RunFiles files(o.out);
  link.open(o.out + "/telemetry.bin", [&](std::span<const std::uint8_t> packet) {
    const std::string line = event_log_line(packet, telemetry::PacketConfig{});
    if (!line.empty()) files.add_event(line);
  });

  catch_interrupts();
  RunHistory history;
  Progress progress;
  RunCameras cameras{&camera};
  if (mate != nullptr) cameras.push_back(mate);
  const ReplayOutcome outcome = run_replay(*loop, cameras, &files, history,
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
  const auto o = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay", "The flight loop over captured frames");
  add_flight_options(*command, o->flight);
  command->add_option("--out", o->out, "Folder for the results")->required();
  command->add_option("--tlm", o->tlm, "Also send telemetry to udp://HOST:PORT");
  command->add_option("--rate", o->rate, "As fast as possible, or as fast as the frames came [max]")
      ->check(CLI::IsMember({"max", "real"}));
  command->add_flag("--force", o->force, "Use a folder that is not empty; files of an earlier run are replaced");
  command->callback([o, &exit_status] { exit_status = run(*o); });
}

}  // namespace relnav::hil
