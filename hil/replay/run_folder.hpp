#pragma once
#include <string>

#include "fsw/app/step_report.hpp"
#include "hil/replay/output_file.hpp"
#include "hil/replay/run_history.hpp"

namespace relnav::hil {

/// Makes DIR ready for a run and returns it. An existing folder that is not empty is refused unless `force`; then the files of an
/// earlier run are removed and all others left alone. Throws InputError.
std::string prepare_run_folder(const std::string& folder, bool force);

/// The text files of a run that grow frame by frame.
class RunFiles {
 public:
  explicit RunFiles(const std::string& folder);
  void add(const FrameRecord& record);
  void add_event(const std::string& line) { events_.line(line); }

 private:
  OutputFile trajectory_;
  OutputFile covariance_;
  OutputFile timing_;
  OutputFile events_;
};

}  // namespace relnav::hil
