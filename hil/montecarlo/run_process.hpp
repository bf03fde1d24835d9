#pragma once
#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil/io/file_handle.hpp"

namespace relnav::hil {

/// How a process ended.
struct ProcessEnd {
  int exit_status = -1;  ///< -1: ended by a signal
  int signal = 0;
  double cpu_s = 0.0;
};

/// One run as a process, so that its crash is its own. It is in a process group of its own (a terminal's Ctrl-C ends the campaign,
/// not the run as a failed one) and ends with the thread that started it, even when that is killed.
class RunProcess {
 public:
  /// Throws std::runtime_error when the system has no process left.
  RunProcess(const std::string& program, const std::vector<std::string>& arguments);
  RunProcess(RunProcess&&) noexcept;
  RunProcess& operator=(RunProcess&&) = delete;
  /// Ends it.
  ~RunProcess();

  /// Nothing while it runs.
  [[nodiscard]] std::optional<ProcessEnd> poll();
  /// The process and its children; poll() tells when it is over.
  void kill() const;
  /// First line that it wrote on stderr.
  [[nodiscard]] std::string first_complaint() const;

 private:
  FileHandle errors_;
  pid_t pid_ = -1;
};

}  // namespace relnav::hil
