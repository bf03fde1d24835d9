#pragma once
// The flight loop between scripted stubs, and a reader of what it sent.
#include <cmath>
#include <vector>

#include "fsw/app/flight_loop.hpp"
#include "fsw/telemetry/codec.hpp"
#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_clock.hpp"
#include "platform/host/scripted_command_source.hpp"
#include "platform/host/scripted_gpio_lines.hpp"
#include "platform/host/scripted_packet_link.hpp"
#include "platform/host/scripted_watchdog.hpp"
#include "tests/unit/app/rendered_box.hpp"

namespace relnav::test {

inline constexpr std::int64_t period_ns = 100'000'000;

struct LoopBench {
  platform::host::ScriptedCamera camera{2};
  platform::host::ScriptedCamera second{2};
  platform::host::ScriptedClock clock;
  platform::host::ScriptedPacketLink link;
  platform::host::ScriptedWatchdog watchdog;
  platform::host::ScriptedGpioLines lines{8, 256};
  platform::host::ScriptedCommandSource commands;
  app::FlightLoop loop;
  app::FlightLoopConfig config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
  std::size_t steps = 0;

  explicit LoopBench(bool stereo = false, bool peripherals = false)
      : loop(camera, clock, link, watchdog, stereo ? &second : nullptr,
             peripherals ? app::FlightPeripherals{&lines, &commands} : app::FlightPeripherals{}) {
    clock.set_tick({1000});
    config.camera = RenderedBox::camera();
    config.navigator.filter.range_m = 3.0;
    config.navigator.filter.start_frames = 6;
    config.navigator.filter.start_duration_s = 0.0;
  }

  [[nodiscard]] Status begin() {
    const Status status = loop.configure(config);
    return status == Status::ok ? loop.start() : status;
  }
  const app::StepReport& step() {
    ++steps;
    return loop.step();
  }
  /// One step on this image.
  const app::StepReport& feed(const RenderedBox::Pixels& pixels, std::int64_t time_ns, std::uint32_t sequence) {
    if (camera.push_frame(pixels, RenderedBox::width_px, RenderedBox::height_px, Time{time_ns}, sequence) !=
        Status::ok) {
      std::abort();
    }
    return step();
  }
  const app::StepReport& feed(const hal::Frame& frame) {
    if (camera.push_frame(frame) != Status::ok) std::abort();
    return step();
  }

  /// EVENT packets with this id, in order.
  [[nodiscard]] std::vector<telemetry::EventPacket> events(telemetry::EventId id) const {
    std::vector<telemetry::EventPacket> found;
    for (std::size_t i = 0; i < link.size(); ++i) {
      telemetry::EventPacket p;
      if (telemetry::decode(link.packet(i), config.packets, p) != Status::ok) continue;
      if (p.event_id == static_cast<std::uint16_t>(id)) found.push_back(p);
    }
    return found;
  }
  template <typename Packet>
  [[nodiscard]] std::vector<Packet> packets() const {
    std::vector<Packet> found;
    for (std::size_t i = 0; i < link.size(); ++i) {
      Packet p;
      if (telemetry::decode(link.packet(i), config.packets, p) == Status::ok) found.push_back(p);
    }
    return found;
  }
  /// Packets that are of no kind of the table, or hold a NaN or infinity (decode refuses both).
  [[nodiscard]] std::size_t undecodable() const {
    const std::size_t good = packets<telemetry::RelStatePacket>().size() + packets<telemetry::FeaturesPacket>().size() +
                             packets<telemetry::HealthPacket>().size() + packets<telemetry::EventPacket>().size() +
                             packets<telemetry::TimePacket>().size() + packets<telemetry::CommandAckPacket>().size() +
                             packets<telemetry::PongPacket>().size();
    return link.size() - good;
  }
  [[nodiscard]] std::vector<std::uint8_t> bytes_sent() const {
    std::vector<std::uint8_t> all;
    for (std::size_t i = 0; i < link.size(); ++i) {
      const auto packet = link.packet(i);
      all.insert(all.end(), packet.begin(), packet.end());
    }
    return all;
  }
};

}  // namespace relnav::test
