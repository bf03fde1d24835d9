#pragma once
#include <cstdint>

#include "hal/watchdog.hpp"

namespace relnav::platform::mps2 {

/// Says afterwards what the watchdog of a flight board would have seen. Its deadline never comes: the emulator has no real time.
class RecordingWatchdog final : public hal::Watchdog {
 public:
  Status kick() override {
    if (tripped_) return Status::device_lost;
    ++kicks_;
    return Status::ok;
  }
  Status trip() override {
    tripped_ = true;
    return Status::ok;
  }
  [[nodiscard]] std::uint32_t kicks() const { return kicks_; }
  [[nodiscard]] bool tripped() const { return tripped_; }

 private:
  std::uint32_t kicks_ = 0;
  bool tripped_ = false;
};

}  // namespace relnav::platform::mps2
