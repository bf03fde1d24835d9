#include "hil/replay/flight_config_file.hpp"

#include "tests/unit/hil/scratch.hpp"

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
  CHECK_MESSAGE_HOLDS(failure("cooperative: {sensor_bits: 300}\n"), "expected a whole number from 0 to 255");
}

TEST(FlightConfigFile, MessagesNameFileLineAndExpectation) {
  CHECK_MESSAGE_HOLDS(failure("filter:\n  gate: 3\n"), "c.yaml:2: unknown key 'filter.gate' (expected one of ");
  CHECK_MESSAGE_HOLDS(failure("filters:\n  gate: 3\n"),
                      "c.yaml:1: unknown section 'filters' (expected one of cooperative, filter, front_end, loop)");
  CHECK_MESSAGE_HOLDS(failure("filter:\n  gate_chi2: .nan\n"),
                      "c.yaml:2: filter.gate_chi2 is '.nan' (expected a positive number)");
  CHECK_MESSAGE_HOLDS(failure("filter:\n  gate_chi2: nan\n"), "expected a finite number");
  CHECK_MESSAGE_HOLDS(failure("loop:\n\n  min_inliers: 70000\n"),
                      "c.yaml:3: loop.min_inliers is '70000' (expected a whole number from 0 to 65535)");
  CHECK_MESSAGE_HOLDS(failure("loop: {min_inliers: [1]}\n"), "expected a single value");
  CHECK_MESSAGE_HOLDS(failure("loop: 3\n"), "c.yaml:1: section 'loop' holds no keys");
  CHECK_MESSAGE_HOLDS(failure("filter: {chart: euler}\n"), "expected mrp or rodrigues");
  CHECK_MESSAGE_HOLDS(failure("a: [1\n"), "not YAML");
  CHECK_MESSAGE_HOLDS(failure("text"), "holds no sections");
}
