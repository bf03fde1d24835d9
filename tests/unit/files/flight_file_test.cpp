#include "platform/files/flight_file.hpp"

#include "tests/support/yaml_tables.hpp"  // before CppUTest redefines operators

#include "tests/support/scratch.hpp"

using namespace relnav;
using relnav::test::message_of;
using relnav::test::replaced;
using relnav::test::Scratch;

namespace {

const std::string camera_file =
    "resolution: [640, 480]\n"
    "camera_model: pinhole\n"
    "intrinsics: [660, 660, 320, 240]\n"
    "distortion_model: none\n"
    "distortion_coefficients: []\n"
    "T_BS: {cols: 4, rows: 4, data: [1, 0, 0, 0.2, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}\n";

const std::string target_file =
    "frame: T\n"
    "features:\n"
    "  - {id: 0, xyz: [0.5, 0, 0]}\n"
    "  - {id: 1, xyz: [0, 0.7, 0]}\n"
    "  - {id: 2, xyz: [-0.5, 0, 0.1]}\n"
    "  - {id: 3, xyz: [0, -0.3, 0]}\n";

const std::string mono =
    "mode: coop-mono\n"                               // 1
    "target: target.yaml\n"                           // 2
    "camera:\n"                                       // 3
    "  source: v4l2:/dev/video3\n"                    // 4
    "  calibration: cam0.yaml\n"                      // 5
    "  format: y12\n"                                 // 6
    "  rate_hz: 10\n"                                 // 7
    "  exposure_us: 1500\n"                           // 8
    "  trigger: line\n"                               // 9
    "  stamps: start-of-exposure\n"                   // 10
    "lines: {chip: fsw, strobe: STROBE, pulse: 3}\n"  // 11
    "link:\n"                                         // 12
    "  telemetry: udp://[::1]:5000\n"                 // 13
    "  telecommands: udp://0.0.0.0:5001\n"            // 14
    "realtime: {lock_memory: false, priority: 20}\n"  // 15
    "loop: {lost_after_frames: 7}\n";                 // 16

}  // namespace

TEST_GROUP(FlightFile) {
  Scratch scratch;

  FlightFile read(const std::string& text) {
    static_cast<void>(scratch.write("cam0.yaml", camera_file));
    static_cast<void>(scratch.write("target.yaml", target_file));
    return read_flight_file(scratch.write("flight.yaml", text));
  }
  std::string failure(const std::string& text) {
    return message_of([&] { static_cast<void>(read(text)); });
  }
  void refused(const std::string& from, const std::string& to, const std::string& expected) {
    const std::string message = failure(replaced(mono, from, to));
    CHECK_TRUE_TEXT(message.find("flight.yaml:" + expected) != std::string::npos, message.c_str());
  }
};

TEST(FlightFile, EverythingThatItSays) {
  const FlightFile file = read(mono);
  CHECK(file.loop.navigation == app::NavigationKind::coop_mono);
  LONGS_EQUAL(4, file.loop.coop.target.features.size());
  LONGS_EQUAL(640, file.loop.camera.width_px);
  LONGS_EQUAL(7, file.loop.lost_after_frames);
  LONGS_EQUAL(12, file.loop.coop.sensor_bits);
  CHECK(file.camera.kind == CameraSource::Kind::v4l2);
  STRCMP_EQUAL("/dev/video3", file.camera.device.c_str());
  STRCMP_EQUAL("y12", file.camera.format.c_str());
  DOUBLES_EQUAL(10.0, file.camera.rate_hz, 0.0);
  DOUBLES_EQUAL(1500.0, file.camera.exposure_us, 0.0);
  CHECK(file.camera.trigger == CameraSource::Trigger::line);
  CHECK(file.camera.stamps == CameraSource::Stamps::start_of_exposure);
  CHECK_FALSE(file.second.has_value());
  STRCMP_EQUAL("fsw", file.lines.chip.c_str());
  STRCMP_EQUAL("STROBE", file.lines.strobe.c_str());
  STRCMP_EQUAL("3", file.lines.pulse.c_str());
  STRCMP_EQUAL("", file.lines.heartbeat.c_str());
  STRCMP_EQUAL("::1", file.telemetry.address.host.c_str());
  LONGS_EQUAL(5000, file.telemetry.address.port);
  LONGS_EQUAL(5001, file.telecommands->port);
  CHECK_FALSE(file.lock_memory);
  LONGS_EQUAL(20, file.priority);
}

