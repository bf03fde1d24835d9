/// relnav-mps2 IN OUT: the flight loop on the board. IN holds what `relnav pack` made: setup.bin, frames0.rnc and, for two
/// cameras, frames1.rnc. OUT gets telemetry.bin and trajectory.tum, the same bytes as `relnav replay` writes, and effort.csv,
/// the time of each step. Exit status: as relnav's; 101 and up: the safe state, see safe_state.hpp.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "fsw/app/config_image.hpp"
#include "fsw/app/final_event.hpp"
#include "fsw/app/flight_loop.hpp"
#include "platform/mps2/effort_file.hpp"
#include "platform/mps2/no_heap.hpp"
#include "platform/mps2/recording_watchdog.hpp"
#include "platform/mps2/safe_state.hpp"
#include "platform/mps2/semihosted_camera.hpp"
#include "platform/mps2/semihosted_packet_link.hpp"
#include "platform/mps2/stack.hpp"
#include "platform/mps2/systick_clock.hpp"
#include "platform/mps2/trajectory_file.hpp"

namespace relnav::platform::mps2 {
namespace {

constexpr int exit_done = 0;
constexpr int exit_fault = 1;
constexpr int exit_unusable = 2;
constexpr int most_steps_without_frame = 100;

[[gnu::section(".frames")]] SemihostedCamera::Memory frames0;
[[gnu::section(".frames")]] SemihostedCamera::Memory frames1;

/// A path made of folder and name.
class Path {
 public:
  Path(const char* folder, const char* name) {
    const std::size_t length = std::strlen(folder);
    is_good_ = length + std::strlen(name) + 2 <= text_.size();
    if (!is_good_) return;
    std::memcpy(text_.data(), folder, length);
    text_[length] = '/';
    std::strcpy(&text_[length + 1], name);
  }
  /// Too long a path names no file.
  [[nodiscard]] const char* text() const { return is_good_ ? text_.data() : ""; }

