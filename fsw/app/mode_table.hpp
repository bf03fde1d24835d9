#pragma once
#include <array>
#include <cstddef>

#include "fsw/app/step_report.hpp"

namespace relnav::app {

/// One way from a mode to another. Cooperative modes add their rows here.
struct ModeTransition {
  Mode from;
  Mode to;
  const char* when;
};

inline constexpr std::array<ModeTransition, 8> mode_transitions{{
    {Mode::standby, Mode::acquire, "start() was called and the camera streams"},
    {Mode::acquire, Mode::track, "the filter runs, its start is over and the frame gave enough inliers"},
    {Mode::acquire, Mode::lost,
     "too long without inliers or usable frames, the filter failed its checks, or a command"},
    {Mode::track, Mode::lost, "too long without inliers or usable frames, the filter failed its checks, or a command"},
    {Mode::lost, Mode::acquire, "an image was good enough to start the filter anew"},
    {Mode::acquire, Mode::standby, "stop() was called"},
    {Mode::track, Mode::standby, "stop() was called"},
    {Mode::lost, Mode::standby, "stop() was called"},
}};

[[nodiscard]] constexpr bool is_allowed(Mode from, Mode to) {
  for (const ModeTransition& t : mode_transitions) {
    if (t.from == from && t.to == to) return true;
  }
  return false;
}

}  // namespace relnav::app
