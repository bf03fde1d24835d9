#include "hil/tool/progress.hpp"

#include <unistd.h>

#include <cstdio>

namespace relnav::hil {

Progress::Progress(const char* unit)
    : unit_(unit), terminal_(::isatty(STDERR_FILENO) == 1), start_(Clock::now()), last_(start_) {}

void Progress::show(std::size_t done, std::size_t listed, const app::StepReport& report) {
  show(done, listed, std::string(app::to_string(report.mode)) + "  " + std::to_string(report.features) + " features");
}

void Progress::show(std::size_t done, std::size_t listed, const std::string& state) {
  constexpr auto period = std::chrono::milliseconds(100);
  const auto now = Clock::now();
  if (!terminal_ || ((done < listed || listed == 0) && now - last_ < period)) return;
  last_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed_s > 0.0 ? static_cast<double>(done) / elapsed_s : 0.0;
  if (listed == 0) {
    std::fprintf(stderr, "\r\033[K%s %zu  %.1f %ss/s  %s", unit_, done, rate, unit_, state.c_str());
  } else {
    const double left_s = rate > 0.0 && done < listed ? static_cast<double>(listed - done) / rate : 0.0;
    std::fprintf(stderr, "\r\033[K%s %zu of %zu  %.1f %ss/s  %.0f s left  %s", unit_, done, listed, rate, unit_, left_s,
                 state.c_str());
  }
  shown_ = true;
}

void Progress::finish() {
  if (shown_) std::fputs("\r\033[K", stderr);
  shown_ = false;
}

}  // namespace relnav::hil
