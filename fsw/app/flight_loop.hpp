#pragma once
#include <array>
#include <cstdint>
#include <variant>

#include "fsw/app/auto_exposure.hpp"
#include "fsw/app/command_service.hpp"
#include "fsw/app/event_reporter.hpp"
#include "fsw/app/filter_watch.hpp"
#include "fsw/app/flight_config.hpp"
#include "fsw/app/flight_peripherals.hpp"
#include "fsw/app/frame_intake.hpp"
#include "fsw/app/latency_meter.hpp"
#include "fsw/app/line_service.hpp"
#include "fsw/app/mode_table.hpp"
#include "fsw/app/noncoop_navigator.hpp"
#include "fsw/app/step_report.hpp"
#include "fsw/app/telemetry_writer.hpp"
#include "hal/camera.hpp"
#include "hal/clock.hpp"
#include "hal/packet_link.hpp"
#include "hal/watchdog.hpp"

namespace relnav::app {

/// One step() a frame: lease, check, navigate, judge, report, release. Modes as in mode_table.hpp. The clock only
/// measures stage times (and the age of frames, if limited, and latencies, where frames are stamped by it): the same frames give
/// the same packets, bit for bit. Lines and telecommands, where there are any, are served in each step, in STANDBY too.
class FlightLoop {
 public:
  /// `second`: the other camera of a pair, for coop_stereo. While either gives none (lost, late, damaged) the loop goes on with
  /// what the other one sees; see FrameIntake.
  FlightLoop(hal::Camera& camera, hal::Clock& clock, hal::PacketLink& link, hal::Watchdog& watchdog,
             hal::Camera* second = nullptr, const FlightPeripherals& peripherals = {});

  /// Takes the configuration; the loop is then in STANDBY with all counts zero. invalid_argument: some value is outside
  /// its domain, the camera's image is larger than config.hpp allows, a line cannot be had, or the loop is not in STANDBY; nothing
  /// changes then, unless another kind of navigation was asked for, or for want of a line: the loop is then without configuration.
  Status configure(const FlightLoopConfig& config);
  /// STANDBY -> ACQUIRE; starts the cameras. not_configured; invalid_argument: not in STANDBY; the camera's own errors.
  Status start();
  /// To STANDBY; stops the cameras and gives their answer. The estimate is given up, counts stay.
  Status stop();

  /// Processes at most one frame, or one pair. report.status:
  /// ok: a frame was processed and report.state is valid.
  /// no_data, timeout: no frame came. too_few_features: a good frame, but nothing to start the estimate on.
  /// Frame not used: out_of_order (time stamp repeats or goes back), outside_domain (impossible time stamp),
  /// invalid_argument (size), unsupported (pixel format), incomplete (damaged, without contrast, or frozen).
  /// not_finite, not_positive_definite, no_convergence: the filter failed its checks and is given up.
  /// device_lost: no camera left, each step tries to start them. not_configured: not started.
  /// Whatever happens an EVENT packet says so and the loop goes on.
  const StepReport& step();

  [[nodiscard]] Mode mode() const { return report_.mode; }
  [[nodiscard]] const StepReport& report() const { return report_; }
  /// Answer to the latest kick.
  [[nodiscard]] Status watchdog_status() const { return watchdog_status_; }

 private:
  struct Counts {
    std::uint32_t processed = 0;
    std::uint32_t refused_updates = 0;
  };

  [[nodiscard]] ConfigItem validate(const FlightLoopConfig& config, CameraRig& rig) const;
  void configure_intake(const CameraRig& rig);
  /// The navigator that the configuration asks for takes it.
  Status configure_navigator(const FlightLoopConfig& config, const CameraRig& rig);

  Status take_frame();
  Status without_frame(const FrameEpoch& epoch);
  Status navigate(const FrameEpoch& epoch);
  Status judge_start(Status status);

  /// A frame that brought nothing to the estimate: after too many in a row it is given up.
  void count_frame_without_update(Status reason);
  void give_up_estimate(Status reason);
  void change_mode(Mode to, Status reason);

  void serve_exposures();
  void serve_commands();
  /// What the command did; unfinished: it will be told later.
  Status execute(const telemetry::Telecommand& command);
  Status restart_estimate();

  void begin_report();
  void send_packets();
  void send_health();

  hal::Clock& clock_;
  hal::Watchdog& watchdog_;
  FlightLoopConfig config_;
  bool configured_ = false;

  std::variant<NoncoopNavigator, CoopNavigator> navigators_;  ///< one at a time: they share their memory
  Navigator* navigator_;                                      ///< the one there is
  FrameIntake intake_;
  FilterWatch watch_;
  TelemetryWriter telemetry_;
  EventReporter events_;
  LineService lines_;
  CommandService commands_;
  telemetry::TelecommandRequest naming_request_;  ///< the latest set_tai accepted
  LatencyMeter latency_;
  std::array<AutoExposure, config::max_cameras> exposures_;  ///< by camera

  StepReport report_;
  Counts counts_;
  FrameStamp stamp_;  ///< latest frame used
  Duration silence_;  ///< waited without a frame from any camera
  bool has_estimate_ = false;
  bool health_due_ = false;           ///< in this step, whatever the count
  std::uint16_t without_update_ = 0;  ///< frames in a row
  std::uint32_t reported_drops_ = 0;
  Status watchdog_status_ = Status::ok;
};

static_assert(config::max_features > 60 || sizeof(FlightLoop) <= 2U * 1024U * 1024U,
              "static memory of the flight loop; a build that asks for more slots has to pay for them");

}  // namespace relnav::app
