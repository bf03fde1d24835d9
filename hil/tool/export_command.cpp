#include <cstdio>
#include <filesystem>
#include <memory>

#include "hil/capture/export_run.hpp"
#include "hil/io/dataset.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/notes.hpp"
#include "hil/tool/progress.hpp"
#include "platform/files/camera_file.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  std::string container;
  std::string out;
  std::string calibration;
  int camera = 0;
  bool force = false;
};

/// Empty: there is none. Throws InputError when it is unusable, or of another size than the frames.
std::string checked_calibration(const ExportOptions& o, const RawContainerReader& container) {
  std::string path = o.calibration;
  if (path.empty() && fs::exists(calibration_beside(o.container))) path = calibration_beside(o.container);
  if (path.empty() || container.frames().empty()) return path;
  const CameraIntrinsics camera = read_camera_file(path, o.camera).intrinsics;
  const hal::raw::FrameHeader& first = container.frames().front().header;
  if (static_cast<std::uint32_t>(camera.width_px) != first.width_px ||
      static_cast<std::uint32_t>(camera.height_px) != first.height_px)
    throw InputError(path, 0, format_text("is for %d x %d pixels", camera.width_px, camera.height_px),
                     format_text("%u x %u as the frames have", first.width_px, first.height_px));
  return path;
}

/// SEQ/mav0/camN, ready for new files; a data set may get a further camera.
std::string prepare_camera_folder(const ExportOptions& o) {
  const fs::path folder = fs::path(o.out) / "mav0" / ("cam" + std::to_string(o.camera));
  std::error_code error;
  if (fs::exists(o.out) && !fs::is_directory(o.out))
    throw InputError(o.out, 0, "is a file", "a folder for the data set");
  const bool other = fs::is_directory(o.out) && !fs::is_empty(o.out, error) && !fs::exists(fs::path(o.out) / "mav0");
  const bool used = fs::is_directory(folder) && !fs::is_empty(folder, error);
  if ((other || used) && !o.force)
    throw InputError(other ? o.out : folder.string(), 0, "is not empty", "a new or empty folder, or --force");
  for (const char* name : {"data", "data.csv", "frames.csv", "sensor.yaml"}) fs::remove_all(folder / name, error);
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string(), 0, "cannot be created: " + error.message(), "a writable output folder");
  return folder.string();
}

int run(const ExportOptions& o) {
  const RawContainerReader container(o.container);
  const std::string calibration = checked_calibration(o, container);
  const std::string folder = prepare_camera_folder(o);
  print_notes(container.notes());
  std::error_code error;
  if (!calibration.empty()) fs::copy_file(calibration, folder + "/sensor.yaml", error);
  if (error) throw InputError(folder + "/sensor.yaml", 0, "cannot be written: " + error.message(), "room to write");

  catch_interrupts();
  Progress progress;
  const std::size_t listed = container.frames().size();
  const ExportOutcome outcome = export_frames(container, folder, [&](std::size_t done) {
    progress.show(done, listed, std::string("to ") + folder);
    return !interrupted();
  });
  progress.finish();
  print_notes(outcome.skipped);
  std::printf("%zu of %zu frames in %s%s, %zu skipped\n", outcome.exported, listed, folder.c_str(),
              calibration.empty() ? " (no sensor.yaml: there is no calibration)" : "", outcome.skipped.size());
  return outcome.exported + outcome.skipped.size() == listed ? exit_done : exit_fault;
}

}  // namespace

void add_export_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "A raw container to a data set in the EuRoC layout");
  command->add_option("FILE", o->container, "FILE.rnc, as relnav capture writes it")->required();
  command->add_option("--out", o->out, "Folder SEQ for mav0/camN/{data.csv,frames.csv,data/,sensor.yaml}")->required();
  command->add_option("--calibration", o->calibration, "Camera file, YAML [FILE.yaml where it exists]");
  command->add_option("--camera", o->camera, "N of camN [0]")->check(CLI::Range(0, 9));
  command->add_flag("--force", o->force, "Replace the files of an earlier export");
  command->callback([o, &exit_status] { exit_status = run(*o); });
}

}  // namespace relnav::hil
