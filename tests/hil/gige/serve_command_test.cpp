// `relnav serve --gige` as a process.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "platform/linux/aravis_driver.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;
using platform::linux::AravisDriver;
using platform::linux::RawImage;

namespace {

/// A process whose output and errors are read when it has ended.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) return;
    output_ = ends[0];
    id_ = ::fork();
    if (id_ == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::dup2(ends[1], STDERR_FILENO);
      std::vector<char*> argv;
      for (std::string& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(ends[1]);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (id_ > 0) ::kill(id_, SIGKILL);
    static_cast<void>(wait());
    ::close(output_);
  }
  void terminate() const { ::kill(id_, SIGTERM); }
  /// Exit status; -1 where it did not exit by itself within 20 s.
  int wait() {
    if (id_ <= 0) return -1;
    int status = 0;
    pid_t ended = 0;
    for (int i = 0; i < 400 && ended == 0; ++i) {
      ended = ::waitpid(id_, &status, WNOHANG);
      if (ended == 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    if (ended == 0) {
      ::kill(id_, SIGKILL);
      ::waitpid(id_, &status, 0);
    }
    id_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string output() const {
    std::string text;
    std::array<char, 4096> part{};
    ssize_t size = 0;
    while ((size = ::read(output_, part.data(), part.size())) > 0)
      text.append(part.data(), static_cast<std::size_t>(size));
    return text;
  }

 private:
  pid_t id_ = 0;
  int output_ = -1;
};

std::vector<std::string> serve(std::vector<std::string> more) {
  std::vector<std::string> arguments{RELNAV_TOOL, "serve", "--dataset", RELNAV_SOURCE_DIR "/hil/captures/lights_mono"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

void check_refused(const std::vector<std::string>& more, const char* part) {
  Process process(serve(more));
  CHECK_EQUAL(2, process.wait());
  const std::string text = process.output();
  if (text.find(part) == std::string::npos) FAIL(text.c_str());
  if (std::count(text.begin(), text.end(), '\n') != 1) FAIL(text.c_str());
}

}  // namespace

TEST_GROUP(ServeCommand){void setup() override{enter_own_network();
}
}
;

TEST(ServeCommand, ServesInLockStepWithFaultsUntilTold) {
  hil::CapturedSource source(lights_mono);
  Process process(
      serve({"--gige", "127.0.0.1,RN07", "--rate", "lockstep", "--loop", "--fault", "lost@2", "--fault", "white@4"}));
  AravisDriver driver;
  platform::linux::CameraSettings settings = settings_for(source.shape().width_px, source.shape().height_px);
  settings.serial = "RN07";
  settings.trigger = platform::linux::Trigger::software;
  CHECK_TRUE(open_soon(driver, settings) == Status::ok);
  for (std::size_t k = 0; k < 7; ++k) {
    CHECK_TRUE(driver.trigger() == Status::ok);
    RawImage image;
    const Status status = driver.take(Duration{k == 2 ? 200'000'000 : 2'000'000'000}, image);
    if (k == 2) {
      CHECK_TRUE(status == Status::timeout);
      continue;
    }
    CHECK_TRUE(status == Status::ok);
    CHECK_EQUAL(k, image.sequence);
    CHECK_TRUE(image.stamp == source.stamp(k));
    const std::vector<std::uint8_t> expected =
        k == 4 ? std::vector<std::uint8_t>(image.bytes.size(), 255) : source.image(k)->bytes;
    CHECK_TRUE(std::equal(image.bytes.begin(), image.bytes.end(), expected.begin(), expected.end()));
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  }
  driver.close();
  process.terminate();
  CHECK_EQUAL(0, process.wait());
  const std::string text = process.output();
  if (text.find("6 frames sent, 1 lost by faults, 0 not taken in time") == std::string::npos) FAIL(text.c_str());
}

TEST(ServeCommand, UnusableArgumentsAreOneLine) {
  check_refused({}, "is told no place for the camera");
  check_refused({"--gige", "nowhere"}, "is no place for a camera");
  check_refused({"--gige", "127.0.0.1,"}, "is no place for a camera");
  check_refused({"--gige", "192.0.2.1"}, "cannot be listened on");
  check_refused({"--gige", "127.0.0.1", "--rate", "fast"}, "is no rate");
  check_refused({"--gige", "127.0.0.1", "--fault", "burnt@1"}, "is of no known kind");
  check_refused({"--gige", "127.0.0.1", "--camera", "7"}, "mav0/cam7");
}

TEST(ServeCommand, AnAddressInUseIsSaid) {
  CountedFrames source(640, 480, 100000, 10.0);
  ServedCamera camera(source, {});
  AravisDriver driver;
  CHECK_TRUE(open_soon(driver, settings_for(640, 480)) == Status::ok);
  check_refused({"--gige", "127.0.0.1"}, "cannot be listened on");
  driver.close();
}