 private:
  std::array<char, 512> text_{};
  bool is_good_ = false;
};

/// Everything the loop stands on. One object, static: built before main(), never destroyed.
struct Board {
  SystickClock clock;
  RecordingWatchdog watchdog;
  SemihostedPacketLink link;
  TrajectoryFile trajectory;
  EffortFile effort;
  telemetry::PacketConfig packets;
};
Board board;

void complain(const char* what, const char* subject) {
  write_console("relnav-mps2: ");
  write_console(subject);
  write_console(": ");
  write_console(what);
  write_console("\n");
}

void tell_ground(const SafeStateEntry& entry) {
  static_cast<void>(board.watchdog.trip());
  static_cast<void>(app::send_final_event(board.link, board.packets, telemetry::EventId::safe_state_entered,
                                          Status::device_lost,
                                          {static_cast<std::int64_t>(entry.cause), entry.where, entry.detail}));
}

Status read_setup(const char* path, app::FlightLoopConfig& config) {
  static std::array<std::uint8_t, app::max_config_image_bytes> image;
  HostFile file;
  const Status opened = file.open(path, HostFile::Access::read);
  if (opened != Status::ok) return opened;
  if (file.size() > image.size()) return Status::no_capacity;
  const std::span bytes = std::span(image).first(file.size());
  const Status read = file.read(0, bytes);
  return read == Status::ok ? app::read_config_image(bytes, config) : read;
}

bool has_pose(const app::StepReport& report) {
  return report.status == Status::ok && report.state.t_CT.allFinite() && report.state.R_CT.allFinite();
}

Status write_pose(const RelativeState& state) {
  Eigen::Quaterniond q_CT(state.R_CT);
  q_CT.normalize();
  if (q_CT.w() < 0.0) q_CT.coeffs() = -q_CT.coeffs();
  const Vec3& t = state.t_CT;
  return board.trajectory.add(state.time, {t.x(), t.y(), t.z()}, {q_CT.x(), q_CT.y(), q_CT.z(), q_CT.w()});
}

/// Steps until every frame has been dealt with.
int run(app::FlightLoop& loop, std::span<const SemihostedCamera* const> cameras) {
  const auto frames_done = [&] {
    std::uint32_t done = 0;
    for (const SemihostedCamera* camera : cameras) done += camera->frames_done();
    return done;
  };
  const auto finished = [&] {
    return std::all_of(cameras.begin(), cameras.end(), [](const SemihostedCamera* c) { return c->finished(); });
  };
  bool ended_well = false;
  int idle_steps = 0;
  while (!finished()) {
    const std::uint32_t done_before = frames_done();
    const app::StepReport& report = loop.step();
    if (frames_done() == done_before) {
      if (++idle_steps > most_steps_without_frame) {
        complain("takes no more frames", to_string(report.status));
        return exit_fault;
      }
      continue;
    }
    idle_steps = 0;
    const bool posed = has_pose(report);
    if (posed && write_pose(report.state) != Status::ok) {
      complain("cannot be written", "trajectory.tum");
      return exit_unusable;
    }
    board.effort.add(report.times.total_ns - report.times.acquire_ns, report.times.acquire_ns);
    ended_well =
        report.mode == app::Mode::track || (report.mode == app::Mode::acquire && posed && report.reset_counter == 0);
  }
  return ended_well ? exit_done : exit_fault;
}

void print_figure(const char* name, std::uint32_t value) {
  write_console(name);
  write_console(" ");
  write_console(value);
  write_console("\n");
}

int fly(const char* in, const char* out) {
  const Path telemetry_path(out, "telemetry.bin");
  if (board.link.open(telemetry_path.text()) != Status::ok ||
      board.trajectory.open(Path(out, "trajectory.tum").text()) != Status::ok ||
      board.effort.open(Path(out, "effort.csv").text()) != Status::ok) {
    complain("no files can be written here", out);
    return exit_unusable;
  }
  static app::FlightLoopConfig config;
  const Path setup_path(in, "setup.bin");
  const Status setup = read_setup(setup_path.text(), config);
  if (setup != Status::ok) {
    complain(to_string(setup), setup_path.text());
    static_cast<void>(
        app::send_final_event(board.link, board.packets, telemetry::EventId::configuration_refused, setup));
    return exit_unusable;
  }
  board.packets = config.packets;

  static const Path frames0_path(in, "frames0.rnc");
  static const Path frames1_path(in, "frames1.rnc");
  static SemihostedCamera camera(frames0_path.text(), frames0);
  static SemihostedCamera second(frames1_path.text(), frames1);
  const bool stereo = config.navigation == app::NavigationKind::coop_stereo;
  static app::FlightLoop loop(camera, board.clock, board.link, board.watchdog, stereo ? &second : nullptr);
  const Status configured = loop.configure(config);
  const Status started = configured == Status::ok ? loop.start() : configured;
  if (started != Status::ok) {
    complain(to_string(started), "the flight loop did not start");
    return exit_unusable;
  }
  const std::array<const SemihostedCamera*, 2> cameras{&camera, &second};
  const int status = run(loop, std::span(cameras).first(stereo ? 2 : 1));
  const Effort effort = board.effort.summary();
  print_figure("steps", effort.steps);
  print_figure("watchdog_kicks", board.watchdog.kicks());
  print_figure("median_step", effort.median);
  print_figure("maximum_step", effort.maximum);
  print_figure("stack_used", stack_used());
  return status;
}

}  // namespace
}  // namespace relnav::platform::mps2

int main(int argc, char** argv) {
  using namespace relnav::platform::mps2;
  forbid_heap();
  if (argc != 3) {
    complain("expected IN OUT", "arguments");
    return exit_unusable;
  }
  set_safe_state_hook(tell_ground);
  board.clock.start();
  return fly(argv[1], argv[2]);
}
