#pragma once
#include <string>

#include "hil/montecarlo/run_result.hpp"

namespace relnav::hil {

/// All results of a campaign are of one state of the scenario: of the file and of all it names.
class ScenarioCheck {
 public:
  /// Throws InputError when `result` is of another state than those before. One that says nothing (a crash) is left alone.
  void add(const RunResult& result, const std::string& path);
  [[nodiscard]] const std::string& scenario() const { return scenario_; }
  [[nodiscard]] const std::string& scenario_crc() const { return scenario_crc_; }

 private:
  std::string scenario_;
  std::string scenario_crc_;
};

}  // namespace relnav::hil
