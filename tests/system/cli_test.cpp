/// The relnav tool as a user meets it: exit status, one line on stderr, files.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <sstream>

#include "hil/evaluate/rotation.hpp"
#include "hil/io/covariance_csv.hpp"
#include "hil/io/image.hpp"
#include "hil/io/trajectory.hpp"
#include "hil/scenarios/stereo_scenarios.hpp"
#include "platform/files/camera_rig_file.hpp"
#include "tests/support/scratch.hpp"
#include "tests/system/tool_run.hpp"

using relnav::test::relnav_tool;
using relnav::test::Scratch;

namespace {

using Run = relnav::test::ToolRun;

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == text.size() - 1; }

const std::string sensor_yaml =
    "camera_model: pinhole\nintrinsics: [60.0, 60.0, 31.5, 23.5]\nresolution: [64, 48]\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\n";

/// A data set of small grey images.
std::string make_dataset(const Scratch& scratch, int frames) {
  std::string list = "#timestamp [ns],filename\n";
  const auto bytes = relnav::hil::encode_png({64, 48, 1, std::vector<std::uint8_t>(64 * 48, 0)});
  for (int i = 0; i < frames; ++i) {
    const std::string name = std::to_string(100'000'000'000 + i * 100'000'000LL) + ".png";
    list += name.substr(0, name.size() - 4) + "," + name + "\n";
    scratch.write("set/mav0/cam0/data/" + name, std::string(bytes.begin(), bytes.end()));
  }
  scratch.write("set/mav0/cam0/data.csv", list);
  scratch.write("set/mav0/cam0/sensor.yaml", sensor_yaml);
  return scratch.path("set");
}

}  // namespace

TEST_GROUP(Cli) {
  Scratch scratch;
  Run tool(const std::string& arguments) { return relnav_tool(scratch, arguments); }
  void check_unusable(const std::string& arguments, const std::string& piece) {
    const Run run = tool(arguments);
    CHECK_EQUAL_TEXT(2, run.exit_status, (arguments + "\n" + run.err).c_str());
    CHECK_TEXT(is_one_line(run.err), run.err.c_str());
    CHECK_TEXT(run.err.find(piece) != std::string::npos, run.err.c_str());
  }
};

TEST(Cli, HelpOnEveryLevel) {
  for (const char* level :
       {"", "replay ", "capture ", "export ", "montecarlo ", "solve ", "evaluate ", "tlm ", "tlm decode "}) {
    const Run run = tool(std::string(level) + "--help");
    CHECK_EQUAL_TEXT(0, run.exit_status, level);
    CHECK_TEXT(run.out.find("Usage:") != std::string::npos, level);
    CHECK_TEXT(run.err.empty(), run.err.c_str());
  }
}

TEST(Cli, UnusableArgumentsAreStatus2WithOneLine) {
  check_unusable("", "subcommand is required");
  check_unusable("fly", "subcommand is required");
  check_unusable("evaluate", "is required");
  check_unusable("evaluate --truth a --estimate b --align sideways", "sideways");
  check_unusable("replay --dataset x --mode hover --out y", "hover");
  check_unusable("replay --dataset x --mode noncoop --out y --range -1", "-1");
  check_unusable("replay --dataset x --mode noncoop --out y --range nan",
                 "--range: 'nan' (expected a positive number of metres)");
  check_unusable("replay --dataset x --mode noncoop --out y --motion sideways", "sideways");
  check_unusable("replay --dataset x --mode noncoop --out y --rate fast", "fast not in {max,real}");
  check_unusable("replay --dataset x --mode noncoop --out y --tlm http://h:1", "expected udp://HOST:PORT");
  check_unusable("replay --dataset x --mode coop-mono --out y", "x: is no folder");
  check_unusable("replay --dataset x --mode coop-mono --out y --range 5", "takes no --range");
  check_unusable("tlm decode " + scratch.path("none.bin"), "none.bin: cannot be opened");
}

