#include "platform/files/flight_file.hpp"

#include <array>
#include <filesystem>
#include <vector>

#include "platform/files/file_section.hpp"
#include "platform/files/flight_config_file.hpp"
#include "platform/files/flight_setup.hpp"
#include "platform/files/flight_words.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/target_file.hpp"
#include "platform/files/text.hpp"
#include "platform/files/yaml_reader.hpp"

namespace relnav {
namespace {

constexpr Words<bool, 2> gain_words{{{"linear", false}, {"db", true}}};
constexpr Words<CameraSource::Trigger, 3> trigger_words{{{"free-running", CameraSource::Trigger::free_running},
                                                         {"software", CameraSource::Trigger::software},
                                                         {"line", CameraSource::Trigger::line}}};
constexpr Words<CameraSource::Stamps, 4> stamp_words{{{"start-of-exposure", CameraSource::Stamps::start_of_exposure},
                                                      {"mid-exposure", CameraSource::Stamps::mid_exposure},
                                                      {"end-of-exposure", CameraSource::Stamps::end_of_exposure},
                                                      {"original", CameraSource::Stamps::original}}};

/// Significant bits of the formats that have more than eight.
constexpr Words<std::uint8_t, 5> deep_formats{{{"y10", 10}, {"y12", 12}, {"y16", 16}, {"y10p", 10}, {"y12p", 12}}};

/// What follows `scheme` in `text`.
std::optional<std::string> after(const std::string& scheme, const std::string& text) {
  if (text.rfind(scheme, 0) != 0 || text.size() == scheme.size()) return std::nullopt;
  return text.substr(scheme.size());
}

CameraSource read_source(const FileSection& section) {
  CameraSource source;
  const std::string expectation = "v4l2:/dev/videoN or aravis:NAME";
  const std::string where = section.text("source", expectation);
  if (const auto node = after("v4l2:", where)) {
    source.device = *node;
  } else if (const auto name = after("aravis:", where)) {
    source.kind = CameraSource::Kind::aravis;
    source.device = *name;
  } else {
    section.fail(section.node("source"), "camera source " + in_quotes(where), expectation);
  }
  constexpr double most = 1e9;
  constexpr std::int64_t most_bytes = 1 << 30;
  source.serial = section.text_or("serial", "");
  source.format = section.text_or("format", "");
  source.rate_hz = section.number_or("rate_hz", 1e-3, 1e4, 0.0);
  source.exposure_us = section.number_or("exposure_us", 1.0, most, 0.0);
  source.gain = section.number_or("gain", 0.0, most, -1.0);
  source.gain_in_db = section.word_or("gain_unit", gain_words, source.kind == CameraSource::Kind::aravis);
  source.gain_step = section.number_or("gain_step", 1e-6, 1e6, 1.0);
  source.trigger = section.word_or("trigger", trigger_words, CameraSource::Trigger::free_running);
  source.stamps = section.word_or("stamps", stamp_words, CameraSource::Stamps::end_of_exposure);
  source.copy_frames = section.yes_no_or("copy_frames", false);
  source.packet_bytes = static_cast<std::uint32_t>(section.whole_or("packet_bytes", 220, 65'535, 0));
  source.socket_buffer_bytes = static_cast<std::uint32_t>(section.whole_or("socket_buffer_bytes", 4096, most_bytes, 0));
  if (source.kind == CameraSource::Kind::aravis) return source;
  for (const char* key : {"serial", "packet_bytes", "socket_buffer_bytes"}) {
    if (section.has(key))
      section.fail(section.node(key), std::string(key) + " with a V4L2 camera", "it with aravis: only");
  }
  if (source.trigger == CameraSource::Trigger::software) {
    section.fail(section.node("trigger"), "a V4L2 camera has no software trigger", "free-running or line");
  }
  return source;
}

const std::vector<std::string> camera_keys{
    "source", "calibration", "format", "rate_hz",      "exposure_us",         "gain",      "trigger",
    "stamps", "copy_frames", "serial", "packet_bytes", "socket_buffer_bytes", "gain_unit", "gain_step"};

/// A camera's section: its source, and its calibration into `calibration`.
CameraSource read_camera(const std::string& path, const YAML::Node& node, const std::string& name, int index,
                         CameraCalibration& calibration, std::string& calibration_file) {
  const FileSection section(path, node, name, camera_keys);
  calibration_file = section.file("calibration", "a camera calibration file");
  calibration = read_camera_file(calibration_file, index);
  return read_source(section);
}

TelemetryOutput read_output(const FileSection& link) {
  const std::string expectation = "udp://HOST:PORT, file:PATH or serial:DEVICE@BAUD";
  const std::string text = link.text("telemetry", expectation);
  TelemetryOutput output;
  if (const auto address = udp_address_in(text)) {
    output.address = *address;
    return output;
  }
  if (const auto file = after("file:", text)) {
    output.kind = TelemetryOutput::Kind::file;
    output.path = *file;
    return output;
  } else if (const auto serial = after("serial:", text)) {
    const std::size_t at = serial->rfind('@');
    const auto baud = at == std::string::npos ? std::nullopt : parse_int64(std::string_view(*serial).substr(at + 1));
    if (baud && *baud > 0 && *baud <= 4'000'000 && at > 0) {
      output.kind = TelemetryOutput::Kind::serial;
      output.path = serial->substr(0, at);
      output.baud = static_cast<std::uint32_t>(*baud);
      return output;
    }
  }
  link.fail(link.node("telemetry"), "link.telemetry is " + in_quotes(text), expectation);
}

void read_link(const FileSection& link, FlightFile& flight) {
  flight.telemetry = read_output(link);
  if (!link.has("telecommands")) return;
  const std::string expectation = "udp://ADDRESS:PORT to listen on";
  const std::string text = link.text("telecommands", expectation);
  flight.telecommands = udp_address_in(text);
  if (!flight.telecommands)
    link.fail(link.node("telecommands"), "link.telecommands is " + in_quotes(text), expectation);
}

LineNames read_lines_section(const FileSection& section) {
  LineNames lines;
  lines.chip = section.text("chip", "the path, name or label of a GPIO chip");
  const std::array<std::pair<const char*, std::string*>, 4> uses{{{"strobe", &lines.strobe},
                                                                  {"heartbeat", &lines.heartbeat},
                                                                  {"pulse", &lines.pulse},
                                                                  {"exposure", &lines.exposure}}};
  for (const auto& [key, name] : uses) {
    *name = section.text_or(key, "");
    for (const auto& [other_key, other] : uses) {
      if (other == name) break;
      if (!name->empty() && *name == *other)
        section.fail(section.node(key), std::string("lines.") + key + " and lines." + other_key + " are one line",
                     "a line for each use");
    }
  }
  return lines;
}

/// All that decides what the loop navigates on; where it is contradictory, the place of the contradiction.
FlightSetup read_setup(const std::string& path, const FileSection& root, FlightFile& flight) {
  FlightSetup setup;
  setup.navigation = root.word("mode", mode_words);
  const bool noncoop = setup.navigation == app::NavigationKind::noncoop;
  const bool stereo = setup.navigation == app::NavigationKind::coop_stereo;
  flight.camera = read_camera(path, root.require("camera", "a section that says where the camera is"), "camera", 0,
                              setup.camera, setup.camera_file);
  if (root.has("second_camera") != stereo) {
    root.fail(root.node(stereo ? "mode" : "second_camera"),
              stereo ? "coop-stereo without a second camera" : "a second camera without mode coop-stereo",
              "second_camera with mode coop-stereo, and only with it");
  }
  if (stereo) {
    flight.second = read_camera(path, root.node("second_camera"), "second_camera", 1, setup.second, setup.second_file);
    if (flight.second->kind == flight.camera.kind && flight.second->device == flight.camera.device)
      root.fail(root.node("second_camera"), "both cameras are " + in_quotes(flight.camera.device), "two cameras");
  }
  for (const char* key : {"motion", "range_m", "range_sigma_m"}) {
    if (!noncoop && root.has(key))
      root.fail(root.node(key), in_quotes(key) + " with a cooperative mode", "it with mode noncoop only");
  }
  if (noncoop && root.has("target"))
    root.fail(root.node("target"), "a target with mode noncoop", "it with a cooperative mode only");
  if (noncoop) {
    constexpr double most = 1e6;
    setup.rigid_target = root.word_or("motion", motion_words, true);
    setup.range_m = root.number_or("range_m", 1e-3, most, 0.0);
    setup.range_sigma_m = root.number_or("range_sigma_m", 0.0, most, -1.0);
  } else {
    setup.target_file = root.file("target", "a target model with mode coop-mono and coop-stereo");
    setup.target = read_target_file(setup.target_file);
  }
  return setup;
}

/// The bits of a pixel are told once: by the format.
void check_depth(const FileSection& root, const YAML::Node& node, FlightFile& flight) {
  const YAML::Node tuning = node["cooperative"];
  const YAML::Node stated = tuning && tuning.IsMap() ? tuning["sensor_bits"] : YAML::Node();
  for (const CameraSource* camera : {&flight.camera, flight.second ? &*flight.second : nullptr}) {
    if (camera == nullptr) continue;
    const YAML::Node at = node[camera == &flight.camera ? "camera" : "second_camera"]["format"];
    for (const auto& [name, bits] : deep_formats) {
      if (camera->format != name) continue;
      if (flight.loop.navigation == app::NavigationKind::noncoop)
        root.fail(at, "format " + in_quotes(name) + " with mode noncoop", "a format of 8 bits");
      if (stated.IsDefined() && !stated.IsNull())
        root.fail(stated, "cooperative.sensor_bits and format " + in_quotes(name), "the format alone");
      if (flight.second && flight.camera.format != flight.second->format)
        root.fail(at, "cameras of different formats", "the same format");
      flight.loop.coop.sensor_bits = bits;
    }
  }
}

/// What automatic exposure sets is not set by hand as well.
void check_exposure(const YAML::Node& node, const FileSection& root, const FlightFile& flight) {
  for (const char* camera : {"camera", "second_camera"}) {
    const YAML::Node section = node[camera];
    if (!section) continue;
    for (const char* key : {"exposure_us", "gain"}) {
      if (flight.loop.exposure.enabled && section[key])
        root.fail(section[key], std::string(camera) + "." + key + " with automatic exposure",
                  "exposure.start_us, exposure.gain_min, or no automatic exposure");
    }
    for (const char* key : {"gain_unit", "gain_step"}) {
      if (!flight.loop.exposure.enabled && section[key])
        root.fail(section[key], std::string(camera) + "." + key + " without automatic exposure",
                  "it with exposure.enabled only");
    }
  }
}

}  // namespace

FlightFile read_flight_file(const std::string& path) {
  const YAML::Node node = load_yaml(path, "a configuration of relnav-flight in YAML");
  std::vector<std::string> keys{"mode",          "target", "motion", "range_m",  "range_sigma_m", "camera",
                                "second_camera", "lines",  "link",   "realtime", "time"};
  const std::vector<std::string> tuning = flight_config_sections();
  keys.insert(keys.end(), tuning.begin(), tuning.end());
  const FileSection root(path, node, "", std::move(keys));

  FlightFile flight;
  const FlightSetup setup = read_setup(path, root, flight);
  flight.loop = flight_config_of(setup);
  check_depth(root, node, flight);
  read_flight_config(path, node, flight.loop);
  check_exposure(node, root, flight);
  NoncoopConfig& filter = flight.loop.navigator.filter;
  if (setup.range_m > 0.0) filter.range_m = setup.range_m;
  if (setup.range_sigma_m >= 0.0) filter.range_sigma_m = setup.range_sigma_m;

  read_link(FileSection(path, root.require("link", "a section that says where telemetry goes"), "link",
                        {"telemetry", "telecommands"}),
            flight);
  if (root.has("lines")) {
    flight.lines = read_lines_section(
        FileSection(path, root.node("lines"), "lines", {"chip", "strobe", "heartbeat", "pulse", "exposure"}));
  }
  if (root.has("realtime")) {
    const FileSection realtime(path, root.node("realtime"), "realtime", {"lock_memory", "priority"});
    flight.lock_memory = realtime.yes_no_or("lock_memory", true);
    flight.priority = static_cast<int>(realtime.whole_or("priority", 0, 99, 0));
  }
  if (root.has("time")) {
    const FileSection time(path, root.node("time"), "time", {"tai_utc_s"});
    flight.tai_utc_s = time.whole_or("tai_utc_s", 0, 1000, flight.tai_utc_s);
  }
  return flight;
}

}  // namespace relnav
