#pragma once
#include <cstdint>
#include <string>

#include "fsw/base/time.hpp"

namespace relnav::hil {

/// A camera's trigger input: a pipe from which each line is one trigger, none lost. The kernel's trace of a GPIO line is such a
/// pipe (record_rises of hil/vm/guest/guest.sh); so is a FIFO that a script writes to.
class TriggerInput {
 public:
  /// Empty path: no trigger, wait() is true at once.
  explicit TriggerInput(std::string path) : path_(std::move(path)) {}
  TriggerInput(const TriggerInput&) = delete;
  TriggerInput& operator=(const TriggerInput&) = delete;
  ~TriggerInput() { close(); }
  /// From now on triggers count. Throws InputError when the pipe cannot be read.
  void open();
  void close();
  /// True: one trigger was there or came within `wait`, and is used up. Throws InputError.
  bool wait(Duration wait);

 private:
  void read_all();

  std::string path_;
  int fd_ = -1;
  std::uint64_t pending_ = 0;
};

}  // namespace relnav::hil
