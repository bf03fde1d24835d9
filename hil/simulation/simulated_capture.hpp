#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hil/io/image.hpp"
#include "hil/replay/output_file.hpp"
#include "hil/simulation/simulation_plan.hpp"

namespace relnav::hil {

/// The frames of a simulation as a data set in the EuRoC layout, with its truth: what replay and HIL read.
class SimulatedCapture {
 public:
  /// Throws InputError: cannot be written.
  SimulatedCapture(const std::string& folder, const SimulationScenario& scenario, const SimulationPlan& plan);
  void add(std::size_t camera, Time stamp, const Image& image);

 private:
  std::string folder_;
  std::vector<std::unique_ptr<OutputFile>> lists_;
};

}  // namespace relnav::hil
