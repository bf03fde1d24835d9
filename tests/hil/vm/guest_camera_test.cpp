// In the guest: the V4L2 driver on vivid (/dev/video10) and on v4l2loopback (/dev/video0), which V4l2Sink feeds.
#include <CppUTest/TestHarness.h>
#include <linux/videodev2.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "hil/serve/v4l2_sink.hpp"
#include "platform/files/input_error.hpp"
#include "platform/linux/gpiod_lines.hpp"
#include "platform/linux/monotonic_clock.hpp"
#include "platform/linux/pixel_conversion.hpp"
#include "platform/linux/stream_camera.hpp"
#include "platform/linux/strobed_camera.hpp"
#include "platform/linux/v4l2_driver.hpp"
#include "tests/hil/vm/guest_resources.hpp"
#include "tests/hil/vm/simulated_lines.hpp"
#include "tests/hil/vm/vivid.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::hil::FrameShape;
using relnav::hil::Image;
using relnav::hil::ServedFrame;
using relnav::hil::V4l2Sink;
using relnav::platform::linux::CameraSettings;
using relnav::platform::linux::RawFormat;
using relnav::platform::linux::RawImage;
using relnav::platform::linux::StreamCamera;
using relnav::platform::linux::StreamOptions;
using relnav::test::Resources;
using relnav::test::resources;
using relnav::test::set_vivid;