TEST(Cli, EvaluateOfIdenticalFilesIsZero) {
  std::string tum;
  for (int i = 0; i < 30; ++i) tum += std::to_string(i) + " 0 " + std::to_string(0.1 * i) + " 5 0 0 0 1\n";
  const std::string path = scratch.write("t.tum", tum);
  const Run run = tool("evaluate --truth " + path + " --estimate " + path + " --json " + scratch.path("e.json"));
  CHECK_EQUAL(0, run.exit_status);
  CHECK(run.out.find("attitude error  deg    RMS    0.00000") != std::string::npos);
  CHECK(text_of(scratch.path("e.json")).find("\"compared_epochs\": 30") != std::string::npos);
}

TEST(Cli, EvaluateNamesWhatIsWrong) {
  const std::string good = scratch.write("t.tum", "1 0 0 5 0 0 0 1\n2 0 0 5 0 0 0 1\n");
  const std::string bad = scratch.write("b.tum", "1 0 0 5 0 0 0 1\n2 0 0\n");
  const std::string far = scratch.write("f.tum", "1000 0 0 5 0 0 0 1\n");
  check_unusable("evaluate --truth " + good + " --estimate " + bad, "b.tum:2: 3 values (expected 8 numbers");
  check_unusable("evaluate --truth " + good + " --estimate " + far, "no epoch in common");
  check_unusable("evaluate --truth " + good + " --estimate " + good + " --align sim3", "does not move");
  check_unusable("evaluate --truth " + good + " --estimate " + good + " --cov " + good, "expected the header line");
  check_unusable("evaluate --truth " + good + " --estimate " + good + " --json /dev/full", "cannot be written");
}

TEST(Cli, DecodeRefusesWhatIsNoTelemetry) {
  check_unusable("tlm decode " + scratch.write("x.bin", "# t tx ty tz\n"),
                 "x.bin: byte 0: no telemetry packet begins here");
  check_unusable("tlm decode " + scratch.write("x.bin", std::string("\x09\x00\xC0\x00", 4)), "incomplete");
  CHECK_EQUAL(0, tool("tlm decode " + scratch.write("empty.bin", "")).exit_status);
}

TEST(Cli, ReplayRefusesBadInputBeforeItTouchesTheOutput) {
  const std::string set = make_dataset(scratch, 3);
  const std::string out = scratch.path("out");
  const std::string replay = "replay --mode noncoop --range 5 --out " + out + " --dataset " + set;
  check_unusable("replay --mode noncoop --range 5 --out " + out + " --dataset " + scratch.path("nowhere"),
                 "is no folder");
  scratch.write("set/mav0/cam0/sensor.yaml", "resolution: [64, 48]\n");
  check_unusable(replay, "sensor.yaml: missing key 'camera_model'");
  scratch.write("set/mav0/cam0/sensor.yaml", sensor_yaml);
  scratch.write("set/mav0/cam0/data.csv", "#timestamp [ns],filename\n");
  check_unusable(replay, "data.csv: lists no image");
  CHECK(!std::filesystem::exists(out));
}

TEST(Cli, ReplayRefusesAFolderThatIsNotEmpty) {
  const std::string set = make_dataset(scratch, 3);
  scratch.write("out/mine.txt", "x");
  check_unusable("replay --mode noncoop --range 5 --dataset " + set + " --out " + scratch.path("out"), "is not empty");
  CHECK(!std::filesystem::exists(scratch.path("out/trajectory.tum")));
}

// Black frames: the loop runs, finds nothing and says so.
TEST(Cli, ReplayOfBlackFramesEndsInAFaultWithEveryFile) {
  const std::string set = make_dataset(scratch, 5);
  const std::string out = scratch.path("out");
  const Run run = tool("replay --mode noncoop --range 5 --dataset " + set + " --out " + out);
  CHECK_EQUAL_TEXT(1, run.exit_status, run.err.c_str());
  CHECK_TEXT(is_one_line(run.err), run.err.c_str());
  for (const char* name : {"trajectory.tum", "covariance.csv", "telemetry.bin", "events.log", "timing.csv",
                           "summary.json", "report.html"}) {
    CHECK_TEXT(std::filesystem::exists(out + "/" + name), name);
  }
  CHECK(std::filesystem::file_size(out + "/telemetry.bin") > 0);
  CHECK_EQUAL(0, tool("tlm decode " + out + "/telemetry.bin --json").exit_status);
}

