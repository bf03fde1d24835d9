// The flight loop of the installed package, between drivers of this project's own.
#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "fsw/app/flight_loop.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/base/panic.hpp"

namespace relnav {

void panic(const char* file, int line, const char* what) {
  std::printf("%s:%d: %s\n", file, line, what);
  std::abort();
}

}  // namespace relnav

namespace {

using namespace relnav;

/// Squares of random grey that drift by a pixel a frame.
class Camera final : public hal::Camera {
 public:
  static constexpr std::uint32_t size_px = 240;

  Status start() override { return Status::ok; }
  Status acquire(Duration, hal::Frame& frame) override {
    ++frame_count_;
    Generator generator(1);
    for (auto& level : squares_) level = static_cast<std::uint8_t>(30 + generator.below(200));
    for (std::uint32_t i = 0; i < pixels_.size(); ++i)
      pixels_[i] = squares_[i / size_px / 16 * 32 + (i % size_px + frame_count_) / 16];
    frame.pixels = pixels_.data();
    frame.width_px = frame.height_px = frame.stride_bytes = size_px;
    frame.mid_exposure = Time{frame_count_ * 100'000'000LL};
    frame.sequence = frame_count_;
    return Status::ok;
  }
  Status release(const hal::Frame&) override { return Status::ok; }
  Status stop() override { return Status::ok; }
  [[nodiscard]] std::uint32_t max_leases() const override { return 2; }

 private:
  std::array<std::uint8_t, 32 * 32> squares_{};
  std::array<std::uint8_t, std::size_t{size_px} * size_px> pixels_{};
  std::uint32_t frame_count_ = 0;
};

class Clock final : public hal::Clock {
 public:
  [[nodiscard]] Time now() override { return Time{++now_ns_}; }
  [[nodiscard]] hal::ClockId id() const override { return hal::ClockId::monotonic; }

 private:
  std::int64_t now_ns_ = 0;
};

class Link final : public hal::PacketLink {
 public:
  Status send(std::span<const std::uint8_t>) override {
    ++sent;
    return Status::ok;
  }
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return 1400; }
  int sent = 0;
};

class Watchdog final : public hal::Watchdog {
 public:
  Status kick() override {
    ++kicks;
    return Status::ok;
  }
  Status trip() override { return Status::ok; }
  int kicks = 0;
};

Camera camera;
Clock system_clock;
Link downlink;
Watchdog watchdog;
app::FlightLoop loop(camera, system_clock, downlink, watchdog);

}  // namespace

int main() {
  auto config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
  config.camera.fu = config.camera.fv = 300.0;
  config.camera.cu = config.camera.cv = 119.5;
  config.camera.width_px = config.camera.height_px = static_cast<std::int32_t>(Camera::size_px);
  config.navigator.filter.range_m = 5.0;
  if (loop.configure(config) != Status::ok || loop.start() != Status::ok) return 1;
  for (int i = 0; i < 40; ++i) loop.step();
  const bool good = watchdog.kicks == 40 && downlink.sent >= 40 && loop.mode() != app::Mode::standby;
  std::printf("%d packets\n", downlink.sent);
  return good ? 0 : 1;
}
