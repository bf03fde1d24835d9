#pragma once
#include "fsw/app/step_report.hpp"

namespace relnav::hil {

/// What a run drives: the flight loop, or a stand-in for it in tests.
class StepDriver {
 public:
  virtual ~StepDriver() = default;
  virtual Status start() = 0;
  /// At most one frame of the camera.
  virtual const app::StepReport& step() = 0;

 protected:
  StepDriver() = default;
  StepDriver(const StepDriver&) = default;
  StepDriver& operator=(const StepDriver&) = default;
};

}  // namespace relnav::hil