TEST(Cli, ReplayStopsAtABadImageAndKeepsWhatWasDone) {
  const std::string set = make_dataset(scratch, 5);
  scratch.write("set/mav0/cam0/data/100300000000.png", "text");
  const Run run = tool("replay --mode noncoop --range 5 --dataset " + set + " --out " + scratch.path("out"));
  CHECK_EQUAL_TEXT(2, run.exit_status, run.err.c_str());
  CHECK_TEXT(is_one_line(run.err), run.err.c_str());
  CHECK_TEXT(run.err.find("100300000000.png: no PNG signature") != std::string::npos, run.err.c_str());
  const std::string timing = text_of(scratch.path("out/timing.csv"));
  CHECK_TEXT(timing.find("100200000000,") != std::string::npos, timing.c_str());
}

namespace {

const char* const run_files[] = {"trajectory.tum", "covariance.csv", "telemetry.bin", "events.log",
                                 "timing.csv",     "summary.json",   "report.html"};

}  // namespace

TEST_GROUP(CliSolve) {
  Scratch scratch;
  const std::string mono = scratch.path("mono");
  const std::string stereo = scratch.path("stereo");
  const std::string out = scratch.path("out");

  void setup() override {
    LONGS_EQUAL(0, relnav_tool(scratch, "scenario random --count 40 --out " + mono).exit_status);
    LONGS_EQUAL(0, relnav_tool(scratch, "scenario stereo-pose --count 1 --out " + stereo).exit_status);
  }
  std::string mono_files(const std::string& cameras = "") const {
    return "solve --mode coop-mono --camera " + mono + "/cam0.yaml " + cameras + " --target " + mono +
           "/target.yaml --observations " + mono + "/observations.csv --out ";
  }
  std::string stereo_files(const std::string& cameras) const {
    return "solve --mode coop-stereo " + cameras + " --target " + stereo + "/target.yaml --observations " + stereo +
           "/observations.csv --out ";
  }
  std::string both_cameras() const { return "--camera " + stereo + "/cam0.yaml --camera " + stereo + "/cam1.yaml"; }

  void check_done(const std::string& command, const std::string& folder, std::size_t epochs) {
    const Run run = relnav_tool(scratch, command);
    LONGS_EQUAL_TEXT(0, run.exit_status, (command + "\n" + run.err).c_str());
    CHECK_TEXT(run.err.empty(), run.err.c_str());
    for (const char* name : run_files) CHECK_TEXT(std::filesystem::exists(folder + "/" + name), name);
    LONGS_EQUAL_TEXT(epochs, relnav::hil::read_trajectory(folder + "/trajectory.tum").size(), command.c_str());
    LONGS_EQUAL(0, relnav_tool(scratch, "tlm decode " + folder + "/telemetry.bin").exit_status);
  }
  /// Exit status 2, one line with every piece, no output folder.
  void check_refused(const std::string& command, std::initializer_list<const char*> pieces) {
    const Run run = relnav_tool(scratch, command);
    const std::string text = command + "\n" + run.err;
    LONGS_EQUAL_TEXT(2, run.exit_status, text.c_str());
    CHECK_TEXT(is_one_line(run.err), text.c_str());
    for (const char* piece : pieces) CHECK_TEXT(run.err.find(piece) != std::string::npos, text.c_str());
    CHECK_TEXT(!std::filesystem::exists(out), command.c_str());
  }
  /// The mono scenario with the value of a column in its first row replaced (line 2 of the file).
  void check_row_refused(std::size_t column, const std::string& value, std::initializer_list<const char*> pieces) {
    std::string text = text_of(mono + "/observations.csv");
    std::size_t begin = text.find('\n') + 1;
    for (std::size_t i = 0; i < column; ++i) begin = text.find(',', begin) + 1;
    text.replace(begin, text.find_first_of(",\n", begin) - begin, value);
    const std::string file = scratch.write("bad.csv", text);
    check_refused("solve --mode coop-mono --camera " + mono + "/cam0.yaml --target " + mono +
                      "/target.yaml --observations " + file + " --out " + out,
                  pieces);
  }
  /// Largest difference between two runs' poses, over the sigma of each component.
  double largest_difference_sigma(const std::string& a, const std::string& b) const {
    const auto p = relnav::hil::read_trajectory(a + "/trajectory.tum");
    const auto q = relnav::hil::read_trajectory(b + "/trajectory.tum");
    const auto covariances = relnav::hil::read_covariances(a + "/covariance.csv");
    LONGS_EQUAL(p.size(), q.size());
    LONGS_EQUAL(p.size(), covariances.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      relnav::Vec6 d;
      d << p[i].t_CT - q[i].t_CT, relnav::hil::rotation_vector(p[i].R_CT * q[i].R_CT.transpose());
      largest = std::max(largest, d.cwiseAbs().cwiseQuotient(covariances[i].P.diagonal().cwiseSqrt()).maxCoeff());
    }
    return largest;
  }
};

