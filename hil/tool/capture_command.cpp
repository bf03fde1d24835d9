#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "hil/capture/capture_run.hpp"
#include "hil/io/dataset.hpp"
#include "hil/tool/camera_choice.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/progress.hpp"
#include "platform/files/camera_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#include "platform/linux/monotonic_clock.hpp"
#include "platform/linux/pixel_conversion.hpp"

namespace relnav::hil {
namespace {

struct CaptureOptions {
  CameraChoice camera;
  std::uint64_t frames = 0;
  std::string out;
  std::string calibration;
  std::uint32_t buffer_mb = 256;
  bool force = false;
};

void take_size_from_calibration(CaptureOptions& o) {
  platform::linux::CameraSettings& s = o.camera.settings;
  if (!o.calibration.empty()) {
    const CameraIntrinsics camera = read_camera_file(o.calibration).intrinsics;
    const auto width = static_cast<std::uint32_t>(camera.width_px);
    const auto height = static_cast<std::uint32_t>(camera.height_px);
    if (s.width_px == 0) s.width_px = width;
    if (s.height_px == 0) s.height_px = height;
    if (s.width_px != width || s.height_px != height)
      throw InputError(o.calibration, 0, format_text("is for %u x %u pixels", width, height),
                       format_text("%u x %u as --width and --height say", s.width_px, s.height_px));
  }
  if (s.width_px == 0 || s.height_px == 0)
    throw InputError("relnav capture", 0, "does not know the size of the images",
                     "--width and --height, or --calibration CAM.yaml");
}

void refuse_existing(const std::string& path, bool force) {
  if (!force && std::filesystem::exists(path)) throw InputError(path, 0, "exists", "a new file, or --force");
}

void copy_calibration(const CaptureOptions& o) {
  if (o.calibration.empty()) return;
  const std::string beside = calibration_beside(o.out);
  std::error_code error;
  if (std::filesystem::equivalent(o.calibration, beside, error)) return;
  refuse_existing(beside, o.force);
  std::filesystem::copy_file(o.calibration, beside, std::filesystem::copy_options::overwrite_existing, error);
  if (error) throw InputError(beside, 0, "cannot be written: " + error.message(), "room and permission to write");
}

/// Frames that may wait for the disk.
std::size_t room_of(const CaptureOptions& o) {
  const platform::linux::CameraSettings& s = o.camera.settings;
  const auto format = platform::linux::format_named(s.format);
  const auto depth = format ? platform::linux::mono_format(*format) : hal::PixelFormat::mono16;
  const std::uint64_t image_bytes = platform::linux::row_bytes(depth, s.width_px) * s.height_px;
  return static_cast<std::size_t>(
      std::clamp<std::uint64_t>((std::uint64_t{o.buffer_mb} << 20U) / image_bytes, 3, 1024));
}

double per(double amount, double count) { return count > 0.0 ? amount / count : 0.0; }

void print_summary(const CaptureOptions& o, const CaptureOutcome& outcome, const FrameRecorder::Counts& disk,
                   std::uint64_t bytes, std::size_t room) {
  const CaptureCounts& c = outcome.counts;
  const double seconds = static_cast<double>(c.streaming.ns) * 1e-9;
  const double mb = static_cast<double>(bytes) * 1e-6;
  const auto ms_per = [](std::int64_t ns, std::uint64_t count) {
    return per(static_cast<double>(ns) * 1e-6, static_cast<double>(count));
  };
  std::printf("%llu frames in %s: %.1f MB in %.2f s, %.1f MB/s, %.2f Hz\n",
              static_cast<unsigned long long>(disk.recorded), o.out.c_str(), mb, seconds, per(mb, seconds),
              c.received > 1 ? per(static_cast<double>(c.received - 1), seconds) : 0.0);
  std::printf("camera: %llu received, %llu lost by sequence, %llu incomplete, %llu camera losses, %llu underruns\n",
              static_cast<unsigned long long>(c.received), static_cast<unsigned long long>(c.missing),
              static_cast<unsigned long long>(c.incomplete), static_cast<unsigned long long>(c.camera_losses),
              static_cast<unsigned long long>(c.underruns));
  const std::string numbers = ranges_text(c.without_room);
  std::printf(
      "disk: %zu without room%s%s, at most %zu of %zu waiting, write %.2f ms a frame, sync %.2f ms, longest %.1f ms\n",
      c.without_room.size(), numbers.empty() ? "" : ": ", numbers.c_str(), disk.most_waiting, room,
      ms_per(disk.write_ns, disk.recorded), ms_per(disk.sync_ns, disk.syncs), ms_per(disk.longest_ns, 1));
}

int capture(CaptureOptions o) {
  interpret(o.camera);
  take_size_from_calibration(o);
  refuse_existing(o.out, o.force);
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the file's size is an error of write()
  platform::linux::MonotonicClock clock;
  const auto driver = make_camera_driver(o.camera, clock);
  const std::size_t room = room_of(o);
  platform::linux::StreamOptions options;
  options.policy = platform::linux::FramePolicy::every_frame;
  options.leases = static_cast<std::uint32_t>(room) + 1;
  options.always_copy = o.camera.copy_frames;
  platform::linux::StreamCamera camera(*driver, clock, o.camera.settings, options);

  catch_interrupts();
  constexpr Duration patience_at_start{3'000'000'000};
  // First: without a camera an existing file stays as it is.
  if (!open_camera(camera, patience_at_start, [] { return !interrupted(); })) {
    if (interrupted()) return exit_fault;
    throw std::runtime_error(camera.problem());
  }
  RawContainerWriter writer(o.out);
  copy_calibration(o);
  FrameRecorder recorder(writer, room);
  Progress progress;
  const CaptureOutcome outcome = run_capture(camera, recorder, {.frames = o.frames}, [&](const CaptureCounts& counts) {
    progress.show(
        static_cast<std::size_t>(counts.received), static_cast<std::size_t>(o.frames),
        format_text("%llu lost, %llu incomplete, %zu without room", static_cast<unsigned long long>(counts.missing),
                    static_cast<unsigned long long>(counts.incomplete), counts.without_room.size()));
    return !interrupted();
  });
  progress.finish();
  std::string problem = outcome.problem;
  const std::uint64_t bytes = writer.bytes();
  try {
    writer.finish();
  } catch (const std::exception& error) {
    if (problem.empty()) problem = error.what();
  }
  const FrameRecorder::Counts disk = recorder.counts();
  print_summary(o, outcome, disk, bytes, room);
  if (!problem.empty())
    std::fprintf(stderr, "relnav: %s; the %llu frames before are kept\n", problem.c_str(),
                 static_cast<unsigned long long>(disk.recorded));
  return problem.empty() && (o.frames == 0 || disk.recorded >= o.frames) ? exit_done : exit_fault;
}

}  // namespace

void add_capture_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<CaptureOptions>();
  CLI::App* command = app.add_subcommand("capture", "Frames of a camera into a raw container");
  add_camera_options(*command, o->camera);
  command->add_option("--frames", o->frames, "End after so many recorded frames [none: until Ctrl-C]")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{UINT32_MAX}));
  command->add_option("--out", o->out, "FILE.rnc")->required();
  command->add_option("--calibration", o->calibration, "Camera file, YAML; copied beside as FILE.yaml");
  command->add_option("--buffer-mb", o->buffer_mb, "Memory for frames that wait for the disk [256]")
      ->check(CLI::Range(1, 65536));
  command->add_flag("--force", o->force, "Replace existing files");
  command->callback([o, &exit_status] { exit_status = capture(*o); });
}

}  // namespace relnav::hil
