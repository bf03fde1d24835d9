#include "hil/montecarlo/run_result.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace relnav::hil {
namespace {

using Json = nlohmann::ordered_json;

std::optional<RunOutcome> run_outcome_of(const std::string& text) {
  for (const RunOutcome outcome : run_outcomes) {
    if (text == to_string(outcome)) return outcome;
  }
  return std::nullopt;
}

const Json* result_entry(const Json& json, const char* name) {
  const auto at = json.find(name);
  return at != json.end() ? &*at : nullptr;
}

bool take_text(const Json& json, const char* name, std::string& text) {
  const Json* entry = result_entry(json, name);
  if (entry == nullptr || !entry->is_string()) return false;
  text = entry->get<std::string>();
  return true;
}

bool take_count(const Json& json, const char* name, std::uint64_t& value) {
  const Json* entry = result_entry(json, name);
  if (entry == nullptr || !entry->is_number_unsigned()) return false;
  value = entry->get<std::uint64_t>();
  return true;
}

// What has no value in a run (null, or no number) is left out.
bool take_numbers(const Json& json, const char* name, std::vector<std::pair<std::string, double>>& values) {
  const Json* entry = result_entry(json, name);
  if (entry == nullptr || !entry->is_object()) return false;
  values.reserve(entry->size());
  for (const auto& [key, value] : entry->items()) {
    if (value.is_number() && std::isfinite(value.get<double>())) values.emplace_back(key, value.get<double>());
  }
  return true;
}

bool take_nees(const Json& json, RunResult& result) {
  const Json* nees = result_entry(json, "nees");
  if (nees == nullptr || nees->is_null()) return true;  // a run without covariances
  if (!nees->is_object() || !take_count(*nees, "count", result.nees_count) ||
      !take_count(*nees, "dof", result.nees_dof)) {
    return false;
  }
  const Json* sum = result_entry(*nees, "sum");
  if (sum != nullptr && sum->is_number() && std::isfinite(sum->get<double>())) {
    result.nees_sum = sum->get<double>();
  } else {
    result.nees_count = 0;
  }
  return true;
}

}  // namespace

const char* to_string(RunOutcome outcome) {
  switch (outcome) {
    case RunOutcome::tracked: return "tracked";
    case RunOutcome::regained: return "regained";
    case RunOutcome::lost: return "lost";
    case RunOutcome::no_pose: return "no_pose";
    case RunOutcome::wrong_pose: return "wrong_pose";
    case RunOutcome::error: break;
  }
  return "error";
}

bool is_failure(RunOutcome outcome) { return outcome != RunOutcome::tracked && outcome != RunOutcome::regained; }

std::optional<RunResult> parse_run_result(std::string_view text, std::uint64_t run) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  RunResult r;
  std::string outcome;
  if (!take_count(json, "run", r.run) || r.run != run || !take_text(json, "outcome", outcome)) return std::nullopt;
  const auto known = run_outcome_of(outcome);
  if (!known) return std::nullopt;
  r.outcome = *known;
  const bool whole = take_text(json, "scenario", r.scenario) && take_text(json, "scenario_crc", r.scenario_crc) &&
                     take_text(json, "version", r.version) && take_text(json, "problem", r.problem) &&
                     take_count(json, "frames", r.frames) && take_count(json, "poses", r.poses) &&
                     take_count(json, "invalid_flagged_valid", r.invalid_flagged_valid) &&
                     take_numbers(json, "figures", r.figures) && take_numbers(json, "dispersed", r.dispersed) &&
                     take_nees(json, r);
  if (!whole) return std::nullopt;
  std::uint64_t seed = 0;
  if (take_count(json, "seed", seed)) r.seed = seed;
  return r;
}

std::optional<std::string> one_line_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) return std::nullopt;
  return json.dump();
}

std::string error_result_json(const RunResult& r, double wall_s) {
  Json json;
  json["scenario"] = r.scenario;
  json["scenario_crc"] = r.scenario_crc;
  json["version"] = r.version;
  json["run"] = r.run;
  json["seed"] = r.seed ? Json(*r.seed) : Json(nullptr);
  json["outcome"] = to_string(r.outcome);
  json["problem"] = r.problem;
  json["frames"] = 0U;
  json["poses"] = 0U;
  json["invalid_flagged_valid"] = 0U;
  json["figures"] = Json::object();
  json["nees"] = nullptr;
  json["dispersed"] = Json::object();
  json["wall_s"] = wall_s;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace relnav::hil
