#pragma once
#include <algorithm>
#include <cstdint>

#include "fsw/base/time.hpp"

namespace relnav::platform::linux {

/// Brings stamps of a camera's own clock to CLOCK_MONOTONIC: a minimum filter over arrival - stamp. What arrives never does so
/// before its stamp, and now and then with the shortest delay possible, so the smallest difference seen is the offset between
/// the clocks plus that shortest delay (which nothing here can tell from the offset: stamps come out late by it, at most).
/// The clocks drift: between such arrivals the offset is let grow by no more than `max_drift_ppm` of the time that went by, so
/// a true drift up to that is followed, and jitter of the arrivals moves the result by no more than that either.
class DeviceClock {
 public:
  explicit DeviceClock(std::int64_t max_drift_ppm = 100) : max_drift_ppm_(max_drift_ppm) {}

  /// A stamp that goes back is a clock that was set anew: the offset starts over.
  [[nodiscard]] Time to_monotonic(Time stamp, Time arrival) {
    const std::int64_t difference_ns = arrival.ns - stamp.ns;
    if (!knows_ || stamp < last_stamp_) {
      offset_ns_ = difference_ns;
    } else {
      const std::int64_t elapsed_ns = std::max<std::int64_t>(arrival.ns - last_arrival_.ns, 0);
      const std::int64_t drift_ns =
          elapsed_ns / 1'000'000 * max_drift_ppm_ + elapsed_ns % 1'000'000 * max_drift_ppm_ / 1'000'000;
      offset_ns_ = std::min(difference_ns, offset_ns_ + drift_ns);
    }
    knows_ = true;
    last_stamp_ = stamp;
    last_arrival_ = arrival;
    return {stamp.ns + offset_ns_};
  }

  void forget() { knows_ = false; }

 private:
  std::int64_t max_drift_ppm_;
  bool knows_ = false;
  std::int64_t offset_ns_ = 0;
  Time last_stamp_;
  Time last_arrival_;
};

}  // namespace relnav::platform::linux