TEST(CliSolve, OneCameraGivesAPoseAnEpochAndEveryFile) {
  check_done(mono_files() + out, out, 40);
  CHECK(text_of(out + "/summary.json").find("\"evaluation\"") != std::string::npos);
}

TEST(CliSolve, TwoCamerasWithEveryMethod) {
  for (const char* method : {"ml", "motor", "orthogonal"}) {
    const std::string folder = scratch.path(method);
    check_done(stereo_files(both_cameras()) + folder + " --method " + method, folder, 66);
    CHECK(text_of(folder + "/summary.json").find(std::string("\"method\": \"") + method + "\"") != std::string::npos);
    const char* estimator = std::string("ml") == method ? "stereo_least_squares" : method;
    const Run decoded = relnav_tool(scratch, "tlm decode " + folder + "/telemetry.bin");
    CHECK_TEXT(decoded.out.find(std::string("estimator=") + estimator + " ") != std::string::npos, method);
  }
  check_done(stereo_files(both_cameras()) + out + " --method motor --lines all", out, 66);
}

TEST(CliSolve, UnusableArgumentsLeaveNoFolder) {
  const std::string one = "--camera " + stereo + "/cam0.yaml";
  check_refused(stereo_files(one) + out, {"--mode coop-stereo", "1 camera", "expected 2 --camera"});
  check_refused(mono_files("--camera " + mono + "/cam0.yaml") + out,
                {"--mode coop-mono", "2 camera files given", "expected 1 --camera"});
  check_refused(mono_files() + out + " --method ml", {"--method ml", "coop-mono", "expected rodrigues"});
  check_refused(stereo_files(both_cameras()) + out + " --method rodrigues",
                {"--method rodrigues", "coop-stereo", "expected ml, motor or orthogonal"});
  check_refused(stereo_files(both_cameras()) + out + " --no-switching",
                {"--no-switching", "coop-stereo", "expected --mode coop-mono"});
  check_refused(stereo_files(both_cameras()) + out + " --method orthogonal --scalar fixed", {"--scalar", "double"});
  check_refused(mono_files() + out + " --scalar half", {"--scalar", "half not in {double,float,fixed}"});
  check_refused(mono_files() + out + " --sigma 0", {"--sigma", "'0' (expected a positive number of pixels)"});
  check_refused(mono_files() + out + " --sigma nan", {"--sigma", "'nan' (expected a positive number of pixels)"});
}

TEST(CliSolve, UnusableInputIsNamedWithItsPlaceAndLeavesNoFolder) {
  check_row_refused(2, "99", {"bad.csv:2:", "feature 99 is not in the target model", "expected ids"});
  check_row_refused(1, "1", {"bad.csv:2:", "camera 1 has no camera file", "expected cam 0"});
  check_row_refused(5, "0", {"bad.csv:2:", "sigma is '0'", "expected a positive number"});
  check_row_refused(5, "nan", {"bad.csv:2:", "sigma is 'nan'", "expected a finite number"});
  check_row_refused(3, "nan", {"bad.csv:2:", "u is 'nan'", "expected a finite number"});
  check_row_refused(4, "1e9", {"bad.csv:2:", "outside of camera 0's image", "expected a pixel of"});
  const std::string twice = scratch.write(
      "twice.yaml",
      "features:\n  - {id: 0, xyz: [0, 0, 0]}\n  - {id: 1, xyz: [1, 0, 0]}\n  - {id: 1, xyz: [0, 1, 0]}\n");
  check_refused("solve --mode coop-mono --camera " + mono + "/cam0.yaml --target " + twice + " --observations " + mono +
                    "/observations.csv --out " + out,
                {"twice.yaml:4:", "1", "expected"});
  check_refused("solve --mode coop-mono --camera " + mono + "/cam0.yaml --target " + mono +
                    "/target.yaml --observations " + scratch.path("none.csv") + " --out " + out,
                {"none.csv: cannot be opened"});
}

