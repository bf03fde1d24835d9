#pragma once
#include <string>

#include "fsw/base/time.hpp"

namespace relnav::hil {

/// A camera's trigger input, read from a file with '0' or '1' in it: the `value` of one line of gpio-sim, which shows what
/// another program drives. Nothing announces its changes: the file is read every 0.1 ms, and a level must last as long.
class TriggerFile {
 public:
  /// Empty path: no trigger, wait_for_edge() is true at once.
  explicit TriggerFile(std::string path) : path_(std::move(path)) {}
  /// True: the level rose since the last true (at the first call: is high, or rises). False: it did not within `wait`.
  /// Throws InputError when the file cannot be read or has something else in it.
  bool wait_for_edge(Duration wait);

 private:
  [[nodiscard]] bool level() const;

  std::string path_;
  bool high_ = false;  ///< when last looked at
};

}  // namespace relnav::hil
