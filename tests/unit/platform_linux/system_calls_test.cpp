// SystemCalls on what every host has: negative results are -errno, waits end in time.
#include "platform/linux/system_calls.hpp"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

#include "platform/host/steady_clock.hpp"
#include "platform/linux/v4l2_driver.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::platform::linux;

TEST_GROUP(SystemCalls) { SystemCalls calls; };

TEST(SystemCalls, ErrorsAreNegative) {
  LONGS_EQUAL(-ENOENT, calls.open("/dev/there-is-no-such-device", O_RDWR));
  const int null = calls.open("/dev/null", O_RDWR | O_CLOEXEC);
  CHECK_TRUE(null >= 0);
  v4l2_capability about{};
  const int answer = calls.ioctl(null, VIDIOC_QUERYCAP, &about);
  CHECK_TRUE(answer == -ENOTTY || answer == -ENOSYS);  // the latter from an emulator
  int error = 0;
  POINTERS_EQUAL(nullptr, calls.map(4096, null, 0, error));
  LONGS_EQUAL(-ENODEV, error);
  LONGS_EQUAL(0, calls.close(null));
  LONGS_EQUAL(-EBADF, calls.close(null));
}

TEST(SystemCalls, PollWaitsForDataOrTheEnd) {
  int ends[2] = {-1, -1};
  LONGS_EQUAL(0, pipe(ends));
  platform::host::SteadyClock clock;
  pollfd file{.fd = ends[0], .events = POLLIN, .revents = 0};
  const Time before = clock.now();
  LONGS_EQUAL(0, calls.poll(file, Duration{3'000'000}));
  CHECK_TRUE((clock.now() - before).ns >= 3'000'000);
  LONGS_EQUAL(1, write(ends[1], "x", 1));
  LONGS_EQUAL(1, calls.poll(file, Duration{60'000'000'000}));
  LONGS_EQUAL(POLLIN, file.revents);
  LONGS_EQUAL(0, calls.close(ends[0]));
  LONGS_EQUAL(0, calls.close(ends[1]));
}

TEST(SystemCalls, MappedIsWhatTheFileHolds) {
  std::FILE* const file = std::tmpfile();
  std::string text(5000, 'a');
  text.replace(4096, std::string::npos, 5000 - 4096, 'b');
  LONGS_EQUAL(text.size(), std::fwrite(text.data(), 1, text.size(), file));
  LONGS_EQUAL(0, std::fflush(file));
  int error = 0;
  void* const address = calls.map(text.size() - 4096, fileno(file), 4096, error);
  CHECK_TRUE(address != nullptr);
  LONGS_EQUAL(0, std::memcmp(address, text.data() + 4096, text.size() - 4096));
  LONGS_EQUAL(0, calls.unmap(address, text.size() - 4096));
  LONGS_EQUAL(0, std::fclose(file));
}

TEST(SystemCalls, TheDriverExplainsWhatIsNoCamera) {
  platform::host::SteadyClock clock;
  V4l2Driver driver(calls, clock);
  CameraSettings settings;
  settings.width_px = settings.height_px = 8;
  settings.device = "/dev/null";
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  STRCMP_EQUAL("/dev/null: not a V4L2 device", driver.problem().c_str());
  settings.device = "/dev/there-is-no-such-device";
  CHECK_TRUE(driver.open(settings) == Status::no_data);
  settings.device = "/tmp";
  CHECK_TRUE(driver.open(settings) == Status::unsupported);
  STRCMP_EQUAL("/tmp: Is a directory", driver.problem().c_str());
}