TEST(CliSolve, UnusableTargetFilesAreNamedWithTheirPlace) {
  const auto check_target = [&](const std::string& features, std::initializer_list<const char*> pieces) {
    const std::string file = scratch.write("bad.yaml", "features:\n" + features);
    check_refused("solve --mode coop-mono --camera " + mono + "/cam0.yaml --target " + file + " --observations " +
                      mono + "/observations.csv --out " + out,
                  pieces);
  };
  const std::string two = "  - {id: 0, xyz: [0, 0, 0]}\n  - {id: 1, xyz: [1, 0, 0]}\n";
  check_target(two + "  - {id: 1, xyz: [0, 1, 0]}\n", {"bad.yaml:4: id 1 again, first in line 3", "expected"});
  check_target(two, {"bad.yaml:2: 2 features", "expected at least 3"});
  check_target(two + "  - {id: 2, xyz: [2, 0, 0]}\n", {"bad.yaml:2: all 3 features lie on one line", "expected"});
  check_target(two + "  - {id: 2, xyz: [0, .inf, 0]}\n", {"bad.yaml:4: xyz of feature 2", "expected a finite number"});
  check_target("  - {id: 0, xyz: [.nan, 0, 0]}\n", {"bad.yaml:2: xyz of feature 0", "expected a finite number"});
}

TEST(CliSolve, UnreadableFilesAreNamed) {
  const std::string none = scratch.path("none");
  const std::string garbage = scratch.write("garbage", std::string("\x01\x02[\xff\n}", 6));
  const auto command = [&](const std::string& camera, const std::string& target, const std::string& observations) {
    return "solve --mode coop-mono --camera " + camera + " --target " + target + " --observations " + observations +
           " --out " + out;
  };
  const std::string camera = mono + "/cam0.yaml";
  const std::string target = mono + "/target.yaml";
  const std::string observations = mono + "/observations.csv";
  for (const std::string& bad : {none, mono}) {
    const char* what = bad == none ? "none: cannot be opened" : "mono: is a folder";
    check_refused(command(bad, target, observations), {what, "expected a readable file"});
    check_refused(command(camera, bad, observations), {what, "expected a readable file"});
    check_refused(command(camera, target, bad), {what, "expected a readable file"});
  }
  check_refused(command(garbage, target, observations), {"garbage", "expected"});
  check_refused(command(camera, garbage, observations), {"garbage", "expected a target model in YAML"});
  check_refused(command(camera, target, garbage), {"garbage:1:", "expected the header line"});
  check_refused(stereo_files("--camera " + stereo + "/cam0.yaml --camera " + none) + out, {"none: cannot be opened"});
  // A truth beside the observations that is none.
  scratch.write("mono/truth.tum", "no truth\n");
  check_refused(mono_files() + out, {"truth.tum:1:", "expected 8 numbers"});
}

TEST(CliSolve, ObservationsOutOfOrderAreNamed) {
  const std::string text = text_of(mono + "/observations.csv");
  const std::size_t header = text.find('\n') + 1;
  const std::string first = text.substr(header, text.find('\n', header) + 1 - header);
  const std::string file = scratch.write("bad.csv", text.substr(0, header) + "7" + first + first);
  check_refused("solve --mode coop-mono --camera " + mono + "/cam0.yaml --target " + mono +
                    "/target.yaml --observations " + file + " --out " + out,
                {"bad.csv:3: time 0 after 70", "expected rows sorted by time"});
  check_row_refused(5, "-1", {"bad.csv:2:", "sigma is '-1'", "expected a positive number of pixels"});
}

