#pragma once
#include <chrono>
#include <cstddef>
#include <string>

#include "fsw/app/step_report.hpp"

namespace relnav::hil {

/// One line on stderr, rewritten in place: frames or runs, rate, time left. Silent when stderr is no terminal.
class Progress {
 public:
  /// `unit`: what is counted.
  explicit Progress(const char* unit = "frame");
  void show(std::size_t done, std::size_t listed, const app::StepReport& report);
  /// `listed` 0: no end is known.
  void show(std::size_t done, std::size_t listed, const std::string& state);
  /// Removes the line.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  const char* unit_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point start_;
  Clock::time_point last_;
};

}  // namespace relnav::hil
