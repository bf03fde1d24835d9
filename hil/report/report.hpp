#pragma once
#include <string>
#include <vector>

#include "hil/replay/summary.hpp"

namespace relnav::hil {

/// A figure of the run beside those that it is held against; negative: none.
struct ReportFigure {
  std::string name;
  double reached = 0.0;
  double paper = -1.0, must = -1.0, goal = -1.0;
};

/// report.html: one file that needs no network. `evaluation` and `truth` may be null.
[[nodiscard]] std::string report_html(const RunDescription& description, const ReplayOutcome& outcome,
                                      const RunHistory& history, const Evaluation* evaluation, const Trajectory* truth,
                                      const std::vector<ReportFigure>& figures = {});

}  // namespace relnav::hil
