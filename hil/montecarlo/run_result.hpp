#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace relnav::hil {

enum class RunOutcome : std::uint8_t { tracked, regained, lost, no_pose, wrong_pose, error };

inline constexpr std::array run_outcomes{RunOutcome::tracked, RunOutcome::regained,   RunOutcome::lost,
                                         RunOutcome::no_pose, RunOutcome::wrong_pose, RunOutcome::error};

[[nodiscard]] const char* to_string(RunOutcome outcome);
/// Neither tracked nor regained.
[[nodiscard]] bool is_failure(RunOutcome outcome);

/// What `relnav sim --result` writes of one run: a flat JSON object. Everything but `wall_s` follows from scenario and run.
struct RunResult {
  std::string scenario;
  std::string scenario_crc;
  std::string version;
  std::uint64_t run = 0;
  std::optional<std::uint64_t> seed;  ///< none when the run ended before it could say
  RunOutcome outcome = RunOutcome::error;
  std::string problem;
  std::uint64_t frames = 0;
  std::uint64_t poses = 0;
  std::uint64_t invalid_flagged_valid = 0;
  std::vector<std::pair<std::string, double>> figures;  ///< finite ones
  double nees_sum = 0.0;                                ///< over `nees_count` epochs
  std::uint64_t nees_count = 0;
  std::uint64_t nees_dof = 0;
  std::vector<std::pair<std::string, double>> dispersed;  ///< what was drawn for this run
};

/// Nothing when the text is no whole result of that run: what was cut short does not count as one.
[[nodiscard]] std::optional<RunResult> parse_run_result(std::string_view text, std::uint64_t run);
/// The same on one line; nothing when it is no JSON.
[[nodiscard]] std::optional<std::string> one_line_json(std::string_view text);
/// The result of a run that left none. `wall_s` goes into it for whoever looks for time.
[[nodiscard]] std::string error_result_json(const RunResult& result, double wall_s);

}  // namespace relnav::hil
