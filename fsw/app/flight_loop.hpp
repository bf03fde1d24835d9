#pragma once
#include "fsw/app/step_report.hpp"
#include "hal/camera.hpp"
#include "hal/clock.hpp"
#include "hal/packet_link.hpp"
#include "hal/watchdog.hpp"

namespace relnav::app {

// API announced for those who build around it; the body follows.
struct FlightLoopConfig;

/// One step() a frame: lease, predict, match, update, detect, report, release.
class FlightLoop {
 public:
  FlightLoop(hal::Camera& camera, hal::Clock& clock, hal::PacketLink& link, hal::Watchdog& watchdog);
  /// Validates and takes the configuration; the loop is then in STANDBY.
  Status configure(const FlightLoopConfig& config);
  /// STANDBY -> ACQUIRE; starts the camera.
  Status start();
  /// Processes at most one frame. report.status: ok; no_data (no frame came); out_of_order, incomplete, invalid_argument,
  /// device_lost (frame or camera refused, an EVENT packet says so; the loop goes on).
  const StepReport& step();
};

}  // namespace relnav::app
