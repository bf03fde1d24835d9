/// relnav-flight CONFIG.yaml: the flight loop between real cameras, lines and links. Exit status: 0 ended by SIGTERM, SIGINT or
/// --frames; 1 the flight loop or its watchdog gave up; 2 unusable arguments, configuration, lines or links, with one line on stderr.
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>

#include "fsw/app/flight_loop.hpp"
#include "platform/files/flight_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/linux/gpio_backend.hpp"
#include "platform/linux/gpiod_lines.hpp"
#include "platform/linux/monotonic_clock.hpp"
#include "platform/linux/notify_watchdog.hpp"
#include "platform/linux/realtime.hpp"
#include "platform/linux/serial_link.hpp"
#include "platform/linux/service_notifier.hpp"
#include "platform/linux/signals.hpp"
#include "platform/linux/stream_camera.hpp"
#include "platform/linux/stream_exposure.hpp"
#include "platform/linux/strobed_camera.hpp"
#include "platform/linux/v4l2_driver.hpp"
#include "platform/posix/file_packet_link.hpp"
#include "platform/posix/udp_command_source.hpp"
#include "platform/posix/udp_packet_link.hpp"
#ifdef RELNAV_HAS_ARAVIS
#include "platform/linux/aravis_driver.hpp"
#endif

namespace relnav::platform::linux {
namespace {

constexpr int exit_done = 0;
constexpr int exit_fault = 1;
constexpr int exit_unusable = 2;
/// Longest pause without a camera: lines, commands and the watchdog are served in between.
constexpr Duration pause_without_camera{20'000'000};

struct Options {
  std::string config;
  std::uint64_t frames = 0;  ///< 0: no end
  bool check_only = false;
};

CameraSettings settings_of(const CameraSource& source, const CameraIntrinsics& intrinsics) {
  CameraSettings s;
  s.device = source.device;
  s.serial = source.serial;
  s.width_px = static_cast<std::uint32_t>(intrinsics.width_px);
  s.height_px = static_cast<std::uint32_t>(intrinsics.height_px);
  s.format = source.format;
  s.max_bits = 8;  // a deeper image is asked for by name: what it means is configured with it
  s.rate_hz = source.rate_hz;
  s.exposure_us = source.exposure_us;
  s.gain = source.gain;
  s.packet_bytes = source.packet_bytes;
  s.socket_buffer_bytes = source.socket_buffer_bytes;
  switch (source.trigger) {
    case CameraSource::Trigger::free_running: s.trigger = Trigger::free_running; break;
    case CameraSource::Trigger::software: s.trigger = Trigger::software; break;
    case CameraSource::Trigger::line: s.trigger = Trigger::line; break;
  }
  switch (source.stamps) {
    case CameraSource::Stamps::start_of_exposure: s.stamp_meaning = StampMeaning::start_of_exposure; break;
    case CameraSource::Stamps::mid_exposure: s.stamp_meaning = StampMeaning::mid_exposure; break;
    case CameraSource::Stamps::end_of_exposure: s.stamp_meaning = StampMeaning::end_of_exposure; break;
    case CameraSource::Stamps::original: s.original_stamps = true; break;
  }
  return s;
}

/// A camera and what it stands on, in the order of their making.
class CameraChain {
 public:
  /// Throws InputError.
  CameraChain(const CameraSource& source, const CameraIntrinsics& intrinsics, hal::Clock& clock)
      : driver_(make_driver(source, clock)) {
    StreamOptions options;
    options.always_copy = source.copy_frames;
    camera_.emplace(*driver_, clock, settings_of(source, intrinsics), options);
    const auto kind = source.gain_in_db ? GainUnit::Kind::decibel : GainUnit::Kind::linear;
    exposure_.emplace(*camera_, GainUnit{kind, source.gain_step});
  }
  void strobe_with(hal::GpioLines& lines, std::uint32_t offset) { strobed_.emplace(*camera_, lines, offset); }

  [[nodiscard]] hal::Camera& camera() {
    if (strobed_) return *strobed_;
    return *camera_;
  }
  [[nodiscard]] const StreamCamera& stream() const { return *camera_; }
  [[nodiscard]] hal::ExposureControl& exposure() { return *exposure_; }

 private:
  std::unique_ptr<CameraDriver> make_driver(const CameraSource& source, hal::Clock& clock) {
    if (source.kind == CameraSource::Kind::v4l2) return std::make_unique<V4l2Driver>(calls_, clock);
#ifdef RELNAV_HAS_ARAVIS
    return std::make_unique<AravisDriver>();
#else
    throw InputError("aravis:" + source.device, 0, "this build has no Aravis", "a v4l2 camera, or a build with Aravis");
#endif
  }

