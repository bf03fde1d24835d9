/// The relnav tool as a user meets it: exit status, one line on stderr, files.
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "hil/io/image.hpp"
#include "hil/io/trajectory.hpp"
#include "tests/unit/hil/scratch.hpp"

using relnav::test::Scratch;

namespace {

struct Run {
  int exit_status = -1;
  std::string out;
  std::string err;
};

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

Run relnav_tool(const Scratch& scratch, const std::string& arguments) {
  const std::string command = std::string("'") + RELNAV_TOOL + "' " + arguments + " >" + scratch.path("stdout") +
                              " 2>" + scratch.path("stderr") + " </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, text_of(scratch.path("stdout")),
          text_of(scratch.path("stderr"))};
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
  for (const char* level : {"", "replay ", "evaluate ", "tlm ", "tlm decode "}) {
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
  check_unusable("replay --dataset x --mode noncoop --out y --tlm http://h:1", "expected udp://HOST:PORT");
  check_unusable("replay --dataset x --mode coop-mono --out y", "not in this build yet");
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
