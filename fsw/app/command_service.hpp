#pragma once
#include <array>
#include <cstdint>

#include "fsw/app/event_reporter.hpp"
#include "fsw/app/telemetry_writer.hpp"
#include "fsw/telemetry/telecommand.hpp"
#include "hal/clock.hpp"
#include "hal/command_source.hpp"

namespace relnav::app {

/// Reads telecommands and reports what becomes of each: TC_ACK accepted or refused when it is read, done or failed by finish().
/// One that is not for us is counted only.
class CommandService {
 public:
  static constexpr int most_a_step = 4;  ///< telecommands, good and bad ones

  /// `source` may be null: nothing ever comes then.
  CommandService(hal::CommandSource* source, hal::Clock& clock, TelemetryWriter& telemetry, EventReporter& events)
      : source_(source), clock_(clock), telemetry_(telemetry), events_(events) {}

  void configure(const telemetry::PacketConfig& packets);
  /// ok: `command` is accepted and to be carried out. no_data: there is none. Else one was refused, and there may be another.
  Status next(telemetry::Telecommand& command);
  /// What came of an accepted command; ok: done.
  void finish(const telemetry::TelecommandRequest& request, Status outcome);
  void pong();

 private:
  void refuse(const telemetry::Telecommand& command, Status reason);
  void acknowledge(const telemetry::TelecommandRequest& request, telemetry::CommandStage stage, Status code);
  void report(const telemetry::TelecommandRequest& request, Status reason);
  [[nodiscard]] std::uint64_t now_ns() { return static_cast<std::uint64_t>(clock_.now().ns); }

  hal::CommandSource* source_;
  hal::Clock& clock_;
  TelemetryWriter& telemetry_;
  EventReporter& events_;
  telemetry::PacketConfig packets_;
  std::uint32_t refused_ = 0;  ///< since configure()
  /// Room for telecommands of others too, so that they are told from ours by their header.
  std::array<std::uint8_t, 256> buffer_{};
};

}  // namespace relnav::app