TEST(CliSolve, CamerasThatDisagreeWithTheObservationsAreNamed) {
  // Two cameras on the command line, one in the observations; both in one place; two in the observations, one here.
  std::string left;
  std::istringstream lines(text_of(stereo + "/observations.csv"));
  for (std::string line; std::getline(lines, line);) {
    if (line.find(",1,") != line.find(',')) left += line + "\n";
  }
  const std::string file = scratch.write("left.csv", left);
  check_refused("solve --mode coop-stereo " + both_cameras() + " --target " + stereo + "/target.yaml --observations " +
                    file + " --out " + out,
                {"left.csv: no row of camera 1, which has a camera file", "expected rows of every camera"});
  const std::string one = "--camera " + stereo + "/cam0.yaml ";
  check_refused(stereo_files(one + one) + out, {"cam0.yaml: stands where", "expected T_BS of each camera"});
  check_refused("solve --mode coop-mono " + one + "--target " + stereo + "/target.yaml --observations " + stereo +
                    "/observations.csv --out " + out,
                {"observations.csv:6: camera 1 has no camera file", "expected cam 0, or another --camera"});
}

TEST(CliSolve, AFolderThatIsNotEmptyIsLeftAlone) {
  scratch.write("full/mine.txt", "x");
  const Run run = relnav_tool(scratch, mono_files() + scratch.path("full"));
  LONGS_EQUAL_TEXT(2, run.exit_status, run.err.c_str());
  CHECK_TEXT(is_one_line(run.err), run.err.c_str());
  CHECK_TEXT(run.err.find("full: is not empty (expected a new or empty folder, or --force)") != std::string::npos,
             run.err.c_str());
  LONGS_EQUAL(1, std::distance(std::filesystem::directory_iterator(scratch.path("full")), {}));
}

// Swapped, or one turned by two degrees: no epoch has a pose, each says why, by every method.
TEST(CliSolve, CamerasThatAreNotAsTheirFilesSayGiveAnAlarmAndNoPose) {
  const std::string swapped = "--camera " + stereo + "/cam1.yaml --camera " + stereo + "/cam0.yaml";
  auto turned = relnav::hil::stereo_pose_scenario({1.0, 1, 1}).cameras[1];
  const relnav::Mat3 R_BC = turned.T_BC.topLeftCorner<3, 3>();
  turned.T_BC.topLeftCorner<3, 3>() = R_BC * relnav::hil::rotation_exp(relnav::Vec3(0.035, 0.0, 0.0));
  const std::string bad = scratch.write("turned.yaml", relnav::camera_file_text(turned));
  for (const std::string& cameras : {swapped, "--camera " + stereo + "/cam0.yaml --camera " + bad}) {
    for (const char* method : {"ml", "motor", "orthogonal"}) {
      const Run run = relnav_tool(scratch, stereo_files(cameras) + out + " --force --method " + method);
      LONGS_EQUAL_TEXT(1, run.exit_status, run.err.c_str());
      CHECK_TEXT(run.err == "relnav: no pose was estimated\n", run.err.c_str());
      const std::string poses = text_of(out + "/trajectory.tum");
      CHECK_TEXT(poses[0] == '#' && is_one_line(poses), poses.c_str());
      std::istringstream events(text_of(out + "/events.log"));
      std::size_t alarms = 0;
      for (std::string line; std::getline(events, line);) {
        if (line.find("update_refused status=inconsistent") != std::string::npos) ++alarms;
      }
      LONGS_EQUAL_TEXT(66, alarms, (cameras + " " + method).c_str());
      const Run decoded = relnav_tool(scratch, "tlm decode " + out + "/telemetry.bin");
      CHECK(decoded.out.find("valid_flags=pose") == std::string::npos);
    }
  }
}

