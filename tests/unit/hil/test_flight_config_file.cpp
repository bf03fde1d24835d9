#include "platform/files/flight_config_file.hpp"

#include "hil/replay/flight_driver.hpp"
#include "platform/files/text.hpp"
#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_clock.hpp"
#include "platform/host/scripted_packet_link.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

TEST_GROUP(FlightConfigFile) {
  Scratch scratch;
  app::FlightLoopConfig config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
  std::string failure(const std::string& text) {
    const std::string path = scratch.write("c.yaml", text);
    return message_of([&] { read_flight_config(path, config); });
  }
};

TEST(FlightConfigFile, ChangesWhatItNamesAndNothingElse) {
  const double gate = config.navigator.filter.gate_chi2;
  STRCMP_EQUAL("", failure("filter:\n  chart: rodrigues\n  pixel_sigma_px: 0.5\nfront_end: {fast_threshold: "
                           "20}\nloop:\n  lost_after_frames: 7\n  refuse_frozen: false\n")
                       .c_str());
  CHECK(config.navigator.filter.chart == AttitudeChartKind::rodrigues);
  DOUBLES_EQUAL(0.5, config.navigator.filter.pixel_sigma_px, 0.0);
  DOUBLES_EQUAL(gate, config.navigator.filter.gate_chi2, 0.0);
  CHECK_EQUAL(20, static_cast<int>(config.navigator.fast_threshold));
  CHECK_EQUAL(7, config.lost_after_frames);
  CHECK(!config.frames.refuse_frozen);
  STRCMP_EQUAL("", failure("").c_str());
  STRCMP_EQUAL("", failure("filter:\nloop:\n").c_str());
}

TEST(FlightConfigFile, CooperativeModesHaveTheirSection) {
  const double gain = config.coop.spots.gain_electrons_dn;
  STRCMP_EQUAL("", failure("cooperative:\n  expected_phi_z_rad: 1.57\n  sensor_bits: 12\n  acceleration_psd: 0.001\n"
                           "  pair_tolerance_ns: 5000\n")
                       .c_str());
  DOUBLES_EQUAL(1.57, config.coop.phi_CT_expected.z(), 0.0);
  CHECK_EQUAL(12, static_cast<int>(config.coop.sensor_bits));
  DOUBLES_EQUAL(0.001, config.coop.filter.noise.acceleration_psd, 0.0);
  CHECK_EQUAL(5000, config.second.pair_tolerance.ns);
  DOUBLES_EQUAL(gain, config.coop.spots.gain_electrons_dn, 0.0);
  CHECK_MESSAGE_HOLDS(failure("cooperative: {sensor_bits: 300}\n"), "expected a whole number from 8 to 16");
}

TEST(FlightConfigFile, MessagesNameFileLineAndExpectation) {
  CHECK_MESSAGE_HOLDS(failure("filter:\n  gate: 3\n"), "c.yaml:2: unknown key 'filter.gate' (expected one of ");
  CHECK_MESSAGE_HOLDS(
      failure("filters:\n  gate: 3\n"),
      "c.yaml:1: unknown section 'filters' (expected one of cooperative, exposure, filter, front_end, loop)");
  CHECK_MESSAGE_HOLDS(failure("filter:\n  gate_chi2: .nan\n"),
                      "c.yaml:2: filter.gate_chi2 is '.nan' (expected a positive number)");
  CHECK_MESSAGE_HOLDS(failure("filter:\n  gate_chi2: nan\n"), "expected a positive number");
  CHECK_MESSAGE_HOLDS(failure("loop:\n\n  min_inliers: 70000\n"),
                      "c.yaml:3: loop.min_inliers is '70000' (expected a whole number from 0 to 65535)");
  CHECK_MESSAGE_HOLDS(failure("loop: {min_inliers: [1]}\n"), "expected a single value");
  CHECK_MESSAGE_HOLDS(failure("loop: 3\n"), "c.yaml:1: section 'loop' holds no keys");
  CHECK_MESSAGE_HOLDS(failure("filter: {chart: euler}\n"), "expected mrp or rodrigues");
  CHECK_MESSAGE_HOLDS(failure("a: [1\n"), "not YAML");
  CHECK_MESSAGE_HOLDS(failure("text"), "holds no sections");
}

TEST(FlightConfigFile, ValuesOutsideOfTheirDomainsAreNamed) {
  struct Case {
    const char* section;
    const char* key;
    const char* value;
    const char* expected;
  };
  const Case cases[] = {
      {"filter", "range_m", "0", "a positive number"},
      {"filter", "range_sigma_m", "-1", "a number of at least 0"},
      {"filter", "rate_sigma_rad_s", "0", "a positive number"},
      {"filter", "ransac_confidence", "1", "a number between 0 and 1"},
      {"filter", "start_frames", "0", "a whole number from 1 to 2147483647"},
      {"front_end", "cell_px", "15", "a whole number from 16 to 2147483647"},
      {"front_end", "min_score", "1.5", "a number from 0 to 1"},
      {"cooperative", "sensor_bits", "7", "a whole number from 8 to 16"},
      {"cooperative", "min_observations", "3", "a whole number from 4 to 65535"},
      {"cooperative", "psf_sigma_px", "0.2", "a number from 0.3 to 3"},
      {"cooperative", "flux_ratio", "1", "a number over 1"},
      {"cooperative", "max_elongation", "0.5", "a number of at least 1"},
      {"cooperative", "pair_tolerance_ns", "-1", "a whole number from 0 to "},
      {"loop", "lost_after_frames", "0", "a whole number from 1 to 65535"},
      {"loop", "max_age_ns", "-1", "a whole number from 0 to "},
      {"loop", "apid_base", "5", "7 APIDs that are free"},
      {"loop", "apid_base", "0xFB", "a whole number from 0 to 65535"},
      {"loop", "apid_base", "251", "7 APIDs that are free"},
  };
  for (const Case& c : cases) {
    const std::string text = std::string("\n") + c.section + ":\n  " + c.key + ": " + c.value + "\n";
    CHECK_MESSAGE_HOLDS(failure(text), std::string("c.yaml:3: ") + c.section + "." + c.key + " is '" + c.value +
                                           "' (expected " + c.expected);
  }
}

