#pragma once
#include <functional>
#include <string>
#include <vector>

#include "hil/replay/run_camera.hpp"
#include "hil/replay/run_folder.hpp"
#include "hil/replay/run_history.hpp"
#include "hil/replay/step_driver.hpp"

namespace relnav::hil {

struct ReplayOutcome {
  enum class End : std::uint8_t {
    all_frames,
    bad_image,  ///< a listed image could not be used; problem says which
    interrupted,
    stuck,        ///< the loop takes no more frames
    not_started,  ///< the loop refused to start
  };
  End end = End::all_frames;
  std::string problem;  ///< one line, empty when there is none
  app::Mode last_mode = app::Mode::standby;
  std::size_t poses = 0;
  double wall_s = 0.0;
};

/// Called after each step: frames dealt with, frames listed (of the camera that has most), the report. False ends the run (interrupt).
using ProgressListener = std::function<bool(std::size_t done, std::size_t listed, const app::StepReport&)>;

/// Steps the loop until the images of every camera have been dealt with, writing as it goes (`files` null: nothing). Throws InputError when the output
/// cannot be written.
ReplayOutcome run_replay(StepDriver& loop, const RunCameras& cameras, RunFiles* files, RunHistory& history,
                         const ProgressListener& listener);

/// 0 done, 1 ended in a fault, 2 unusable input.
[[nodiscard]] int exit_status_of(const ReplayOutcome& outcome);

}  // namespace relnav::hil
