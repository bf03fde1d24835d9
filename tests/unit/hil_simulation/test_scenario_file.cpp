// Scenario files: what is read, what a campaign's runs draw, and every kind of bad input with its one line.
#include <cmath>
#include <set>

#include "hil/simulation/scenario_file.hpp"
#include "hil/simulation/simulation_plan.hpp"
#include "platform/files/input_error.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::Scratch;

namespace {

const std::string spin =
    "mode: noncoop\n"
    "sensor: features\n"
    "duration_s: 2\n"
    "rate_hz: 5\n"
    "seed: 7\n"
    "camera: {fu_px: 900}\n"
    "motion:\n"
    "  target: {rate_deg_s: [0, 2, 0]}\n"
    "  chaser: {range_m: 8}\n";

std::string swapped(const std::string& text, const std::string& from, const std::string& to) {
  std::string out = text;
  const std::size_t at = out.find(from);
  CHECK_TRUE(at != std::string::npos);
  return out.replace(at, from.size(), to);
}

}  // namespace

TEST_GROUP(ScenarioFile) {
  Scratch scratch;

  SimulationScenario read(const std::string& text, std::uint64_t run = 0) {
    return read_scenario(scratch.write("s.yaml", text), {run});
  }
  std::string failure(const std::string& text, std::uint64_t run = 0) {
    return relnav::test::message_of([&] { static_cast<void>(plan_simulation(read(text, run))); });
  }
};

TEST(ScenarioFile, WhatItSaysIsRead) {
  const SimulationScenario s = read(spin);
  STRCMP_EQUAL("s", s.name.c_str());
  LONGS_EQUAL(7, s.seed);
  CHECK_TRUE(s.sensor == SensorKind::features);
  DOUBLES_EQUAL(8.0, s.flight.navigator.filter.range_m, 1e-9);  // the true range, where none is stated
  const SimulationPlan plan = plan_simulation(s);
  LONGS_EQUAL(11, plan.frames.size());
  CHECK_TRUE(plan.frames[3].time.ns == simulation_start_ns + 600'000'000);
  DOUBLES_EQUAL(8.0, plan.truth[3].t_CT.z(), 1e-9);
}

TEST(ScenarioFile, EachRunDrawsItsOwnFromTheDispersions) {
  const std::string text = spin +
                           "features: {sigma_px: 0.3}\n"
                           "dispersions:\n"
                           "  features.sigma_px: {factor: 0.2}\n"
                           "  motion.target.rate_deg_s: {normal: 0.1}\n"
                           "  flight.range_error_m: {uniform: 0.5}\n"
                           "  motion.chaser.range_m: {choice: [6, 9]}\n"
                           "loop: {min_inliers: 4}\n";
  const SimulationScenario as_it_stands = read(text);
  CHECK_TRUE(as_it_stands.dispersed.empty());
  DOUBLES_EQUAL(0.3, as_it_stands.features.sigma_px, 0.0);
  const SimulationScenario first = read(text, 1);
  const SimulationScenario again = read(text, 1);
  const SimulationScenario second = read(text, 2);
  CHECK_TRUE(first.seed != second.seed && first.seed != as_it_stands.seed);
  CHECK_TRUE(first.dispersed == again.dispersed);
  CHECK_TRUE(first.dispersed != second.dispersed);
  LONGS_EQUAL(6, first.dispersed.size());  // three rates
  CHECK_TRUE(first.dispersed.contains("motion.target.rate_deg_s.1"));
  DOUBLES_EQUAL(first.dispersed.at("features.sigma_px"), first.features.sigma_px, 0.0);
  // Not by the order in the file.
  const std::string turned = swapped(swapped(text, "  features.sigma_px: {factor: 0.2}\n", ""), "loop: {min_inliers",
                                     "  features.sigma_px: {factor: 0.2}\nloop: {min_inliers");
  CHECK_TRUE(read(turned, 1).dispersed == first.dispersed);
}

