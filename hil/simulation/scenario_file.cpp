#include "hil/simulation/scenario_file.hpp"

#include <algorithm>
#include <filesystem>

#include "fsw/base/crc32.hpp"
#include "hil/dynamics/motion_file.hpp"
#include "hil/dynamics/relative_motion.hpp"
#include "hil/simulation/dispersions.hpp"
#include "platform/files/file_section.hpp"
#include "platform/files/flight_config_file.hpp"
#include "platform/files/flight_setup.hpp"
#include "platform/files/flight_words.hpp"
#include "platform/files/target_file.hpp"

namespace relnav::hil {
namespace {

constexpr double most_px = 1e6;
constexpr double most_m = 1e6;

constexpr Words<SensorKind, 2> sensor_words{{{"images", SensorKind::images}, {"features", SensorKind::features}}};

/// Everything a scenario depends on, for its checksum.
class NamedFiles {
 public:
  void add(const std::string& path) { text_ += read_text(path); }
  [[nodiscard]] std::uint32_t crc() const {
    return crc32({reinterpret_cast<const std::uint8_t*>(text_.data()), text_.size()});
  }

 private:
  std::string text_;
};

/// `file: PATH`, or the numbers themselves.
CameraCalibration read_scenario_camera(const std::string& path, const FileSection& root, const char* key, int index,
                                       std::string& file, NamedFiles& named) {
  const FileSection section(
      path, root.require(key, "a section that says what the camera is"), key,
      {"file", "width_px", "height_px", "fu_px", "fv_px", "cu_px", "cv_px", "k1", "k2", "p1", "p2", "t_BC_m"});
  if (section.has("file")) {
    file = section.file("file", "a camera calibration file");
    named.add(file);
    return read_camera_file(file, index);
  }
  file = path;
  CameraCalibration camera;
  CameraIntrinsics& k = camera.intrinsics;
  k.width_px = static_cast<std::int32_t>(section.whole_or("width_px", 16, 65'536, 640));
  k.height_px = static_cast<std::int32_t>(section.whole_or("height_px", 16, 65'536, 480));
  k.fu = section.number_or("fu_px", 1.0, most_px, 900.0);
  k.fv = section.number_or("fv_px", 1.0, most_px, k.fu);
  k.cu = section.number_or("cu_px", -most_px, most_px, 0.5 * (k.width_px - 1));
  k.cv = section.number_or("cv_px", -most_px, most_px, 0.5 * (k.height_px - 1));
  const std::array<const char*, 4> names{"k1", "k2", "p1", "p2"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    k.coefficients[i] = section.number_or(names[i], -10.0, 10.0, 0.0);
    if (k.coefficients[i] != 0.0) k.model = DistortionModel::radial_tangential;
  }
  camera.T_BC.topRightCorner<3, 1>() = section.three_or("t_BC_m", most_m, Vec3::Zero());
  return camera;
}

FeatureSettings read_features(const FileSection& section) {
  FeatureSettings f;
  constexpr std::int64_t most_points = 100'000;
  f.count = static_cast<int>(section.whole_or("count", 4, static_cast<std::int64_t>(config::max_features), f.count));
  f.sigma_px = section.number_or("sigma_px", 0.0, 100.0, f.sigma_px);
  f.first_view_sigma_px = section.number_or("first_view_sigma_px", 0.0, 100.0, f.first_view_sigma_px);
  f.outlier_share = section.number_or("outlier_share", 0.0, 0.9, f.outlier_share);
  f.outlier_px = section.number_or("outlier_px", 0.0, most_px, f.outlier_px);
  f.missed_share = section.number_or("missed_share", 0.0, 0.99, f.missed_share);
  f.body_points = static_cast<int>(section.whole_or("body_points", 10, most_points, f.body_points));
  f.opaque_body = section.yes_no_or("opaque_body", f.opaque_body);
  f.half_size_m = section.three_or("half_size_m", most_m, f.half_size_m);
  if (f.half_size_m.minCoeff() <= 0.0)
    section.fail(section.node("half_size_m"), "features.half_size_m is not positive", "half the edges of a box, m");
  return f;
}

std::vector<Fault> read_faults(const std::string& path, const YAML::Node& list) {
  std::vector<Fault> faults;
  if (!list) return faults;
  if (!list.IsSequence()) throw InputError(path, line_of(list), "faults is no list", fault_syntax);
  for (const YAML::Node& item : list) {
    if (item.IsScalar() && item.Scalar() == "none") continue;  // one that dispersions put in, or take away
    try {
      faults.push_back(parse_fault(item.IsScalar() ? item.Scalar() : ""));
    } catch (const InputError& error) {
      throw InputError(path, line_of(item), error.what(), "a fault as relnav serve takes it");
    }
  }
  return faults;
}

LineSettings read_lines(const FileSection& section) {
  LineSettings lines;
  lines.heartbeat = section.yes_no_or("heartbeat", false);
  lines.pulse = section.yes_no_or("pulse", false);
  lines.exposure = section.yes_no_or("exposure", false);
  lines.pulse_jitter_s = section.number_or("pulse_jitter_s", 0.0, 0.1, 0.0);
  constexpr double most_drift_ppb = 1e6;
  lines.clock_drift_ppb = section.number_or("clock_drift_ppb", -most_drift_ppb, most_drift_ppb, 0.0);
  for (const char* key : {"pulse_jitter_s", "clock_drift_ppb"}) {
    if (section.has(key) && !lines.pulse)
      section.fail(section.node(key), std::string("lines.") + key + " without a pulse line", "it with pulse: true");
  }
  return lines;
}

constexpr Words<telemetry::TelecommandId, telemetry::telecommand_definitions.size()> command_words = [] {
  Words<telemetry::TelecommandId, telemetry::telecommand_definitions.size()> words{};
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] = {telemetry::telecommand_definitions[i].name, telemetry::telecommand_definitions[i].id};
  return words;
}();

std::vector<PlannedCommand> read_commands(const std::string& path, const YAML::Node& list, double duration_s) {
  std::vector<PlannedCommand> commands;
  if (!list) return commands;
  const char* const expected = "telecommands: [{at_s: 5, command: restart}]";
  if (!list.IsSequence()) throw InputError(path, line_of(list), "telecommands is no list", expected);
  constexpr std::int64_t most_argument = 0xFFFFFFFF;
  for (const YAML::Node& item : list) {
    const FileSection section(path, item, "telecommands[]", {"at_s", "command", "argument"});
    static_cast<void>(section.require("at_s", "when it arrives, s"));
    PlannedCommand command;
    command.at_s = section.number_or("at_s", 0.0, duration_s, 0.0);
    command.id = section.word("command", command_words);
    const bool takes_one = telemetry::definition_of(command.id).argument_bytes > 0;
    if (section.has("argument") != takes_one) {
      section.fail(takes_one ? item : section.node("argument"),
                   takes_one ? "telecommand without its argument" : "telecommand with an argument",
                   "an argument with set_tai, and only with it");
    }
    command.argument = static_cast<std::uint32_t>(section.whole_or("argument", 0, most_argument, 0));
    const auto after =
        std::upper_bound(commands.begin(), commands.end(), command,
                         [](const PlannedCommand& a, const PlannedCommand& b) { return a.at_s < b.at_s; });
    commands.insert(after, command);
  }
  return commands;
}

std::vector<ReferenceFigure> read_reference(const std::string& path, const YAML::Node& map) {
  std::vector<ReferenceFigure> figures;
  if (!map) return figures;
  if (!map.IsMap()) throw InputError(path, line_of(map), "reference is no map", "figures by name");
  for (const auto& entry : map) {
    const FileSection section(path, entry.second, "reference." + entry.first.Scalar(), {"paper", "must", "goal"});
    constexpr double most = 1e12;
    figures.push_back({entry.first.Scalar(), section.number_or("paper", 0.0, most, -1.0),
                       section.number_or("must", 0.0, most, -1.0), section.number_or("goal", 0.0, most, -1.0)});
  }
  return figures;
}

/// The flight's own configuration, as relnav-flight would have it from its file.
app::FlightLoopConfig read_flight(const std::string& path, const YAML::Node& node, const FileSection& root,
                                  const SimulationScenario& s) {
  FlightSetup setup;
  setup.navigation = s.navigation;
  setup.camera = s.cameras[0];
  setup.camera_file = s.camera_files[0];
  setup.target = s.target;
  setup.target_file = s.target_file.empty() ? path : s.target_file;
  if (s.cameras.size() > 1) {
    setup.second = s.cameras[1];
    setup.second_file = s.camera_files[1];
  }
  const bool noncoop = s.navigation == app::NavigationKind::noncoop;
  if (root.has("flight")) {
    const FileSection flight(path, root.node("flight"), "flight",
                             {"motion", "range_m", "range_sigma_m", "range_error_m"});
    if (!noncoop)
      flight.fail(root.node("flight"), "section flight with a cooperative mode", "it with mode noncoop only");
    setup.rigid_target = flight.word_or("motion", motion_words, true);
    setup.range_m = flight.number_or("range_m", 1e-3, most_m, 0.0);
    setup.range_sigma_m = flight.number_or("range_sigma_m", 0.0, most_m, -1.0);
    if (setup.range_m <= 0.0) {
      RelativeMotion motion(s.motion, s.seed);
      setup.range_m =
          std::max(1e-3, motion.at(Time{}).t_CT.norm() + flight.number_or("range_error_m", -most_m, most_m, 0.0));
    } else if (flight.has("range_error_m")) {
      flight.fail(flight.node("range_error_m"), "range_error_m beside range_m", "one of them");
    }
  } else if (noncoop) {
    setup.range_m = RelativeMotion(s.motion, s.seed).at(Time{}).t_CT.norm();
  }
  // Without images there is no flight loop that would have to hold them, nor to find lights in them.
  auto config = app::FlightLoopConfig::defaults(setup.rigid_target ? MotionKind::rigid_target : MotionKind::camera);
  config.navigation = s.navigation;
  if (s.sensor == SensorKind::images) config = flight_config_of(setup);
  if (setup.range_sigma_m >= 0.0) config.scale_known = true;
  if (s.handover.at_s >= 0.0) config.coop.target = s.target;
  read_flight_config(path, node, config);
  if (setup.range_m > 0.0) config.navigator.filter.range_m = setup.range_m;
  if (setup.range_sigma_m >= 0.0) config.navigator.filter.range_sigma_m = setup.range_sigma_m;
  return config;
}

void read_errors(const FileSection& root, const std::string& path, SimulationScenario& s) {
  if (root.has("calibration_error")) {
    const FileSection e(path, root.node("calibration_error"), "calibration_error",
                        {"fu_px", "fv_px", "cu_px", "cv_px", "k1"});
    s.calibration_error = {e.number_or("fu_px", -most_px, most_px, 0.0), e.number_or("fv_px", -most_px, most_px, 0.0),
                           e.number_or("cu_px", -most_px, most_px, 0.0), e.number_or("cv_px", -most_px, most_px, 0.0),
                           e.number_or("k1", -10.0, 10.0, 0.0)};
  }
  if (root.has("wrong_pose")) {
    const FileSection w(path, root.node("wrong_pose"), "wrong_pose", {"sigmas", "position_of_range", "attitude_deg"});
    s.wrong.sigmas = w.number_or("sigmas", 1.0, 100.0, s.wrong.sigmas);
    s.wrong.position_of_range = w.number_or("position_of_range", 0.0, 1.0, s.wrong.position_of_range);
    constexpr double rad_per_deg = 0.017453292519943295;
    s.wrong.attitude_rad = rad_per_deg * w.number_or("attitude_deg", 0.0, 180.0, s.wrong.attitude_rad / rad_per_deg);
  }
}

}  // namespace

std::uint64_t seed_of_run(std::uint64_t scenario_seed, RunNumber run) {
  if (run.number == 0) return scenario_seed;
  std::uint64_t z = scenario_seed + run.number * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

SimulationScenario read_scenario(const std::string& path, RunNumber run) {
  YAML::Node node = load_yaml(path, "a scenario in YAML");
  std::vector<std::string> keys{
      "source",   "mode",        "sensor",     "duration_s",        "rate_hz",    "seed",
      "camera",   "target",      "motion",     "second_camera",     "features",   "render",
      "flight",   "faults",      "exposure_s", "calibration_error", "wrong_pose", "reference",
      "handover", "dispersions", "gain",       "stamp_jitter_s",    "lines",      "telecommands"};
  const std::vector<std::string> tuning = flight_config_sections();
  keys.insert(keys.end(), tuning.begin(), tuning.end());
  const FileSection root(path, node, "", std::move(keys));

  SimulationScenario s;
  NamedFiles named;
  named.add(path);
  s.path = path;
  s.name = std::filesystem::path(path).stem().string();
  s.source = root.text_or("source", "");
  s.seed = seed_of_run(static_cast<std::uint64_t>(root.whole_or("seed", 0, std::int64_t{1} << 62, 1)), run);
  if (run.number > 0) s.dispersed = disperse(path, node, s.seed);
  s.navigation = root.word("mode", mode_words);
  s.sensor = root.word_or("sensor", sensor_words, SensorKind::images);
  constexpr double longest_s = 1e6;
  s.duration_s = root.number_or("duration_s", 1e-3, longest_s, s.duration_s);
  s.rate_hz = root.number_or("rate_hz", 1e-3, 1e4, s.rate_hz);
  s.exposure_s = root.number_or("exposure_s", 1e-6, 10.0, s.exposure_s);
  s.gain = root.number_or("gain", 0.0, 1e4, s.gain);
  s.stamp_jitter_s = root.number_or("stamp_jitter_s", 0.0, 0.1, 0.0);
  s.motion = read_motion(FileSection(path, root.require("motion", "a section that says how chaser and target move"),
                                     "motion", motion_keys()));

  const bool stereo = s.navigation == app::NavigationKind::coop_stereo;
  if (root.has("second_camera") != stereo) {
    root.fail(root.node(stereo ? "mode" : "second_camera"),
              stereo ? "coop-stereo without a second camera" : "a second camera without mode coop-stereo",
              "second_camera with mode coop-stereo, and only with it");
  }
  for (const char* key : {"camera", "second_camera"}) {
    if (!root.has(key) && std::string(key) == "second_camera") continue;
    std::string file;
    s.cameras.push_back(read_scenario_camera(path, root, key, static_cast<int>(s.cameras.size()), file, named));
    s.camera_files.push_back(file);
  }
  if (root.has("handover")) {
    const FileSection h(path, root.node("handover"), "handover", {"at_s", "mode"});
    s.handover.at_s = h.number_or("at_s", 0.0, longest_s, 0.0);
    s.handover.navigation = h.word("mode", mode_words);
    if (stereo || s.handover.navigation == app::NavigationKind::coop_stereo)
      h.fail(h.node("mode"), "a hand-over with two cameras", "noncoop and coop-mono");
    if (s.sensor == SensorKind::features) h.fail(root.node("handover"), "a hand-over without images", "sensor: images");
  }
  if (root.has("target")) {
    s.target_file = root.file("target", "a target model");
    named.add(s.target_file);
    s.target = read_target_file(s.target_file);
  } else if (s.navigation != app::NavigationKind::noncoop || s.handover.at_s >= 0.0) {
    static_cast<void>(root.require("target", "a target model with a cooperative mode"));
  }
  if (root.has("features")) {
    s.features = read_features(FileSection(path, root.node("features"), "features",
                                           {"count", "sigma_px", "first_view_sigma_px", "outlier_share", "outlier_px",
                                            "missed_share", "body_points", "half_size_m", "opaque_body"}));
  }
  if (root.has("render")) s.render = root.node("render");
  if (s.render.IsMap() && s.render["mesh"])
    named.add((std::filesystem::path(path).parent_path() / s.render["mesh"].Scalar()).string());
  s.faults = read_faults(path, root.node("faults"));
  if (!s.faults.empty() && s.sensor == SensorKind::features)
    root.fail(root.node("faults"), "faults of a camera without images", "sensor: images, or no faults");
  if (root.has("lines")) {
    s.lines = read_lines(FileSection(path, root.node("lines"), "lines",
                                     {"heartbeat", "pulse", "exposure", "pulse_jitter_s", "clock_drift_ppb"}));
  }
  s.commands = read_commands(path, root.node("telecommands"), s.duration_s);
  for (const char* key : {"lines", "telecommands"}) {
    if (root.has(key) && s.sensor == SensorKind::features)
      root.fail(root.node(key), std::string(key) + " without a flight loop", "sensor: images");
  }
  s.reference = read_reference(path, root.node("reference"));
  read_errors(root, path, s);
  s.flight = read_flight(path, node, root, s);
  s.flight.lines = line_config_of(s.lines);
  s.crc = named.crc();
  return s;
}

}  // namespace relnav::hil
