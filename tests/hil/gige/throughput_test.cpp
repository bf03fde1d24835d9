#include <algorithm>
#include <cstring>

#include "platform/linux/aravis_driver.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;
using platform::linux::AravisDriver;
using platform::linux::CameraSettings;
using platform::linux::RawImage;

namespace {

struct Received {
  std::uint32_t good = 0;
  std::uint32_t damaged = 0;
  std::uint32_t missing = 0;
  std::uint32_t wrong = 0;  ///< bytes differ, or a stamp that is none of theirs
  double rate_hz = 0.0;
};

/// Takes frames as they come until `count` of them have been sent, lost ones included.
Received receive(AravisDriver& driver, CountedFrames& source, std::uint32_t count) {
  Received received;
  std::uint32_t next = 0;
  const auto start = std::chrono::steady_clock::now();
  while (next < count) {
    RawImage image;
    if (driver.take(Duration{2'000'000'000}, image) != Status::ok) break;
    received.missing += image.sequence - next;
    next = image.sequence + 1;
    if (!image.complete) {
      ++received.damaged;
    } else {
      const hil::Image& expected = *source.image(image.sequence);
      const bool same = image.bytes.size() == expected.bytes.size() &&
                        std::memcmp(image.bytes.data(), expected.bytes.data(), expected.bytes.size()) == 0 &&
                        source.index_of(image.stamp) == image.sequence;
      ++(same ? received.good : received.wrong);
    }
    if (driver.give_back(image.buffer) != Status::ok) break;
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  received.rate_hz = next / took.count();
  return received;
}

void check_rate(std::uint32_t width_px, std::uint32_t height_px, double rate_hz, std::uint32_t count) {
  CountedFrames source(width_px, height_px, 1'000'000, rate_hz);
  ServedCamera camera(source, {});
  AravisDriver driver;
  CameraSettings settings = settings_for(width_px, height_px);
  settings.packet_bytes = 16404;
  settings.socket_buffer_bytes = 16U << 20U;
  CHECK_TRUE(open_soon(driver, settings) == Status::ok);
  const Received received = receive(driver, source, count);
  std::printf("%u x %u at %.0f Hz: %u of %u received at %.1f Hz (%.0f MB/s), %u damaged, %u missing, %llu underruns\n",
              width_px, height_px, rate_hz, received.good, count, received.rate_hz,
              received.rate_hz * width_px * height_px * 1e-6, received.damaged, received.missing,
              static_cast<unsigned long long>(driver.underruns()));
  driver.close();
  CHECK_EQUAL(count, received.good);
  CHECK_EQUAL(0, received.wrong);
}

}  // namespace

TEST_GROUP(GigeThroughput){void setup() override{enter_own_network();
}
}
;

TEST(GigeThroughput, SmallFramesAt200Hz) { check_rate(640, 480, 200.0, 800); }

TEST(GigeThroughput, LargeFramesAt30Hz) { check_rate(2048, 2048, 30.0, 120); }
