#include "hil/serve/trigger_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "hil/io/input_error.hpp"

namespace relnav::hil {

bool TriggerFile::level() const {
  // Opened anew each time: what sysfs gives is made when a file is opened or read from its start.
  const int file = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  char text = 0;
  const bool read = file >= 0 && ::read(file, &text, 1) == 1;
  if (file >= 0) ::close(file);
  if (!read || (text != '0' && text != '1'))
    throw InputError(path_, 0, read ? "is no level of a line" : "cannot be read",
                     "a file with 0 or 1 in it, e.g. sim_gpioN/value of gpio-sim");
  return text == '1';
}

bool TriggerFile::wait_for_edge(Duration wait) {
  if (path_.empty()) return true;
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::nanoseconds(wait.ns);
  for (;;) {
    const bool was_high = high_;
    high_ = level();
    if (high_ && !was_high) return true;
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
}

}  // namespace relnav::hil
