// Full rate to the disk, kill in mid-capture, and the same telemetry from what was captured.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "hil/io/raw_container_reader.hpp"
#include "tests/hil/gige/served_camera.hpp"
#include "tests/support/scratch.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;
using relnav::test::Scratch;

namespace {

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// The relnav tool as a process; its output goes into a file.
class Tool {
 public:
  Tool(const std::string& output, std::vector<std::string> arguments) : output_(output) {
    arguments.insert(arguments.begin(), RELNAV_TOOL);
    id_ = ::fork();
    if (id_ != 0) return;
    const int file = ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ::dup2(file, STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  Tool(const Tool&) = delete;
  Tool& operator=(const Tool&) = delete;
  ~Tool() {
    kill_now();
    static_cast<void>(wait());
  }
  void send(int signal) const {
    if (id_ > 0) ::kill(id_, signal);
  }
  void kill_now() const { send(SIGKILL); }
  /// Exit status; -1: ended by a signal.
  int wait() {
    if (id_ <= 0) return -1;
    int status = 0;
    rusage usage{};
    ::wait4(id_, &status, 0, &usage);
    id_ = 0;
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] std::string output() const { return content_of(output_); }
  double cpu_s = 0.0;

 private:
  std::string output_;
  pid_t id_ = 0;
};

/// The number before `words` in a text; -1: there is none.
long number_before(const std::string& text, const std::string& words) {
  const std::size_t end = text.find(words);
  if (end == std::string::npos) return -1;
  std::size_t begin = end;
  while (begin > 0 && text[begin - 1] >= '0' && text[begin - 1] <= '9') --begin;
  return begin < end ? std::stol(text.substr(begin, end - begin)) : -1;
}

std::vector<std::string> capture_of(std::uint32_t width_px, std::uint32_t height_px, const std::string& out,
                                    const std::string& frames) {
  std::vector<std::string> arguments{"capture",
                                     "--camera",
                                     std::string("aravis:") + served_address,
                                     "--width",
                                     std::to_string(width_px),
                                     "--height",
                                     std::to_string(height_px),
                                     "--format",
                                     "grey8",
                                     "--stamps",
                                     "original",
                                     "--packet-bytes",
                                     "16404",
                                     "--buffer-mb",
                                     "512",
                                     "--socket-buffer-bytes",
                                     "16777216",
                                     "--out",
                                     out};
  if (!frames.empty()) arguments.insert(arguments.end(), {"--frames", frames});
  return arguments;
}

/// Waits for a file of at least so many bytes.
bool grows_to(const std::string& path, std::uintmax_t bytes) {
  std::error_code error;
  for (int i = 0; i < 600; ++i) {
    if (std::filesystem::exists(path) && std::filesystem::file_size(path, error) >= bytes) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

}  // namespace

TEST_GROUP(GigeCapture) {
  Scratch scratch;
  std::string file = scratch.path("c.rnc");
  void setup() override { enter_own_network(); }

  /// Each frame in the file is the one that was served with its stamp; numbers and stamps increase together.
  std::size_t check_frames(CountedFrames & source) {
    const hil::RawContainerReader reader(file);
    std::int64_t former = -1;
    for (std::size_t k = 0; k < reader.frames().size(); ++k) {
      const std::int64_t index = source.index_of(Time{reader.frames()[k].header.mid_exposure_ns});
      CHECK_TRUE(index > former);
      CHECK_TRUE(k == 0 || reader.frames()[k].header.sequence > reader.frames()[k - 1].header.sequence);
      CHECK_TRUE(reader.image(k).bytes == source.image(static_cast<std::size_t>(index))->bytes);
      former = index;
    }
    return reader.frames().size();
  }

  /// A busy machine may lose packets on their way: these frames are accounted for. The disk must lose none.
  void check_rate(std::uint32_t width_px, std::uint32_t height_px, double rate_hz, long count) {
    CountedFrames source(width_px, height_px, 1'000'000, rate_hz);
    ServedCamera camera(source, {});
    Tool tool(scratch.path("log"), capture_of(width_px, height_px, file, std::to_string(count)));
    const int status = tool.wait();
    const std::string text = tool.output();
    std::printf("%u x %u at %.0f Hz\n%sCPU time %.2f s\n", width_px, height_px, rate_hz, text.c_str(), tool.cpu_s);
    CHECK_EQUAL_TEXT(0, status, text.c_str());
    CHECK_EQUAL(count, number_before(text, " frames in "));
    CHECK_EQUAL(count, number_before(text, " received"));
    CHECK_EQUAL(0, number_before(text, " without room"));
    CHECK_EQUAL(count, static_cast<long>(check_frames(source)));
    const hil::RawContainerReader reader(file);
    CHECK_FALSE(reader.is_cut());
    if (number_before(text, " camera losses") > 0) return;  // starved for a second: where it began again nobody knows
    // What was sent = received + lost by the network.
    const auto index_at = [&](const hil::RawContainerReader::Place& place) {
      return static_cast<long>(source.index_of(Time{place.header.mid_exposure_ns}));
    };
    const long sent = index_at(reader.frames().back()) + 1;
    const long lost = number_before(text, " lost by sequence") + number_before(text, " incomplete");
    CHECK_EQUAL(sent, count + lost);
  }
};

TEST(GigeCapture, SmallFramesAt200Hz) { check_rate(640, 480, 200.0, 2000); }

TEST(GigeCapture, LargeFramesAt30Hz) { check_rate(2048, 2048, 30.0, 240); }

TEST(GigeCapture, KilledInMidCaptureTheFileHasAllFramesButOne) {
  constexpr std::uintmax_t frame_bytes = sizeof(hal::raw::FrameHeader) + 640 * 480;
  CountedFrames source(640, 480, 1'000'000, 100.0);
  ServedCamera camera(source, {});
  Tool tool(scratch.path("log"), capture_of(640, 480, file, ""));
  CHECK_TRUE(grows_to(file, 100 * frame_bytes));
  tool.kill_now();
  CHECK_EQUAL(-1, tool.wait());
  const std::uintmax_t bytes = std::filesystem::file_size(file);
  const hil::RawContainerReader reader(file);
  CHECK_TRUE(reader.is_cut());
  CHECK_EQUAL((bytes - sizeof(hal::raw::FileHeader)) / frame_bytes, reader.frames().size());
  CHECK_TRUE(check_frames(source) >= 99);
  // In the file is what the camera gave without a gap: nothing was lost before the end.
  std::printf("killed: %zu whole frames, the last one has number %u\n", reader.frames().size(),
              reader.frames().back().header.sequence);
}

TEST(GigeCapture, ControlCEndsItCleanly) {
  CountedFrames source(640, 480, 1'000'000, 100.0);
  ServedCamera camera(source, {});
  Tool tool(scratch.path("log"), capture_of(640, 480, file, ""));
  CHECK_TRUE(grows_to(file, 20 * 640 * 480));
  tool.send(SIGINT);
  CHECK_EQUAL(0, tool.wait());
  const hil::RawContainerReader reader(file);
  CHECK_FALSE(reader.is_cut());
  CHECK_EQUAL(static_cast<long>(reader.frames().size()), number_before(tool.output(), " frames in "));
}

TEST(GigeCapture, AFullDiskKeepsTheFramesBefore) {
  // Whoever writes beyond the limit is told so, as by a full disk.
  CountedFrames source(640, 480, 1'000'000, 100.0);
  ServedCamera camera(source, {});
  rlimit former{};
  ::getrlimit(RLIMIT_FSIZE, &former);
  rlimit limit = former;
  limit.rlim_cur = 5'000'000;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  Tool tool(scratch.path("log"), capture_of(640, 480, file, "100"));
  ::setrlimit(RLIMIT_FSIZE, &former);
  CHECK_EQUAL(1, tool.wait());
  const std::string text = tool.output();
  CHECK_TRUE(text.find("c.rnc: cannot be written: File too large") != std::string::npos);
  CHECK_TRUE(text.find("the 16 frames before are kept") != std::string::npos);
  CHECK_EQUAL(16, check_frames(source));
}

TEST(GigeCapture, WhatWasCapturedReplaysToTheSameBytes) {
  const std::string captures = std::string(RELNAV_SOURCE_DIR) + "/hil/captures/lights_mono";
  hil::CapturedSource source(lights_mono);
  {
    ServedCamera camera(source, {});
    std::vector<std::string> arguments =
        capture_of(source.shape().width_px, source.shape().height_px, file, std::to_string(source.count()));
    arguments.insert(arguments.end(), {"--calibration", captures + "/mav0/cam0/sensor.yaml"});
    Tool tool(scratch.path("log"), arguments);
    CHECK_EQUAL_TEXT(0, tool.wait(), tool.output().c_str());
  }
  const auto replay = [&](const std::string& dataset, const std::string& out) {
    Tool tool(scratch.path("log"), {"replay", "--dataset", dataset, "--mode", "coop-mono", "--target",
                                    captures + "/target.yaml", "--out", scratch.path(out)});
    CHECK_EQUAL_TEXT(0, tool.wait(), tool.output().c_str());
    return content_of(scratch.path(out + "/telemetry.bin"));
  };
  const std::string from_images = replay(captures, "a");
  CHECK_TRUE(from_images.size() > 1000);
  CHECK_TRUE(from_images == replay(file, "b"));
}
