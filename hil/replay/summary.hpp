#pragma once
#include <optional>
#include <string>

#include "hil/evaluate/evaluation.hpp"
#include "hil/replay/replay_run.hpp"

namespace relnav::hil {

/// What the run was asked to do.
struct RunDescription {
  std::string dataset;
  std::string mode;
  std::string target;  ///< file, cooperative modes
  std::string method;  ///< solver, of `solve`; empty else
  std::string motion;  ///< noncoop; empty else
  std::string config;
  double range_m = 0.0;
  double range_sigma_m = 0.0;
  std::size_t frames_listed = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
};

/// Against the truth: `start` for a free target frame, `none` for one that is known. Nothing without poses or without an epoch in
/// common.
[[nodiscard]] std::optional<Evaluation> evaluate_run(const RunHistory& history, const Trajectory& truth,
                                                     AlignMode align);

struct TimeFigures {
  double median_us = 0.0, p95_us = 0.0, max_us = 0.0;
};
/// Of the total time a step, without reading the image.
[[nodiscard]] TimeFigures time_figures(const RunHistory& history);

/// summary.json
[[nodiscard]] std::string summary_json(const RunDescription& description, const ReplayOutcome& outcome,
                                       const RunHistory& history, const Evaluation* evaluation);

}  // namespace relnav::hil