TEST(FlightFile, OtherOutputsAndModes) {
  const std::string serial = replaced(mono, "udp://[::1]:5000", "serial:/dev/ttyS1@115200");
  CHECK(read(serial).telemetry.kind == TelemetryOutput::Kind::serial);
  LONGS_EQUAL(115'200, read(serial).telemetry.baud);
  STRCMP_EQUAL("/dev/ttyS1", read(serial).telemetry.path.c_str());
  STRCMP_EQUAL("a/b.bin", read(replaced(mono, "udp://[::1]:5000", "file:a/b.bin")).telemetry.path.c_str());

  std::string noncoop =
      replaced(mono, "mode: coop-mono\ntarget: target.yaml", "mode: noncoop\nrange_m: 5\nrange_sigma_m: 0.2");
  noncoop = replaced(noncoop, "  format: y12\n", "  format: grey8\n");
  const FlightFile file = read(noncoop);
  DOUBLES_EQUAL(5.0, file.loop.navigator.filter.range_m, 0.0);
  DOUBLES_EQUAL(0.2, file.loop.navigator.filter.range_sigma_m, 0.0);
  CHECK(file.loop.scale_known);
  std::string stereo = replaced(mono, "coop-mono", "coop-stereo");
  stereo += "second_camera: {source: aravis:RIGHT, serial: '17', calibration: cam1.yaml, format: y12}\n";
  static_cast<void>(scratch.write("cam1.yaml", replaced(camera_file, "0.2", "-0.3")));
  const FlightFile pair = read(stereo);
  CHECK(pair.second->kind == CameraSource::Kind::aravis);
  STRCMP_EQUAL("17", pair.second->serial.c_str());
  DOUBLES_EQUAL(0.5, pair.loop.second.t_C1C0.x(), 1e-12);
}

TEST(FlightFile, AutomaticExposure) {
  CHECK_FALSE(read(mono).loop.exposure.enabled);
  const std::string automatic = replaced(mono, "  exposure_us: 1500\n", "  gain_step: 0.5\n") +
                                "exposure: {enabled: true, max_us: 5000, when_dark: raise, gain_max: 8}\n";  // 17
  const FlightFile file = read(automatic);
  CHECK_TRUE(file.loop.exposure.enabled);
  LONGS_EQUAL(5'000'000, file.loop.exposure.exposure_max.ns);
  CHECK(file.loop.exposure.when_dark == app::DarkAction::raise);
  DOUBLES_EQUAL(8.0, file.loop.exposure.gain_max, 0.0);
  CHECK_FALSE(file.camera.gain_in_db);
  DOUBLES_EQUAL(0.5, file.camera.gain_step, 0.0);
  CHECK_TRUE(read(replaced(automatic, "v4l2:/dev/video3", "aravis:A")).camera.gain_in_db);
  CHECK_FALSE(read(replaced(automatic, "v4l2:/dev/video3\n", "aravis:A\n  gain_unit: linear\n")).camera.gain_in_db);

  const auto refused_with = [&](const std::string& text, const std::string& expected) {
    const std::string message = failure(text);
    CHECK_TRUE_TEXT(message.find("flight.yaml:" + expected) != std::string::npos, message.c_str());
  };
  refused_with(replaced(automatic, "max_us: 5000", "max_us: 500"),
               "17: exposure.min_us is 50, start_us 1000, max_us 500 (expected min_us not over start_us, ");
  refused_with(replaced(automatic, "gain_max: 8", "gain_max: 0.5"), "17: exposure.gain_min is 1, gain_max 0.5 (");
  refused_with(replaced(automatic, "gain_max: 8", "target_level: 240"),
               "17: exposure.black_level is 0, dark_level 24, target_level 240, ceiling_level 225 (");
  refused_with(replaced(automatic, "gain_max: 8", "max_step: 1.1"), "17: exposure.dead_band is 1.15, max_step 1.1 (");
  refused_with(replaced(automatic, "gain_max: 8", "dead_band: 1"),
               "17: exposure.dead_band is '1' (expected a number over 1, up to 1000)");
  refused_with(replaced(automatic, "raise", "up"), "17: exposure.when_dark is 'up' (expected hold or raise)");
  refused_with(replaced(automatic, "max_us: 5000", "max_us: 5e3"), "17: exposure.max_us is '5e3' (expected a whole ");
  refused_with(replaced(automatic, "enabled: true", "enabled: 1"), "17: exposure.enabled is '1' (expected true or ");
  refused_with(replaced(automatic, "  gain_step: 0.5\n", "  exposure_us: 1500\n"),
               "8: camera.exposure_us with automatic exposure (expected exposure.start_us, ");
  refused_with(replaced(automatic, "  gain_step: 0.5\n", "  gain: 3\n"), "8: camera.gain with automatic exposure (");
  refused_with(replaced(automatic, "enabled: true", "enabled: false"),
               "8: camera.gain_step without automatic exposure (");
  refused_with(replaced(automatic, "gain_step: 0.5", "gain_step: 0"), "8: camera.gain_step is '0' (");
  refused_with(replaced(automatic, "gain_step: 0.5", "gain_unit: dB"), "8: camera.gain_unit is 'dB' (");
}

TEST(FlightFile, RefusedWithPlaceAndExpectation) {
  refused("rate_hz: 10", "format: y10", "7: key 'camera.format' a second time (expected it once)");
  refused("realtime:", "mode: noncoop\nrealtime:", "15: key 'mode' a second time (expected it once)");
  refused("lost_after_frames: 7", "lost_after_frames: 7, lost_after_frames: 8",
          "16: key 'loop.lost_after_frames' a second time (expected it once)");
  refused("realtime:", "real_time:", "15: unknown key 'real_time' (expected one of mode, target, ");
  refused("rate_hz: 10", "rate: 10", "7: unknown key 'camera.rate' (expected one of source, ");
  refused("rate_hz: 10", "rate_hz: fast", "7: camera.rate_hz is 'fast' (expected a number from 0.001 to 10000)");
  refused("rate_hz: 10", "rate_hz: [1]", "7: camera.rate_hz is 'a list or map' (expected a number");
  refused("rate_hz: 10", "rate_hz: .inf", "7: camera.rate_hz is '.inf'");
  refused("priority: 20", "priority: 100", "15: realtime.priority is '100' (expected a whole number from 0 to 99)");
  refused("lock_memory: false", "lock_memory: maybe",
          "15: realtime.lock_memory is 'maybe' (expected one of true, false)");
  refused("mode: coop-mono", "mode: coop", "1: mode is 'coop' (expected one of noncoop, coop-mono, coop-stereo)");
  refused("mode: coop-mono\n", "", "1: missing key 'mode'");
  refused("target: target.yaml\n", "", "1: missing key 'target'");
  refused("v4l2:/dev/video3", "/dev/video3",
          "4: camera source '/dev/video3' (expected v4l2:/dev/videoN or aravis:NAME)");
  refused("trigger: line", "trigger: software", "9: a V4L2 camera has no software trigger");
  refused("trigger: line", "serial: 12", "9: serial with a V4L2 camera");
  refused("udp://[::1]:5000", "udp://[::1]",
          "13: link.telemetry is 'udp://[::1]' (expected udp://HOST:PORT, file:PATH");
  refused("udp://[::1]:5000", "serial:/dev/ttyS1", "13: link.telemetry is 'serial:/dev/ttyS1'");
  refused("udp://0.0.0.0:5001", "udp://0.0.0.0:70000", "14: link.telecommands is 'udp://0.0.0.0:70000'");
  refused("pulse: 3", "pulse: STROBE", "11: lines.pulse and lines.strobe are one line");
  refused("{chip: fsw, strobe: STROBE, pulse: 3}", "{strobe: STROBE}", "11: missing key 'lines.chip'");
  refused("{lost_after_frames: 7}", "{lost_after_frames: 0}", "16: loop.lost_after_frames is '0'");
  refused("{lost_after_frames: 7}", "{lost: 0}", "16: unknown key 'loop.lost'");
  refused("realtime: {lock_memory: false, priority: 20}", "cooperative: {range_min_m: 7, range_max_m: 5}",
          "15: cooperative.range_min_m is 7, range_max_m 5 (expected range_min_m under range_max_m)");
  refused("realtime: {lock_memory: false, priority: 20}", "cooperative: {sensor_bits: 10}",
          "15: cooperative.sensor_bits and format 'y12'");
  refused("mode: coop-mono\ntarget: target.yaml", "mode: noncoop", "5: format 'y12' with mode noncoop");
  refused("mode: coop-mono", "mode: noncoop", "2: a target with mode noncoop");
  refused("mode: coop-mono", "mode: coop-mono\nrange_m: 3", "2: 'range_m' with a cooperative mode");
  refused("mode: coop-mono", "mode: coop-stereo", "1: coop-stereo without a second camera");
  refused("mode: coop-mono", "mode: [", "");
  CHECK(failure("") != "");
  CHECK(failure("- a\n").find("flight.yaml:1:") != std::string::npos);
}

TEST(FlightFile, FilesThatItNames) {
  const std::string missing = failure(replaced(mono, "cam0.yaml", "cam7.yaml"));
  CHECK_TRUE_TEXT(missing.find("cam7.yaml: ") != std::string::npos, missing.c_str());
  const std::string large = message_of([&] {
    static_cast<void>(read(mono));
    static_cast<void>(scratch.write("cam0.yaml", replaced(camera_file, "[640, 480]", "[64000, 480]")));
    static_cast<void>(read_flight_file(scratch.path("flight.yaml")));
  });
  CHECK_TRUE_TEXT(large.find("larger than this build takes") != std::string::npos, large.c_str());
}
