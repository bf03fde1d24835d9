#include "hil/montecarlo/scenario_check.hpp"

#include "platform/files/input_error.hpp"

namespace relnav::hil {

void ScenarioCheck::add(const RunResult& result, const std::string& path) {
  if (result.scenario_crc.empty()) return;
  if (scenario_crc_.empty()) {
    scenario_ = result.scenario;
    scenario_crc_ = result.scenario_crc;
  }
  if (result.scenario_crc != scenario_crc_) {
    throw InputError(path, 0, "is of a scenario with CRC " + result.scenario_crc,
                     "CRC " + scenario_crc_ + " as in the results before: a file that the scenario names was changed");
  }
}

}  // namespace relnav::hil
