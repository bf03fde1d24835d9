#include "hil/montecarlo/campaign_summary.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "hil/evaluate/chi_square.hpp"
#include "hil/io/atomic_file.hpp"
#include "hil/montecarlo/distribution.hpp"
#include "hil/montecarlo/scenario_check.hpp"
#include "hil/report/page.hpp"

namespace relnav::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_causes = 1000;
constexpr std::size_t failures_in_the_report = 200;

std::pair<double, double> chi_square_band_95(double dof) {
  constexpr double low = 0.025;
  constexpr double high = 0.975;
  constexpr double large = 1e5;
  if (dof < large) return {chi_square_quantile(low, dof) / dof, chi_square_quantile(high, dof) / dof};
  // Wilson, Hilferty 1931: here good to ten digits, and the sums above take long.
  const auto cube = [](double x) { return x * x * x; };
  const double spread = 2.0 / (9.0 * dof);
  constexpr double z = 1.959963984540054;
  return {cube(1.0 - spread - z * std::sqrt(spread)), cube(1.0 - spread + z * std::sqrt(spread))};
}

Json moments_json(const Moments& m) {
  return {{"count", m.count()}, {"mean", m.mean()}, {"sd", m.sd()}, {"min", m.min()}, {"max", m.max()}};
}

Json distribution_json(const Distribution& d) {
  Json json = moments_json(d.moments);
  for (std::size_t k = 0; k < percentile_points.size(); ++k) {
    json["percentiles"][std::to_string(percentile_points[k])] = d.percentiles[k];
  }
  const Histogram& h = d.histogram;
  json["histogram"] = {{"low", h.low}, {"high", h.high}, {"below", h.below}, {"above", h.above}, {"counts", h.counts}};
  return json;
}

