// The flight loop of the installed package, between drivers of this project's own.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

#include "fsw/app/flight_loop.hpp"
#include "fsw/base/panic.hpp"
#include "fsw/telemetry/codec.hpp"

namespace relnav {

void panic(const char* file, int line, const char* what) {
  std::printf("%s:%d: %s\n", file, line, what);
  std::abort();
}

}  // namespace relnav

namespace {

using namespace relnav;

/// Where the lamps are, in the target's frame; it comes closer by 2 cm a frame without turning.
const std::array<Vec3, 6> lamps{Vec3(-0.42, -0.40, -0.90), Vec3(0.45, -0.38, -0.96), Vec3(0.40, 0.43, -0.88),
                                Vec3(-0.44, 0.41, -1.02),  Vec3(0.80, 0.12, -0.58),  Vec3(-0.12, -0.80, -0.60)};
Vec3 target_at(std::uint32_t frame) { return {0.1, -0.05, 6.0 - 0.02 * frame}; }

/// Draws the lamps as spots of light, in place of a sensor.
class Camera final : public hal::Camera {
 public:
  static constexpr std::uint32_t size_px = 400;
  static constexpr double focal_length_px = 600.0;
  static constexpr double centre_px = 199.5;

  Status start() override { return Status::ok; }
  Status acquire(Duration, hal::Frame& frame) override {
    ++frame_count_;
    pixels_.fill(10);
    for (const Vec3& p_T : lamps) draw(p_T + target_at(frame_count_));
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
  void draw(const Vec3& p_C) {
    const double u = centre_px + focal_length_px * p_C.x() / p_C.z();
    const double v = centre_px + focal_length_px * p_C.y() / p_C.z();
    constexpr int reach = 4;
    for (int y = static_cast<int>(v) - reach; y <= static_cast<int>(v) + reach; ++y) {
      for (int x = static_cast<int>(u) - reach; x <= static_cast<int>(u) + reach; ++x) {
        const double off2 = (x - u) * (x - u) + (y - v) * (y - v);
        auto& pixel = pixels_[static_cast<std::size_t>(y) * size_px + static_cast<std::size_t>(x)];
        pixel = static_cast<std::uint8_t>(pixel + 200.0 * std::exp(-0.5 * off2));
      }
    }
  }

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

/// Reads what a ground station would: the poses.
class Link final : public hal::PacketLink {
 public:
  Status send(std::span<const std::uint8_t> bytes) override {
    telemetry::RelStatePacket packet;
    if (telemetry::decode(bytes, {}, packet) != Status::ok) return Status::ok;  // of another kind
    last_mode = static_cast<app::Mode>(packet.mode);
    const bool has_pose = (packet.valid_flags & telemetry::valid::pose) != 0;
    if (has_pose) ++poses;
    const Vec3 truth = target_at(packet.frame_sequence);
    const Vec3 error = Vec3(packet.t_CT[0], packet.t_CT[1], packet.t_CT[2]) - truth;
    if (has_pose) worst_error_m = std::max(worst_error_m, error.norm());
    std::printf("frame %u: %s, %d%%, t_CT = (%.4f, %.4f, %.4f) m, error %.4f m\n",
                static_cast<unsigned>(packet.frame_sequence), app::to_string(last_mode), int{packet.quality},
                packet.t_CT[0], packet.t_CT[1], packet.t_CT[2], has_pose ? error.norm() : 0.0);
    return Status::ok;
  }
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return telemetry::max_packet_bytes; }

  app::Mode last_mode = app::Mode::standby;
  int poses = 0;
  double worst_error_m = 0.0;
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
  config.navigation = app::NavigationKind::coop_mono;
  config.camera.fu = config.camera.fv = Camera::focal_length_px;
  config.camera.cu = config.camera.cv = Camera::centre_px;
  config.camera.width_px = config.camera.height_px = static_cast<std::int32_t>(Camera::size_px);
  for (const Vec3& p_T : lamps) {
    auto& features = config.coop.target.features;
    const TargetFeature lamp{.id = static_cast<std::uint16_t>(features.size() + 1), .p_T = p_T};
    if (features.push_back(lamp) != Status::ok) return 1;
  }
  if (loop.configure(config) != Status::ok || loop.start() != Status::ok) return 1;
  constexpr int frames = 40;
  for (int i = 0; i < frames; ++i) loop.step();
  std::printf("%d poses, at most %.4f m off, %s at the end\n", downlink.poses, downlink.worst_error_m,
              app::to_string(downlink.last_mode));
  const bool good = watchdog.kicks == frames && downlink.poses == frames && downlink.worst_error_m < 0.001 &&
                    downlink.last_mode == app::Mode::track;
  return good ? 0 : 1;
}
