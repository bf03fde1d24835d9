#pragma once
#include <array>
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

/// Takes frames of two cameras as the flight loop does: the earlier one, with its mate if the stamps are equal.
class FakePairLoop final : public hil::StepDriver {
 public:
  FakePairLoop(hal::Camera& first, hal::Camera& second) : cameras_{&first, &second} {}

  Status start() override {
    for (hal::Camera* camera : cameras_) {
      if (camera->start() != Status::ok) return Status::io_error;
    }
    return Status::ok;
  }
  const app::StepReport& step() override {
    for (std::size_t c = 0; c < 2; ++c) {
      if (!held_[c]) held_[c] = cameras_[c]->acquire(Duration{0}, frames_[c]) == Status::ok;
    }
    report_.mode = app::Mode::track;
    report_.status = Status::no_data;
    const bool both = held_[0] && held_[1];
    const bool first = held_[0] && (!both || frames_[0].mid_exposure <= frames_[1].mid_exposure);
    const bool second = held_[1] && (!both || frames_[1].mid_exposure <= frames_[0].mid_exposure);
    if (!first && !second) return report_;
    report_.status = Status::ok;
    report_.camera = first ? 0 : 1;
    report_.state.time = frames_[report_.camera].mid_exposure;
    report_.state.t_CT = Vec3(0.0, 0.0, 5.0);
    report_.state.pose_covariance = Mat6::Identity() * 1e-6;
    const bool used[] = {first, second};
    for (std::size_t c = 0; c < 2; ++c) {
      if (!used[c]) continue;
      static_cast<void>(cameras_[c]->release(frames_[c]));
      held_[c] = false;
    }
    return report_;
  }

 private:
  std::array<hal::Camera*, 2> cameras_;
  std::array<hal::Frame, 2> frames_;
  std::array<bool, 2> held_{};
  app::StepReport report_;
};

}  // namespace relnav::test