  SystemCalls calls_;
  std::unique_ptr<CameraDriver> driver_;
  std::optional<StreamCamera> camera_;
  std::optional<StreamExposure> exposure_;
  std::optional<StrobedCamera> strobed_;
};

/// One of the ways out for telemetry.
class Output {
 public:
  /// Throws InputError.
  explicit Output(const TelemetryOutput& output) {
    switch (output.kind) {
      case TelemetryOutput::Kind::udp:
        if (const Status status = udp_.open(output.address.host.c_str(), output.address.port); status != Status::ok)
          throw InputError("link.telemetry", 0, output.address.host + ": " + to_string(status), "a host that resolves");
        link_ = &udp_;
        break;
      case TelemetryOutput::Kind::file:
        if (const Status status = file_.open(output.path.c_str()); status != Status::ok)
          throw InputError("link.telemetry", 0, output.path + ": " + to_string(status), "a file that can be written");
        link_ = &file_;
        break;
      case TelemetryOutput::Kind::serial:
        if (serial_.open(output.path, output.baud) != Status::ok)
          throw InputError("link.telemetry", 0, serial_.problem(), "a serial line");
        link_ = &serial_;
        break;
    }
  }
  [[nodiscard]] hal::PacketLink& link() { return *link_; }
  /// What a line did not take at once.
  void flush() {
    if (serial_.waiting_bytes() > 0) static_cast<void>(serial_.flush());  // else with the next one
  }
  /// The last packets, as far as the line takes them within a second.
  void drain() {
    const timespec pause{0, 10'000'000};
    for (int i = 0; i < 100 && serial_.waiting_bytes() > 0 && serial_.flush() == Status::no_capacity; ++i)
      nanosleep(&pause, nullptr);
  }

 private:
  posix::UdpPacketLink udp_;
  posix::FilePacketLink file_;
  SerialLink serial_;
  hal::PacketLink* link_ = nullptr;
};

std::int32_t offset_of(GpiodLines& lines, const std::string& name) {
  if (name.empty()) return app::LineConfig::none;
  std::uint32_t offset = 0;
  if (lines.find_line(name, offset) != Status::ok) throw InputError("lines", 0, lines.problem(), "a line of this chip");
  return static_cast<std::int32_t>(offset);
}

/// TAI since 1958 minus CLOCK_MONOTONIC, as well as the system's clock knows.
Duration tai_offset(std::int64_t tai_utc_s, hal::Clock& clock) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const std::int64_t utc_ns = std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
  return {utc_ns + tai_utc_s * 1'000'000'000 + telemetry::unix_epoch_since_1958_ns - clock.now().ns};
}

/// Prints a line, and shows it in the service manager, when it is not the one before.
class Announcer {
 public:
  explicit Announcer(ServiceNotifier& notifier) : notifier_(notifier) {}
  void say(const std::string& line) {
    if (line == said_) return;
    said_ = line;
    std::fprintf(stderr, "relnav-flight: %s\n", line.c_str());
    static_cast<void>(notifier_.status(line));  // nobody has to listen
  }

 private:
  ServiceNotifier& notifier_;
  std::string said_;
};

void pause_for(Duration time) {
  const timespec pause{static_cast<time_t>(time.ns / 1'000'000'000), static_cast<long>(time.ns % 1'000'000'000)};
  nanosleep(&pause, nullptr);  // a signal ends it early
}

/// The flight loop with everything around it.
class Flight {
 public:
  explicit Flight(FlightFile file)
      : file_(std::move(file)),
        output_(file_.telemetry),
        camera_(file_.camera, file_.loop.camera, clock_),
        announcer_(notifier_) {
    if (file_.second) second_.emplace(*file_.second, file_.loop.second.intrinsics, clock_);
    if (file_.telecommands) listen(*file_.telecommands);
    if (!file_.lines.chip.empty()) wire_lines();
    const Duration offset = tai_offset(file_.tai_utc_s, clock_);
    file_.loop.lines.time.tai_offset = offset;
    const bool original = file_.camera.stamps == CameraSource::Stamps::original;
    file_.loop.packets.epoch_offset_ns = original ? 0 : offset.ns;  // of a recording's clock nothing is known
    if (notifier_.open(std::getenv("NOTIFY_SOCKET")) != Status::ok)
      throw InputError("NOTIFY_SOCKET", 0, notifier_.problem(), "the socket of a service manager");
    watchdog_.emplace(notifier_, clock_,
                      ServiceNotifier::watchdog_interval(std::getenv("WATCHDOG_USEC"), std::getenv("WATCHDOG_PID")));
    app::FlightPeripherals peripherals;
    if (!file_.lines.chip.empty()) peripherals.lines = &lines_;
    if (file_.telecommands) peripherals.commands = &commands_;
    if (file_.loop.exposure.enabled) {
      peripherals.exposures[0] = &camera_.exposure();
      if (second_) peripherals.exposures[1] = &second_->exposure();
    }
    loop_.emplace(camera_.camera(), clock_, output_.link(), *watchdog_, second_ ? &second_->camera() : nullptr,
                  peripherals);
    if (const Status status = loop_->configure(file_.loop); status != Status::ok)
      throw InputError("configuration", 0, std::string("the flight loop refuses it: ") + to_string(status),
                       "values inside their domains and lines that are free");
  }