TEST(CliSolve, NarrowArithmeticAgreesWithDouble) {
  const std::string as_double = scratch.path("double");
  const std::string as_float = scratch.path("float");
  const std::string as_fixed = scratch.path("fixed");
  const auto compare = [&](const std::string& command, const std::string& options, std::size_t epochs) {
    check_done(command + as_double + " --force" + options, as_double, epochs);
    check_done(command + as_float + " --force --scalar float" + options, as_float, epochs);
    check_done(command + as_fixed + " --force --scalar fixed" + options, as_fixed, epochs);
    const double of_float = largest_difference_sigma(as_double, as_float);
    const double of_fixed = largest_difference_sigma(as_double, as_fixed);
    std::printf("difference from double over sigma%s: float %.2e, fixed %.2e\n", options.c_str(), of_float, of_fixed);
    CHECK(of_float > 0.0);  // it was another arithmetic
    CHECK(of_float <= 1e-3);
    CHECK(of_fixed <= 1e-6);
  };
  compare(mono_files(), "", 40);
  compare(stereo_files(both_cameras()), " --method motor", 66);
}

// A target that turns slowly through 180 deg: without switching, fixed point has no numbers for it.
TEST(CliSolve, NoSwitching) {
  const std::string table1 = scratch.path("table1");
  LONGS_EQUAL(0, relnav_tool(scratch, "scenario table1 --count 600 --out " + table1).exit_status);
  const std::string files = "solve --mode coop-mono --camera " + table1 + "/cam0.yaml --target " + table1 +
                            "/target.yaml --observations " + table1 + "/observations.csv --out ";
  const auto poses = [&](const std::string& options) {
    static_cast<void>(relnav_tool(scratch, files + out + " --force " + options));
    return relnav::hil::read_trajectory(out + "/trajectory.tum").size();
  };
  LONGS_EQUAL(600, poses(""));
  LONGS_EQUAL(600, poses("--no-switching"));
  LONGS_EQUAL(600, poses("--scalar fixed"));
  LONGS_EQUAL(597, poses("--scalar fixed --no-switching"));  // within 0.6 deg of 180 deg
}

TEST(Cli, ReplayOfACooperativeTargetRefusesWhatIsNotMeantForIt) {
  const std::string set = make_dataset(scratch, 3);
  const std::string out = scratch.path("out");
  const std::string coop = "replay --mode coop-mono --out " + out + " --dataset " + set;
  check_unusable(coop, "set/target.yaml: cannot be opened");
  check_unusable(coop + " --target " + scratch.path("mine.yaml"), "mine.yaml: cannot be opened");
  check_unusable(coop + " --range 5", "--mode coop-mono: takes no --range");
  check_unusable(coop + " --motion camera", "takes no --range, --range-sigma or --motion");
  check_unusable("replay --mode noncoop --target t.yaml --out " + out + " --dataset " + set,
                 "--mode noncoop: takes no --target");
  scratch.write("set/target.yaml",
                "features: [{id: 0, xyz: [0, 0, 0]}, {id: 1, xyz: [1, 0, 0]}, {id: 2, xyz: [0, 1, 0]}, "
                "{id: 3, xyz: [0, 0, 1]}]\n");
  check_unusable("replay --mode coop-stereo --out " + out + " --dataset " + set, "cam1/sensor.yaml: cannot be opened");
  CHECK(!std::filesystem::exists(out));
}

TEST(Cli, ReplayNamesWhatTheFlightLoopWouldRefuse) {
  const std::string set = make_dataset(scratch, 3);
  const std::string out = scratch.path("out");
  const std::string config = scratch.write("c.yaml", "filter:\n  range_m: 3\nloop:\n  lost_after_frames: 0\n");
  check_unusable("replay --mode noncoop --range 5 --config " + config + " --out " + out + " --dataset " + set,
                 "c.yaml:4: loop.lost_after_frames is '0' (expected a whole number from 1 to 65535)");
  const auto target_of = [&](int markers) {
    std::string text = "features:\n";
    for (int i = 0; i < markers; ++i) {
      text +=
          "  - {id: " + std::to_string(i) + ", xyz: [" + std::to_string(i) + ", " + std::to_string(i * i) + ", 0]}\n";
    }
    return scratch.write("target.yaml", text);
  };
  for (const int markers : {3, 17}) {
    check_unusable("replay --mode coop-mono --target " + target_of(markers) + " --out " + out + " --dataset " + set,
                   "target.yaml: " + std::to_string(markers) + " features (expected 4 to 16");
  }
  CHECK(!std::filesystem::exists(out));
}