// Numbers differ from run to run where the cause is the same.
std::string without_numbers(const std::string& text) {
  std::string out;
  for (std::size_t k = 0; k < text.size();) {
    if (std::isdigit(static_cast<unsigned char>(text[k])) == 0) {
      out += text[k++];
      continue;
    }
    while (k < text.size() &&
           (std::isdigit(static_cast<unsigned char>(text[k])) != 0 ||
            (text[k] == '.' && k + 1 < text.size() && std::isdigit(static_cast<unsigned char>(text[k + 1])) != 0))) {
      ++k;
    }
    out += '#';
  }
  return out;
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string for_a_shell(const std::string& text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("_-./+:@%").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

class Reduction {
 public:
  explicit Reduction(const CampaignIdentity& identity) : identity_(identity) {}

  void add(const RunResult& r) {
    ++merge_.results;
    ++outcomes_[r.outcome];
    frames_ += r.frames;
    poses_ += r.poses;
    invalid_ += r.invalid_flagged_valid;
    runs_with_invalid_ += r.invalid_flagged_valid > 0 ? 1U : 0U;
    for (const auto& [name, value] : r.figures) figures_[name].push_back(value);
    add_nees(r);
    const bool failed = is_failure(r.outcome);
    for (const auto& [name, value] : r.dispersed) {
      Dispersion& d = dispersions_[name];
      d.all.add(value);
      if (failed) d.failed.add(value);
    }
    if (failed) add_failure(r);
  }

  void add_missing(std::uint64_t run) {
    ++merge_.missing;
    if (!merge_.first_missing) merge_.first_missing = run;
  }

  [[nodiscard]] const CampaignMerge& merge() const { return merge_; }
  [[nodiscard]] const std::string& failures_csv() const { return failures_csv_; }
  [[nodiscard]] const Json& first_failures() const { return first_failures_; }

  [[nodiscard]] Json summary(const ScenarioCheck& check) {
    Json json;
    json["scenario"] = check.scenario();
    json["scenario_file"] = identity_.scenario;
    json["scenario_crc"] = check.scenario_crc();
    json["version"] = identity_.version;
    json["runs"] = identity_.runs;
    json["results"] = merge_.results;
    json["missing"] = merge_.missing;
    json["failures"] = merge_.failures;
    json["outcomes"] = outcomes_json();
    json["causes"] = causes_json();
    json["frames"] = frames_;
    json["poses"] = poses_;
    json["invalid_flagged_valid"] = {{"poses", invalid_}, {"runs", runs_with_invalid_}};
    json["nees"] = nees_json();
    json["figures"] = Json::object();
    for (auto& [name, values] : figures_) json["figures"][name] = distribution_json(distribution_of(std::move(values)));
    json["dispersions"] = Json::object();
    for (const auto& [name, d] : dispersions_) {
      json["dispersions"][name] = moments_json(d.all);
      json["dispersions"][name]["failed"] = moments_json(d.failed);
    }
    return json;
  }

 private:
  struct Dispersion {
    Moments all;
    Moments failed;
  };
  struct Cause {
    std::uint64_t runs = 0;
    std::uint64_t first_run = 0;
  };

  void add_nees(const RunResult& r) {
    if (r.nees_count == 0 || r.nees_dof == 0) return;
    const double dof = static_cast<double>(r.nees_count) * static_cast<double>(r.nees_dof);
    nees_sum_ += r.nees_sum;
    nees_dof_ += dof;
    nees_epochs_ += r.nees_count;
    const double mean = r.nees_sum / dof;
    nees_means_.push_back(mean);
    auto band = nees_bands_.find(dof);
    if (band == nees_bands_.end()) band = nees_bands_.emplace(dof, chi_square_band_95(dof)).first;
    nees_in_band_ += mean >= band->second.first && mean <= band->second.second ? 1U : 0U;
  }

  void add_failure(const RunResult& r) {
    ++merge_.failures;
    merge_.errors += r.outcome == RunOutcome::error ? 1U : 0U;
    std::pair key(r.outcome, without_numbers(r.problem));
    if (causes_.size() >= most_causes && causes_.find(key) == causes_.end()) key.second = "(further causes)";
    Cause& cause = causes_[key];
    if (cause.runs++ == 0) cause.first_run = r.run;
    const std::string seed = r.seed ? std::to_string(*r.seed) : std::string();
    const std::string command = reproducing_command(identity_.scenario, r.run);
    failures_csv_ += std::to_string(r.run) + "," + seed + "," + to_string(r.outcome) + "," + csv_field(r.problem) +
                     "," + csv_field(command) + "\n";
    if (first_failures_.size() < failures_in_the_report)
      first_failures_.push_back({r.run, seed, to_string(r.outcome), r.problem, command});
  }

  [[nodiscard]] Json outcomes_json() const {
    Json json;
    for (const RunOutcome outcome : run_outcomes) {
      const auto at = outcomes_.find(outcome);
      const std::uint64_t count = at != outcomes_.end() ? at->second : 0;
      const auto [low, high] = wilson_95(count, merge_.results);
      const double share = merge_.results > 0 ? static_cast<double>(count) / static_cast<double>(merge_.results) : 0.0;
      json[to_string(outcome)] = {{"count", count}, {"share", share}, {"share_95", {low, high}}};
    }
    return json;
  }

  // The most frequent first.
  [[nodiscard]] Json causes_json() const {
    std::vector<std::pair<std::pair<RunOutcome, std::string>, Cause>> list(causes_.begin(), causes_.end());
    std::stable_sort(list.begin(), list.end(),
                     [](const auto& a, const auto& b) { return a.second.runs > b.second.runs; });
    Json json = Json::array();
    for (const auto& [key, cause] : list) {
      json.push_back({{"outcome", to_string(key.first)},
                      {"problem", key.second},
                      {"runs", cause.runs},
                      {"first_run", cause.first_run}});
    }
    return json;
  }

  // Everything per degree of freedom: 1 is what a filter that knows its errors gives.
  [[nodiscard]] Json nees_json() {
    if (nees_means_.empty()) return nullptr;
    const std::uint64_t runs = nees_means_.size();
    const Distribution d = distribution_of(std::move(nees_means_));
    const auto [low, high] = chi_square_band_95(nees_dof_);
    constexpr double z = 1.959963984540054;
    const double half = z * d.moments.sd() / std::sqrt(static_cast<double>(runs));
    Json json;
    json["runs"] = runs;
    json["epochs"] = nees_epochs_;
    json["mean"] = nees_sum_ / nees_dof_;
    json["band_95"] = {low, high};  // if errors of one run were independent
    json["mean_of_runs_95"] = {d.moments.mean() - half, d.moments.mean() + half};  // whatever they are within a run
    json["runs_in_their_band_95"] = static_cast<double>(nees_in_band_) / static_cast<double>(runs);
    json["run_means"] = distribution_json(d);
    return json;
  }

  const CampaignIdentity& identity_;
  CampaignMerge merge_;
  std::map<RunOutcome, std::uint64_t> outcomes_;
  std::map<std::pair<RunOutcome, std::string>, Cause> causes_;
  std::map<std::string, std::vector<double>> figures_;
  std::map<std::string, Dispersion> dispersions_;
  std::uint64_t frames_ = 0;
  std::uint64_t poses_ = 0;
  std::uint64_t invalid_ = 0;
  std::uint64_t runs_with_invalid_ = 0;
  double nees_sum_ = 0.0;
  double nees_dof_ = 0.0;
  std::uint64_t nees_epochs_ = 0;
  std::uint64_t nees_in_band_ = 0;
  std::vector<double> nees_means_;
  std::map<double, std::pair<double, double>> nees_bands_;  // by degrees of freedom: runs often have the same
  std::string failures_csv_ = "run,seed,outcome,problem,command\n";
  Json first_failures_ = Json::array();
};

}  // namespace

std::string reproducing_command(const std::string& scenario, std::uint64_t run) {
  const std::string number = std::to_string(run);
  return "relnav sim --scenario " + for_a_shell(scenario) + " --run " + number + " --out run-" + number;
}

CampaignMerge merge_campaign(const CampaignFolder& folder) {
  const CampaignIdentity& identity = folder.identity();
  Reduction reduction(identity);
  ScenarioCheck check;
  folder.visit_results(0, identity.runs, [&](std::uint64_t run, const RunResult* result) {
    if (result == nullptr) {
      reduction.add_missing(run);
    } else {
      check.add(*result, folder.result_path(run));
      reduction.add(*result);
    }
    if (run % runs_in_a_pack == runs_in_a_pack - 1) folder.pack(run / runs_in_a_pack);
  });
  const CampaignMerge merge = reduction.merge();
  const Json summary = reduction.summary(check);
  const auto text_of = [](const Json& json, int indent) {
    return json.dump(indent, ' ', false, Json::error_handler_t::replace);
  };
  write_atomically(folder.path("failures.csv"), reduction.failures_csv());
  const Json page = {{"summary", summary}, {"failures", reduction.first_failures()}};
  write_atomically(folder.path("report.html"),
                   page_html("relnav: campaign " + check.scenario(), text_of(page, -1), PageKind::campaign));
  write_atomically(folder.path("summary.json"), text_of(summary, 2) + "\n");
  return merge;
}

}  // namespace relnav::hil