constexpr const char* vivid = "/dev/video10";
constexpr const char* loopback = "/dev/video0";
constexpr Duration long_wait{5'000'000'000};
constexpr Duration no_wait{0};

using Bytes = std::vector<std::uint8_t>;

CameraSettings settings_of(const char* device, std::uint32_t width_px, std::uint32_t height_px, const char* format) {
  CameraSettings settings;
  settings.device = device;
  settings.width_px = width_px;
  settings.height_px = height_px;
  settings.format = format;
  if (device == vivid) settings.rate_hz = 25.0;
  return settings;
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// A picture that no other frame has, at no place.
Image numbered_image(const FrameShape& shape, std::uint32_t number) {
  Image image{shape.width_px, shape.height_px, shape.bytes_per_pixel, {}};
  image.bytes.resize(std::size_t{shape.width_px} * shape.height_px * shape.bytes_per_pixel);
  std::uint32_t state = number * 2654435761U + 1U;
  for (std::uint8_t& byte : image.bytes) {
    state = state * 1664525U + 1013904223U;
    byte = static_cast<std::uint8_t>(state >> 24U);
  }
  return image;
}

/// Stamps as a capture's, whole microseconds.
Time stamp_of(std::uint32_t number) { return {100'000'000'000 + std::int64_t{number} * 100'123'000}; }

}  // namespace

TEST_GROUP(GuestCamera) {
  relnav::platform::linux::SystemCalls calls;
  relnav::platform::linux::MonotonicClock clock;
  relnav::platform::linux::V4l2Driver driver{calls, clock};

  void open(const CameraSettings& settings) {
    const Status status = driver.open(settings);
    if (status != Status::ok) std::printf("%s\n", driver.problem().c_str());
    CHECK_TRUE(status == Status::ok);
  }
  RawImage take() {
    RawImage image;
    const Status status = driver.take(long_wait, image);
    if (status != Status::ok) std::printf("%s\n", driver.problem().c_str());
    CHECK_TRUE(status == Status::ok);
    return image;
  }
  /// open() fails, with this in its message.
  void check_refused(const CameraSettings& settings, Status expected, const char* part) {
    const Status status = driver.open(settings);
    if (status != expected || !contains(driver.problem(), part))
      std::printf("status %d, problem: %s\n", static_cast<int>(status), driver.problem().c_str());
    CHECK_TRUE(status == expected);
    CHECK_TRUE(contains(driver.problem(), part));
    CHECK_TRUE(contains(driver.problem(), settings.device.c_str()));
  }
};

// ---- vivid: every pixel format, against what v4l2-ctl captured before.

namespace {

Bytes captured_by_v4l2_ctl(const char* fourcc) {
  std::ifstream file(std::string("/tmp/") + fourcc + ".raw", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Luma of the bilinear demosaic, by the colour of each place: its own value, else the mean of that colour's in the 3 x 3 around.
Bytes luma_of_bayer(const Bytes& raw, int width, int height, const char* pattern) {
  const auto mirrored = [](int i, int size) { return i < 0 ? -i : (i >= size ? 2 * size - 2 - i : i); };
  const auto colour = [&](int x, int y) { return pattern[2 * (y & 1) + (x & 1)]; };
  Bytes luma(raw.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (const auto& [name, weight] : {std::pair{'r', 77.0}, {'g', 150.0}, {'b', 29.0}}) {
        double total = 0.0;
        int count = 0;
        const bool own = colour(x, y) == name;
        for (int dy = own ? 0 : -1; dy <= (own ? 0 : 1); ++dy) {
          for (int dx = own ? 0 : -1; dx <= (own ? 0 : 1); ++dx) {
            const int u = mirrored(x + dx, width);
            const int v = mirrored(y + dy, height);
            if (colour(u, v) != name) continue;
            total += raw[static_cast<std::size_t>(v * width + u)];
            ++count;
          }
        }
        sum += weight * total / count;
      }
      luma[static_cast<std::size_t>(y * width + x)] = static_cast<std::uint8_t>(sum / 256.0 + 0.5);
    }
  }
  return luma;
}

Bytes luma_of_yuyv(const Bytes& raw) {
  Bytes luma;
  for (std::size_t i = 0; i < raw.size(); i += 2) luma.push_back(raw[i]);
  return luma;
}

struct FormatCase {
  const char* name;
  const char* fourcc;
  int bytes_per_pixel;
};

}  // namespace

TEST(GuestCamera, EveryFormatIsCapturedAndConvertedAsV4l2CtlSeesIt) {
  constexpr int width = 640;
  constexpr int height = 360;
  const FormatCase cases[] = {{"grey8", "GREY", 1},       {"y10", "Y10 ", 2},         {"y12", "Y12 ", 2},
                              {"y16", "Y16 ", 2},         {"yuyv", "YUYV", 2},        {"bayer_rggb8", "RGGB", 1},
                              {"bayer_grbg8", "GRBG", 1}, {"bayer_gbrg8", "GBRG", 1}, {"bayer_bggr8", "BA81", 1}};
  for (const FormatCase& c : cases) {
    const Bytes theirs = captured_by_v4l2_ctl(c.fourcc);
    LONGS_EQUAL(width * height * c.bytes_per_pixel, theirs.size());
    open(settings_of(vivid, width, height, c.name));
    const RawImage image = take();
    STRCMP_EQUAL(c.name, name_of(image.format));
    CHECK_TRUE(image.complete);
    LONGS_EQUAL(width, image.width_px);
    LONGS_EQUAL(height, image.height_px);
    LONGS_EQUAL(width * c.bytes_per_pixel, image.stride_bytes);
    CHECK_TRUE(image.bytes.size() >= theirs.size());
    const Bytes ours(image.bytes.begin(), image.bytes.begin() + static_cast<std::ptrdiff_t>(theirs.size()));
    if (ours != theirs) std::printf("%s differs\n", c.name);
    CHECK_TRUE(ours == theirs);

    Bytes mono(relnav::platform::linux::row_bytes(mono_format(image.format), width) * height);
    CHECK_TRUE(convert(image, mono) == Status::ok);
    const Bytes expected = c.name[0] == 'b'                  ? luma_of_bayer(theirs, width, height, c.name + 6)
                           : image.format == RawFormat::yuyv ? luma_of_yuyv(theirs)
                                                             : theirs;
    if (mono != expected) std::printf("%s is converted wrong\n", c.name);
    CHECK_TRUE(mono == expected);
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    driver.close();
  }
}

TEST(GuestCamera, VividsPictureIsNoEvenSurface) {  // else the test above would not see exchanged pixels
  const Bytes grey = captured_by_v4l2_ctl("GREY");
  int levels[256] = {};
  for (const std::uint8_t level : grey) ++levels[level];
  int used = 0;
  for (const int count : levels) used += count > 500 ? 1 : 0;
  CHECK_TRUE(used >= 6);
}

TEST(GuestCamera, WithoutAFormatTheDeepestIsTaken) {
  open(settings_of(vivid, 640, 360, ""));
  CHECK_TRUE(take().format == RawFormat::y16);
}

TEST(GuestCamera, VividsFramesAreCountedAndStampedByTheMonotonicClock) {
  const Time before = clock.now();
  open(settings_of(vivid, 320, 180, "grey8"));
  Time last = before;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const RawImage image = take();
    CHECK_TRUE(image.clock == relnav::hal::ClockId::monotonic);
    CHECK_TRUE(image.stamp > last);
    CHECK_TRUE(image.stamp <= clock.now() + Duration{100'000'000});  // vivid stamps the planned end of a frame
    CHECK_TRUE(image.has_sequence);
    CHECK_TRUE(image.sequence >= i);  // the emulated machine may lose some, and counts them
    last = image.stamp;
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  }
}

TEST(GuestCamera, DamagedFramesAreMarked) {
  open(settings_of(vivid, 320, 180, "grey8"));
  CHECK_TRUE(set_vivid(vivid, "Inject V4L2_BUF_FLAG_ERROR", 1));
  bool damaged = false;
  for (int i = 0; i < 20 && !damaged; ++i) {
    const RawImage image = take();
    damaged = !image.complete;
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  }
  CHECK_TRUE(damaged);
  CHECK_TRUE(take().complete);
}

// ---- What is refused.

TEST(GuestCamera, WhatIsNoCameraIsRefused) {
  check_refused(settings_of("/dev/video77", 640, 360, ""), Status::no_data, "does not exist");
  check_refused(settings_of("/dev/null", 640, 360, ""), Status::unsupported, "not a V4L2 device");
  check_refused(settings_of("/tmp", 640, 360, ""), Status::unsupported, "/tmp");
}

TEST(GuestCamera, AnImpossibleSizeOrFormatIsRefused) {
  check_refused(settings_of(vivid, 641, 361, "grey8"), Status::unsupported, "641 x 361");
  check_refused(settings_of(vivid, 640, 360, "y10p"), Status::unsupported, "y10p");
  check_refused(settings_of(vivid, 640, 360, "grey7"), Status::invalid_argument, "grey7");
  // The device is as good as before.
  open(settings_of(vivid, 640, 360, "grey8"));
  (void)take();
}

TEST(GuestCamera, ABusyCameraIsRefused) {
  relnav::platform::linux::V4l2Driver other(calls, clock);
  CHECK_TRUE(other.open(settings_of(vivid, 640, 360, "grey8")) == Status::ok);
  check_refused(settings_of(vivid, 640, 360, "grey8"), Status::no_capacity, "busy");
  RawImage image;
  CHECK_TRUE(other.take(long_wait, image) == Status::ok);
}

TEST(GuestCamera, ALoopbackWithoutAWriterIsNoCameraYet) {
  const Resources before = resources();
  const Status status = driver.open(settings_of(loopback, 640, 480, "grey8"));
  CHECK_TRUE(status == Status::unsupported || status == Status::no_capacity || status == Status::no_data);
  CHECK_TRUE(contains(driver.problem(), loopback));
  LONGS_EQUAL(before.files, resources().files);
}

// ---- Loss.

TEST(GuestCamera, AHundredDisconnectionsLeakNothing) {
  const CameraSettings settings = settings_of(vivid, 640, 360, "grey8");
  Resources before;
  for (int i = 0; i < 110; ++i) {
    if (i == 10) before = resources();  // what is allocated once is
    open(settings);
    RawImage image = take();
    if (i % 2 == 0) CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    CHECK_TRUE(set_vivid(vivid, "Disconnect", 1));
    Status status = Status::ok;
    for (int tries = 0; tries < 20 && status == Status::ok; ++tries) status = driver.take(long_wait, image);
    CHECK_TRUE(status == Status::device_lost);
    driver.close();
  }
  const Resources after = resources();
  LONGS_EQUAL(before.files, after.files);
  LONGS_EQUAL(before.mappings, after.mappings);
  CHECK_TRUE(after.heap_bytes <= before.heap_bytes + 1024);  // texts of problems differ in length
}

TEST(GuestCamera, TheStreamComesBackByItself) {
  StreamCamera camera(driver, clock, settings_of(vivid, 640, 360, "grey8"));
  CHECK_TRUE(camera.start() == Status::ok);
  relnav::hal::Frame frame;
  CHECK_TRUE(camera.acquire(long_wait, frame) == Status::ok);
  const std::uint32_t last = frame.sequence;
  CHECK_TRUE(camera.release(frame) == Status::ok);
  CHECK_TRUE(set_vivid(vivid, "Disconnect", 1));
  Status status = Status::ok;
  while ((status = camera.acquire(long_wait, frame)) == Status::ok) CHECK_TRUE(camera.release(frame) == Status::ok);
  CHECK_TRUE(status == Status::device_lost);
  const Time lost = clock.now();
  while (camera.start() != Status::ok)
    std::this_thread::sleep_for(std::chrono::nanoseconds(camera.until_next_attempt().ns));
  CHECK_TRUE(camera.acquire(long_wait, frame) == Status::ok);
  std::printf("back after %.0f ms ", static_cast<double>((clock.now() - lost).ns) * 1e-6);
  CHECK_TRUE((clock.now() - lost).ns < 2'000'000'000);
  CHECK_TRUE(frame.sequence > last);
  CHECK_TRUE(camera.release(frame) == Status::ok);
  LONGS_EQUAL(1, camera.counts().reconnects);
}

// ---- v4l2loopback: what a replayed capture goes through.

TEST(GuestCamera, FramesPassTheLoopbackByteForByteWithTheirStamps) {
  const FrameShape shapes[] = {{640, 480, 1}, {320, 240, 2}, {1280, 960, 1}};
  for (const FrameShape& shape : shapes) {
    V4l2Sink sink(loopback, "");
    sink.plug(shape);
    open(settings_of(loopback, shape.width_px, shape.height_px, shape.bytes_per_pixel == 2 ? "y16" : "grey8"));
    for (std::uint32_t number = 1; number <= 60; ++number) {
      const Image sent = numbered_image(shape, number);
      ServedFrame frame;
      frame.image = &sent;
      frame.stamp = stamp_of(number);
      frame.number = number;
      CHECK_TRUE(sink.write(frame, no_wait));
      const RawImage got = take();
      CHECK_TRUE(got.complete);
      CHECK_TRUE(got.bytes.size() >= sent.bytes.size());
      CHECK_TRUE(std::equal(sent.bytes.begin(), sent.bytes.end(), got.bytes.begin()));
      CHECK_TRUE(got.stamp == stamp_of(number));
      CHECK_TRUE(driver.give_back(got.buffer) == Status::ok);
    }
    driver.close();
  }
}

TEST(GuestCamera, AHundredTimesUnpluggedLeakNothing) {
  const FrameShape shape{320, 240, 1};
  const Image sent = numbered_image(shape, 1);
  ServedFrame frame;
  frame.image = &sent;
  frame.stamp = stamp_of(1);
  Resources before;
  for (int i = 0; i < 110; ++i) {
    if (i == 10) before = resources();
    if (i % 10 == 9)  // the device itself goes and comes
      LONGS_EQUAL(0,
                  std::system("rmmod v4l2loopback && modprobe v4l2loopback video_nr=0 exclusive_caps=1 max_buffers=8"));
    V4l2Sink sink(loopback, "");
    sink.plug(shape);
    open(settings_of(loopback, shape.width_px, shape.height_px, "grey8"));
    CHECK_TRUE(sink.write(frame, no_wait));
    const RawImage got = take();
    CHECK_TRUE(std::equal(sent.bytes.begin(), sent.bytes.end(), got.bytes.begin()));
    CHECK_TRUE(driver.give_back(got.buffer) == Status::ok);
    sink.unplug();
    RawImage image;
    CHECK_TRUE(driver.take(no_wait, image) != Status::ok);
    driver.close();
  }
  const Resources after = resources();
  LONGS_EQUAL(before.files, after.files);
  LONGS_EQUAL(before.mappings, after.mappings);
  CHECK_TRUE(after.heap_bytes <= before.heap_bytes + 1024);  // texts of problems differ in length
}

TEST(GuestCamera, ASinkRefusesWhatIsNoLoopback) {
  const FrameShape shape{320, 240, 1};
  for (const char* device : {"/dev/video77", "/dev/null", vivid}) {
    V4l2Sink sink(device, "");
    std::string problem;
    try {
      sink.plug(shape);
    } catch (const relnav::InputError& error) {
      problem = error.what();
    }
    CHECK_TRUE(contains(problem, device));
    CHECK_TRUE(contains(problem, "v4l2loopback"));
  }
}

TEST(GuestCamera, TheStrobeTriggersEachFrameInLockStep) {
  constexpr std::uint32_t frames = 100;
  const FrameShape shape{320, 240, 1};
  const auto backend = relnav::platform::linux::make_gpiod_backend();
  relnav::platform::linux::GpiodLines lines(*backend);
  CHECK_TRUE(lines.open(relnav::test::SimulatedLines::label) == Status::ok);
  CHECK_TRUE(lines.request_output(0, false) == Status::ok);

  const char* rises = std::getenv("RISES");
  CHECK_TRUE(rises != nullptr);
  V4l2Sink sink(loopback, rises);
  sink.plug(shape);
  std::atomic<bool> stop = false;
  std::uint32_t written = 0;
  std::thread player([&] {
    for (std::uint32_t number = 1; number <= frames && !stop; ++number) {
      const Image image = numbered_image(shape, number);
      ServedFrame frame;
      frame.image = &image;
      frame.stamp = stamp_of(number);
      frame.number = number;
      while (!stop && !sink.write(frame, Duration{100'000'000})) {
      }
      ++written;
    }
  });

  CameraSettings settings = settings_of(loopback, shape.width_px, shape.height_px, "grey8");
  settings.trigger = relnav::platform::linux::Trigger::line;
  settings.original_stamps = true;
  settings.stamp_meaning = relnav::platform::linux::StampMeaning::mid_exposure;
  StreamOptions options;
  options.always_copy = true;
  StreamCamera camera(driver, clock, settings, options);
  relnav::platform::linux::StrobedCamera strobed(camera, lines, 0);
  const Status started = strobed.start();
  std::uint32_t right = 0;
  for (std::uint32_t number = 1; started == Status::ok && number <= frames; ++number) {
    relnav::hal::Frame frame;
    const Status acquired = strobed.acquire(long_wait, frame);
    if (acquired != Status::ok) {
      std::printf("frame %u: status %d\n", number, static_cast<int>(acquired));
      break;
    }
    const Image sent = numbered_image(shape, number);
    if (frame.mid_exposure == stamp_of(number) && std::equal(sent.bytes.begin(), sent.bytes.end(), frame.pixels))
      ++right;
    if (strobed.release(frame) != Status::ok) break;
  }
  stop = true;
  player.join();
  if (!camera.problem().empty()) std::printf("%s\n", camera.problem().c_str());
  LONGS_EQUAL(frames, right);
  LONGS_EQUAL(frames, written);
  LONGS_EQUAL(0, strobed.line_failures());
  LONGS_EQUAL(0, camera.counts().skipped);
}