  int run(std::uint64_t frames) {
    const std::string refused = become_realtime({file_.lock_memory, file_.priority});
    if (!refused.empty()) std::fprintf(stderr, "relnav-flight: %s\n", refused.c_str());
    note_stop_signals();
    static_cast<void>(notifier_.ready());  // a manager that went away is not needed
    std::uint64_t processed = 0;
    while (!stop_requested() && (frames == 0 || processed < frames)) {
      begin_when_possible();
      const app::StepReport& report = loop_->step();
      if (loop_->watchdog_status() == Status::device_lost) {
        announcer_.say("a step came too late for the watchdog");
        return exit_fault;
      }
      if (report.processed) ++processed;
      announce(report);
      output_.flush();
      if (report.status == Status::device_lost || report.mode == app::Mode::standby) wait_for_camera();
    }
    static_cast<void>(notifier_.stopping());
    if (loop_->stop() != Status::ok) announcer_.say("a camera did not stop as it should");
    static_cast<void>(loop_->step());  // the last packets
    output_.drain();
    return exit_done;
  }

 private:
  void listen(const UdpAddress& address) {
    if (commands_.open(address.host.c_str(), address.port) != Status::ok)
      throw InputError("link.telecommands", 0, commands_.problem(), "an address and port that are free");
  }

  void wire_lines() {
    if (lines_.open(file_.lines.chip) != Status::ok)
      throw InputError("lines.chip", 0, lines_.problem(), "a GPIO chip that may be used");
    app::LineConfig& config = file_.loop.lines;
    config.heartbeat = offset_of(lines_, file_.lines.heartbeat);
    config.pulse = offset_of(lines_, file_.lines.pulse);
    config.exposure = offset_of(lines_, file_.lines.exposure);
    const std::int32_t strobe = offset_of(lines_, file_.lines.strobe);
    if (strobe == app::LineConfig::none) return;
    const auto offset = static_cast<std::uint32_t>(strobe);
    if (lines_.request_output(offset, false) != Status::ok)
      throw InputError("lines.strobe", 0, lines_.problem(), "a line that is free");
    camera_.strobe_with(lines_, offset);  // of two cameras both hang on the first one's line
  }

  /// The loop begins once the cameras are there; afterwards only commands stop and start it.
  void begin_when_possible() {
    if (begun_) return;
    if (loop_->mode() != app::Mode::standby) {  // by a command
      begun_ = true;
      return;
    }
    if (until_next_attempt().ns > 0) return;
    const Status status = loop_->start();
    begun_ = status == Status::ok;
    if (status == Status::invalid_argument)  // no camera that may come will do with this
      throw InputError("camera", 0, problem(), "settings that fit together");
    if (!begun_) announcer_.say("waits for a camera: " + problem());
  }

  void wait_for_camera() {
    const Duration next = until_next_attempt();
    pause_for(next.ns > 0 ? std::min(next, pause_without_camera) : pause_without_camera);
  }

  [[nodiscard]] Duration until_next_attempt() const {
    const Duration first = camera_.stream().until_next_attempt();
    return second_ ? std::max(first, second_->stream().until_next_attempt()) : first;
  }

  /// Of the camera that keeps the flight waiting: where both are closed it is the one whose latest attempt failed.
  [[nodiscard]] const std::string& problem() const {
    const StreamCamera& first = camera_.stream();
    if (!second_) return first.problem();
    const StreamCamera& second = second_->stream();
    const bool second_fails = first.is_streaming() || second.until_next_attempt() > first.until_next_attempt();
    return second_fails ? second.problem() : first.problem();
  }

  void announce(const app::StepReport& report) {
    if (!begun_) return;
    if (report.status == Status::device_lost) {
      announcer_.say("lost a camera: " + problem());
    } else {
      announcer_.say(app::to_string(report.mode));
    }
  }

  FlightFile file_;
  MonotonicClock clock_;
  ServiceNotifier notifier_;
  Output output_;
  posix::UdpCommandSource commands_;
  std::unique_ptr<GpioBackend> backend_ = make_gpiod_backend();
  GpiodLines lines_{*backend_};
  CameraChain camera_;
  std::optional<CameraChain> second_;
  std::optional<NotifyWatchdog> watchdog_;
  std::optional<app::FlightLoop> loop_;
  Announcer announcer_;
  bool begun_ = false;
};

int fly(const Options& options) {
  FlightFile file = read_flight_file(options.config);
  if (options.check_only) return exit_done;
  static std::optional<Flight> flight;  // too large for a stack
  flight.emplace(std::move(file));
  const int status = flight->run(options.frames);
  flight.reset();
  return status;
}

}  // namespace
}  // namespace relnav::platform::linux

int main(int argc, char** argv) {
  using namespace relnav::platform::linux;
  Options options;
  CLI::App app{"relnav-flight: vision-based relative navigation between real cameras, lines and links"};
  app.set_version_flag("--version", RELNAV_VERSION);
  app.add_option("CONFIG", options.config, "Configuration, YAML; see docs/user-guide.md")->required();
  app.add_option("--frames", options.frames, "End after so many processed frames [none: until SIGTERM]")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--check", options.check_only, "Check the configuration and what it names, touch no device");
  try {
    app.parse(argc, argv);
    return fly(options);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "relnav-flight: %s (see relnav-flight --help)\n", error.what());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "relnav-flight: %s\n", error.what());
  }
  return exit_unusable;
}