TEST(FlightConfigFile, AMovingCameraNeedsNoStartSigmas) {
  config = app::FlightLoopConfig::defaults(MotionKind::camera);
  STRCMP_EQUAL("", failure("filter: {rate_sigma_rad_s: 0}\n").c_str());
}

TEST(FlightConfigFile, ValuesThatContradictEachOtherAreNamed) {
  CHECK_MESSAGE_HOLDS(failure("cooperative:\n  range_max_m: 5\n  range_min_m: 7\n"),
                      "c.yaml:3: cooperative.range_min_m is 7, range_max_m 5 (expected range_min_m under range_max_m)");
  STRCMP_EQUAL("", failure("cooperative:\n  range_min_m: 200\n  range_max_m: 300\n").c_str());
  CHECK_MESSAGE_HOLDS(failure("filter:\n  inertia_second: 5\n"),
                      "c.yaml:2: filter.inertia_second is 5, inertia_third 1 (expected moments of inertia");
  STRCMP_EQUAL("", failure("filter:\n  inertia_second: 5\n  inertia_third: 4.5\n").c_str());
}

TEST_GROUP(FlightDriver) {
  Scratch scratch;
  platform::host::ScriptedClock clock;
  platform::host::ScriptedCamera camera{2, 4};
  platform::host::ScriptedPacketLink link{64};

  FlightSetup setup_with(std::size_t markers) {
    FlightSetup setup;
    setup.navigation = app::NavigationKind::coop_mono;
    setup.camera.intrinsics.fu = setup.camera.intrinsics.fv = 500.0;
    setup.camera.intrinsics.cu = 319.5;
    setup.camera.intrinsics.cv = 239.5;
    setup.camera.intrinsics.width_px = 640;
    setup.camera.intrinsics.height_px = 480;
    setup.camera_file = "sensor.yaml";
    setup.target_file = "mine.yaml";
    for (std::size_t i = 0; i < markers; ++i) {
      const double x = static_cast<double>(i);
      TargetFeature feature;
      feature.id = static_cast<std::uint16_t>(i);
      feature.p_T = Vec3(0.1 * x, 0.01 * x * x, 0.0);
      CHECK(setup.target.features.push_back(feature) == Status::ok);
    }
    return setup;
  }
  std::string failure(const FlightSetup& setup) {
    return message_of([&] {
      static_cast<void>(make_flight_driver(flight_config_of(setup), "mine.yaml", clock, camera, nullptr, link));
    });
  }
};

TEST(FlightDriver, ATargetFoundByItsLightsHas4To16) {
  for (const std::size_t markers : {std::size_t{4}, std::size_t{16}})
    STRCMP_EQUAL("", failure(setup_with(markers)).c_str());
  CHECK_MESSAGE_HOLDS(failure(setup_with(3)), "mine.yaml: 3 features (expected 4 to 16");
  CHECK_MESSAGE_HOLDS(failure(setup_with(17)), "mine.yaml: 17 features (expected 4 to 16");
}

// What the reader lets pass the flight loop takes, key by key: nothing is left to a message without a line.
TEST(FlightDriver, TakesWhatTheConfigurationFileMaySay) {
  const char* values[] = {"-1", "0", "1e-9", "0.5", "1", "3", "5", "20", "249", "1e12", "true", "mrp"};
  std::size_t taken = 0;
  const auto try_value = [&](const std::string& section, const std::string& key, const std::string& value) {
    const bool coop = section == "cooperative" || section == "loop";
    FlightSetup setup = setup_with(4);
    setup.navigation = coop ? app::NavigationKind::coop_mono : app::NavigationKind::noncoop;
    setup.config_file = scratch.write("c.yaml", section + ":\n  " + key + ": " + value + "\n");
    const std::string message = failure(setup);
    CHECK_TEXT(message.empty() || message.find("c.yaml:2: ") != std::string::npos,
               (section + "." + key + ": " + message).c_str());
    if (message.empty()) ++taken;
    return message;
  };
  std::size_t keys = 0;
  for (const char* section : {"filter", "front_end", "cooperative", "loop"}) {
    const std::string known = try_value(section, "unknown", "1");
    const std::string list_begin = "expected one of ";
    std::string list = known.substr(known.find(list_begin) + list_begin.size());
    list.pop_back();  // the bracket
    for (const std::string_view key : split(list, ',')) {
      ++keys;
      for (const char* value : values) static_cast<void>(try_value(section, std::string(key), value));
    }
  }
  CHECK(keys > 60);
  CHECK(taken > 5 * keys);
}
