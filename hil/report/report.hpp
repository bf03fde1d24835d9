#pragma once
#include <string>

#include "hil/replay/summary.hpp"

namespace relnav::hil {

/// report.html: one file that needs no network. `evaluation` and `truth` may be null.
[[nodiscard]] std::string report_html(const RunDescription& description, const ReplayOutcome& outcome,
                                      const RunHistory& history, const Evaluation* evaluation, const Trajectory* truth);

}  // namespace relnav::hil