TEST(ScenarioFile, DispersionsHaveTheSpreadTheyState) {
  const std::string text = spin +
                           "features: {sigma_px: 1}\ndispersions:\n  features.sigma_px: {uniform: 0.5}\n"
                           "  motion.target.rate_deg_s.1: {normal: 0.25}\n";
  constexpr int runs = 400;
  double sum = 0.0, squares = 0.0, low = 2.0, high = 0.0;
  for (int k = 1; k <= runs; ++k) {
    const SimulationScenario s = read(text, static_cast<std::uint64_t>(k));
    const double rate = s.dispersed.at("motion.target.rate_deg_s.1") - 2.0;
    sum += rate;
    squares += rate * rate;
    low = std::min(low, s.features.sigma_px);
    high = std::max(high, s.features.sigma_px);
  }
  DOUBLES_EQUAL(0.0, sum / runs, 4.0 * 0.25 / std::sqrt(runs));
  DOUBLES_EQUAL(0.25, std::sqrt(squares / runs), 0.04);
  CHECK_TRUE(low >= 0.5 && low < 0.52 && high <= 1.5 && high > 1.48);
}

TEST(ScenarioFile, FaultsAreDispersedInTimeAndKind) {
  const std::string text = swapped(spin, "sensor: features\n", "") +
                           "faults: [\"torn@5:2\", \"black@1\", \"lost@3\"]\n"
                           "dispersions:\n"
                           "  faults.0: {uniform: 3}\n"
                           "  faults.1: {normal: 50}\n"
                           "  faults.2: {choice: [\"white@4\", none]}\n";
  LONGS_EQUAL(3, read(text).faults.size());
  std::size_t with_three = 0;
  std::set<std::uint64_t> frames;
  for (std::uint64_t run = 1; run <= 40; ++run) {
    const SimulationScenario s = read(text, run);
    CHECK_TRUE(s.faults[0].kind == FaultKind::torn && s.faults[0].count == 2);
    CHECK_TRUE(s.faults[0].frame >= 2 && s.faults[0].frame <= 8);
    DOUBLES_EQUAL(static_cast<double>(s.faults[0].frame), s.dispersed.at("faults.0"), 0.0);
    CHECK_TRUE(s.faults[1].frame < 1000);  // never before the first frame
    frames.insert(s.faults[0].frame);
    const bool third = s.faults.size() == 3;
    CHECK_TRUE(!third || (s.faults[2].kind == FaultKind::white && s.faults[2].frame == 4));
    DOUBLES_EQUAL(third ? 0.0 : 1.0, s.dispersed.at("faults.2"), 0.0);
    with_three += third ? 1 : 0;
  }
  CHECK_TRUE(frames.size() >= 5);
  CHECK_TRUE(with_three > 8 && with_three < 32);
}

TEST(ScenarioFile, TheChecksumIsOfTheFileAndOfAllItNames) {
  scratch.write("t.yaml",
                "frame: T\nfeatures:\n  - {id: 0, xyz: [0, 0, 0]}\n  - {id: 1, xyz: [1, 0, 0]}\n"
                "  - {id: 2, xyz: [0, 1, 0]}\n  - {id: 3, xyz: [0, 0, 1]}\n");
  const std::string text = swapped(spin, "mode: noncoop", "mode: coop-mono\ntarget: t.yaml");
  const std::uint32_t before = read(text).crc;
  CHECK_TRUE(read(text).crc == before);
  CHECK_TRUE(read(text + "# a word\n").crc != before);
  scratch.write("m.obj", "v 0 0 0\n");
  const std::string with_mesh = text + "render: {mesh: m.obj}\n";
  const std::uint32_t of_mesh = read(with_mesh).crc;
  scratch.write("m.obj", "v 0 0 1\n");
  CHECK_TRUE(read(with_mesh).crc != of_mesh);
  scratch.write("t.yaml",
                "frame: T\nfeatures:\n  - {id: 0, xyz: [0, 0, 0]}\n  - {id: 1, xyz: [1, 0, 0]}\n"
                "  - {id: 2, xyz: [0, 1, 0]}\n  - {id: 3, xyz: [0, 0, 2]}\n");
  CHECK_TRUE(read(text).crc != before);
}

