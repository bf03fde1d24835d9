#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "hal/camera.hpp"
#include "hil/replay/step_driver.hpp"

namespace relnav::test {

/// Takes frames as the flight loop does and reports a pose made from the stamp: a target at 5 m that turns about y at 0.1 rad/s.
class FakeLoop final : public hil::StepDriver {
 public:
  explicit FakeLoop(hal::Camera& camera) : camera_(camera) {}
  app::Mode mode = app::Mode::track;
  Status start_answer = Status::ok;
  bool takes_frames = true;
  bool finds_target = true;

  Status start() override {
    if (start_answer == Status::ok) start_answer = camera_.start();
    return start_answer;
  }
  const app::StepReport& step() override {
    hal::Frame frame;
    report_.mode = mode;
    report_.status = takes_frames ? camera_.acquire(Duration{0}, frame) : Status::no_data;
    if (report_.status != Status::ok) return report_;
    if (frame.mid_exposure <= report_.state.time) {
      report_.status = Status::out_of_order;
    } else if (!finds_target) {
      report_.status = Status::too_few_features;
    } else {
      const double angle = 0.1 * (frame.mid_exposure - Time{}).seconds();
      report_.state.time = frame.mid_exposure;
      report_.state.t_CT = Vec3(0.0, 0.0, 5.0);
      report_.state.R_CT << std::cos(angle), 0.0, std::sin(angle), 0.0, 1.0, 0.0, -std::sin(angle), 0.0,
          std::cos(angle);
      report_.state.pose_covariance = Mat6::Identity() * 1e-6;
      report_.features = 3;
      report_.times.total_ns = 2'500'000;
    }
    static_cast<void>(camera_.release(frame));
    return report_;
  }

 private:
  hal::Camera& camera_;
  app::StepReport report_;
};

}  // namespace relnav::test
