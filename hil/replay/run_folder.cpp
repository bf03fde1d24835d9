#include "hil/replay/run_folder.hpp"

#include <filesystem>

#include "hil/io/covariance_csv.hpp"
#include "hil/io/trajectory.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {

namespace fs = std::filesystem;

std::string prepare_run_folder(const std::string& folder, bool force) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (fs::exists(status) && !fs::is_directory(status))
    throw InputError(folder, 0, "is a file", "a folder for the results");
  if (fs::exists(status)) {
    const bool empty = fs::is_empty(folder, error);
    if (error) throw InputError(folder, 0, "cannot be read: " + error.message(), "a writable output folder");
    if (!empty && !force) throw InputError(folder, 0, "is not empty", "a new or empty folder, or --force");
    for (const char* name : {"trajectory.tum", "covariance.csv", "telemetry.bin", "events.log", "timing.csv",
                             "summary.json", "report.html"}) {
      fs::remove(fs::path(folder) / name, error);
      if (error)
        throw InputError((fs::path(folder) / name).string(), 0, "cannot be removed: " + error.message(),
                         "a writable output folder");
    }
  } else {
    fs::create_directories(folder, error);
    if (error) throw InputError(folder, 0, "cannot be created: " + error.message(), "a writable output folder");
  }
  return folder;
}

RunFiles::RunFiles(const std::string& folder)
    : trajectory_(folder + "/trajectory.tum"),
      covariance_(folder + "/covariance.csv"),
      timing_(folder + "/timing.csv"),
      events_(folder + "/events.log") {
  trajectory_.line(trajectory_header);
  covariance_.line(covariance_header());
  timing_.line("t_ns,acquire_us,predict_us,match_us,update_us,detect_us,telemetry_us,total_us");
}

void RunFiles::add(const FrameRecord& record) {
  if (record.has_pose) {
    trajectory_.line(trajectory_line({record.state.time, record.state.t_CT, record.state.R_CT}));
    covariance_.line(covariance_line({record.state.time, record.state.pose_covariance}));
  }
  const auto us = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  const app::StageTimes& t = record.times;
  timing_.line(format_text("%lld,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f,%.1f", static_cast<long long>(record.time.ns),
                           us(t.acquire_ns), us(t.predict_ns), us(t.match_ns), us(t.update_ns), us(t.detect_ns),
                           us(t.telemetry_ns), us(t.total_ns)));
}

}  // namespace relnav::hil
