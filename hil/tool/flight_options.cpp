#include "hil/tool/flight_options.hpp"

#include <cmath>
#include <filesystem>

#include "platform/files/camera_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/target_file.hpp"

namespace relnav::hil {

namespace fs = std::filesystem;

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

void check(const FlightOptions& o) {
  const bool coop = o.mode != "noncoop";
  if (coop && (o.range_m > 0.0 || o.range_sigma_m >= 0.0 || !o.motion.empty()))
    throw InputError("--mode " + o.mode, 0, "takes no --range, --range-sigma or --motion",
                     "these with --mode noncoop only");
  if (!coop && !o.target.empty())
    throw InputError("--mode noncoop", 0, "takes no --target", "--target with a cooperative mode");
}

void set_up_cooperative(const FlightOptions& o, FlightSetup& setup) {
  const bool stereo = o.mode == "coop-stereo";
  setup.navigation = stereo ? app::NavigationKind::coop_stereo : app::NavigationKind::coop_mono;
  setup.target_file = o.target.empty() ? (fs::path(o.dataset) / "target.yaml").string() : o.target;
  setup.target = read_target_file(setup.target_file);
  if (!stereo) return;
  setup.second_file = (fs::path(o.dataset) / "mav0" / "cam1" / "sensor.yaml").string();
  setup.second = read_camera_file(setup.second_file, 1);
}

}  // namespace

FlightInput read_flight_input(const FlightOptions& o) {
  check(o);
  const fs::path camera_folder = fs::path(o.dataset) / "mav0" / "cam0";
  if (!fs::is_directory(o.dataset))
    throw InputError(o.dataset, 0, "is no folder", "a data set in the EuRoC layout (mav0/cam0/data.csv)");
  FlightInput input;
  FlightSetup& setup = input.setup;
  setup.camera_file = (camera_folder / "sensor.yaml").string();
  setup.camera = read_camera_file(setup.camera_file);
  setup.rigid_target = o.motion != "camera";
  setup.range_m = o.range_m;
  setup.range_sigma_m = o.range_sigma_m;
  setup.config_file = o.config;
  if (o.mode != "noncoop") set_up_cooperative(o, setup);
  input.images = read_image_list(camera_folder.string());
  if (setup.navigation == app::NavigationKind::coop_stereo) {
    input.second_images = read_image_list((fs::path(o.dataset) / "mav0" / "cam1").string());
  }
  // The light spots' centroids gain by every bit; corners and patches are made for eight.
  input.depth = o.mode == "noncoop" ? Depth::eight_bits : Depth::as_filed;
  return input;
}

void add_flight_options(CLI::App& command, FlightOptions& o) {
  command
      .add_option("--dataset", o.dataset,
                  "Folder in the EuRoC layout: mav0/cam0/{data.csv,data/,sensor.yaml}, optional truth.tum")
      ->required();
  command.add_option("--mode", o.mode, "What is estimated")
      ->required()
      ->check(CLI::IsMember({"noncoop", "coop-mono", "coop-stereo"}));
  command.add_option("--target", o.target, "Target model, YAML (coop-*) [SEQ/target.yaml]");
  command.add_option("--config", o.config, "Configuration of the flight loop, YAML");
  command.add_option("--motion", o.motion, "noncoop: which motion model [rigid-target]")
      ->check(CLI::IsMember({"rigid-target", "camera"}));
  command
      .add_option("--range", o.range_m,
                  "noncoop: start range along the line of sight in m; it also sets the free scale")
      ->check(metres("positive", [](double value) { return value > 0.0; }));
  command.add_option("--range-sigma", o.range_sigma_m, "noncoop: 1 sigma of the start range in m")
      ->check(metres("non-negative", [](double value) { return value >= 0.0; }));
}

}  // namespace relnav::hil