TEST(ScenarioFile, BadInputIsNamedWithItsLine) {
  const auto place = [&](const std::string& text, const std::string& message, std::uint64_t run = 0) {
    CHECK_MESSAGE_HOLDS(failure(text, run), message.c_str());
  };
  place(spin + "speed: 3\n", "s.yaml:10: unknown key 'speed'");
  place(swapped(spin, "duration_s: 2", "duration_s: long"), "s.yaml:3: duration_s is 'long'");
  place(swapped(spin, "duration_s: 2", "duration_s: 0"), "s.yaml:3: duration_s is '0'");
  place(swapped(spin, "mode: noncoop", "mode: cooperative"), "s.yaml:1: mode is 'cooperative'");
  place(swapped(spin, "mode: noncoop", "mode: coop-mono"), "missing key 'target'");
  place(swapped(spin, "mode: noncoop", "mode: coop-stereo"), "s.yaml:1: coop-stereo without a second camera");
  place(swapped(spin, "camera:", "second_camera: {fu_px: 900}\ncamera:"), "a second camera without mode coop-stereo");
  place(swapped(spin, "range_m: 8", "range_m: 8, angles_deg: [0, 180, 0]"), "the target is 8.000 m behind the camera");
  place(swapped(spin, "range_m: 8", "range_m: 0"), "range_m is '0'");
  place(swapped(spin, "[0, 2, 0]", "[0, 2, 0], inertia_kg_m2: [1, 1, 3]"),
        "s.yaml:8: principal moments 1, 1, 3 kg m^2");
  place(swapped(spin, "[0, 2, 0]", "[0, 2, 0], inertia_kg_m2: [0, 1, 1]"),
        "s.yaml:8: principal moments 0, 1, 1 kg m^2");
  place(spin + "faults: [torn@5]\n", "faults of a camera without images");
  place(spin + "faults: [eaten@5]\n", "s.yaml:10: --fault 'eaten@5': is of no known kind");
  place(spin + "features: {count: 4000}\n", "s.yaml:10: features.count is '4000'");
  place(spin + "features: {half_size_m: [1, 0, 1]}\n", "features.half_size_m is not positive");
  place(spin + "camera: {fu_px: 900}\n", "camera");
  place(spin + "dispersions: {motion.target.mass: {normal: 1}}\n", "unknown key 'motion.target.mass'", 1);
  place(spin + "dispersions: {motion.moon.rate: {normal: 1}}\n", "unknown key 'motion.moon'", 1);
  place(spin + "dispersions: {seed: {normal: 1, uniform: 1}}\n", "dispersions.seed has 2 laws", 1);
  place(spin + "dispersions: {mode: {normal: 1}}\n", "s.yaml:1: 'mode' is 'noncoop'", 1);
  place(spin + "dispersions: {motion: {normal: 1}}\n", "'motion' is a section", 1);
  place(spin + "dispersions: {motion.target.rate_deg_s.3: {normal: 1}}\n", "names no element of the list", 1);
  place(spin + "lines: {pulse: true}\n", "lines without a flight loop");
  const std::string images = swapped(spin, "sensor: features\n", "");
  place(images + "lines: {pulse: yes, jitter: 1}\n", "s.yaml:9: unknown key 'lines.jitter'");
  place(images + "lines: {heartbeat: true, pulse_jitter_s: 1e-6}\n", "lines.pulse_jitter_s without a pulse line");
  place(images + "telecommands: stop\n", "s.yaml:9: telecommands is no list");
  place(images + "telecommands: [{at_s: 1, command: explode}]\n", "command is 'explode'");
  place(images + "telecommands: [{at_s: 3, command: ping}]\n", "at_s is '3'");
  place(images + "telecommands: [{command: ping}]\n", "missing key 'telecommands[].at_s'");
  place(images + "telecommands: [{at_s: 1, command: set_tai}]\n", "telecommand without its argument");
  place(images + "telecommands: [{at_s: 1, command: ping, argument: 1}]\n", "telecommand with an argument");
  place("{", "s.yaml:");
  CHECK_MESSAGE_HOLDS(relnav::test::message_of([] { static_cast<void>(read_scenario("/nowhere/s.yaml")); }).c_str(),
                      "/nowhere/s.yaml");
}

TEST(ScenarioFile, ATargetThatEndsBehindTheCameraIsNamedWithItsTime) {
  const std::string through = swapped(
      spin, "range_m: 8", "range_m: 8, pointing: fixed, legs: [{drift: {duration_s: 2, velocity_m_s: [0.5, 0, 8]}}]");
  CHECK_MESSAGE_HOLDS(failure(through), "the target is behind the camera after");
}
