#include "hil/tool/flight_options.hpp"

#include <cmath>
#include <filesystem>

#include "hil/io/dataset.hpp"
#include "hil/tool/notes.hpp"
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
  setup.target_file = o.target.empty() ? (fs::path(folder_of_dataset(o.dataset)) / "target.yaml").string() : o.target;
  setup.target = read_target_file(setup.target_file);
  if (!stereo) return;
  setup.second_file = find_camera(o.dataset, 1).calibration;
  setup.second = read_camera_file(setup.second_file, 1);
}

}  // namespace

FlightInput read_flight_input(const FlightOptions& o) {
  check(o);
  const CameraFiles files = find_camera(o.dataset, 0);
  FlightInput input;
  FlightSetup& setup = input.setup;
  setup.camera_file = files.calibration;
  setup.camera = read_camera_file(setup.camera_file);
  setup.rigid_target = o.motion != "camera";
  setup.range_m = o.range_m;
  setup.range_sigma_m = o.range_sigma_m;
  setup.config_file = o.config;
  if (o.mode != "noncoop") set_up_cooperative(o, setup);
  std::vector<std::string> notes;
  input.images = read_images(files.images, notes);
  if (setup.navigation == app::NavigationKind::coop_stereo) {
    input.second_images = read_images(find_camera(o.dataset, 1).images, notes);
  }
  print_notes(notes);
  // The light spots' centroids gain by every bit; corners and patches are made for eight.
  input.depth = o.mode == "noncoop" ? Depth::eight_bits : Depth::as_filed;
  return input;
}

void add_flight_options(CLI::App& command, FlightOptions& o) {
  command
      .add_option("--dataset", o.dataset,
                  "Folder in the EuRoC layout (mav0/cam0/{data.csv,data/,sensor.yaml}) or with cam0.rnc and cam0.yaml, "
                  "optional truth.tum; or FILE.rnc with FILE.yaml")
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
