#pragma once
#include <span>

#include "fsw/app/camera_image.hpp"
#include "fsw/app/step_report.hpp"

namespace relnav::app {

/// What the flight loop sees of an estimator: images in, relative state out.
class Navigator {
 public:
  /// Forgets everything learnt; the next image starts anew.
  virtual void restart() = 0;
  [[nodiscard]] virtual bool has_started() const = 0;
  /// There is an estimate, but its start is not over.
  [[nodiscard]] virtual bool is_starting() const = 0;
  /// One image a camera, taken at the same time. Fills state, counts, feature reports and stage times of `report`.
  /// Not started: too_few_features and what else kept it from starting. Started: ok (`state` is valid); out_of_order,
  /// invalid_argument: nothing was done; else why an update was refused, the state is the predicted one.
  virtual Status process(std::span<const CameraImage> images, Time time, StepReport& report) = 0;
  /// ok, or what is wrong with the numbers inside.
  [[nodiscard]] virtual Status check() const = 0;

 protected:
  Navigator() = default;
  Navigator(const Navigator&) = default;
  Navigator& operator=(const Navigator&) = default;
  ~Navigator() = default;
};

}  // namespace relnav::app
