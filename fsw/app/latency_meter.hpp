#pragma once
#include <algorithm>
#include <cstdint>

#include "fsw/base/time.hpp"
#include "hal/clock.hpp"
#include "hal/frame.hpp"

namespace relnav::app {

/// Age of the latest frame when its first packet goes out. Only of frames whose stamps are of the loop's clock: the packets of a
/// replay must not depend on when it runs, and the clock is not even asked.
class LatencyMeter {
 public:
  struct Latencies {
    std::uint32_t from_exposure_us = 0;
    std::uint32_t from_arrival_us = 0;
  };

  void reset() { *this = LatencyMeter(); }
  void begin(const hal::Frame& frame, hal::ClockId clock) {
    mid_exposure_ = frame.mid_exposure;
    first_data_ = frame.first_data;
    pending_ = frame.clock == clock;
    if (!pending_) latest_ = Latencies();
  }
  /// The frame's first packet is about to be sent; later ones change nothing.
  void packet(hal::Clock& clock) {
    if (!pending_) return;
    pending_ = false;
    const Time now = clock.now();
    latest_ = {in_us(now - mid_exposure_), in_us(now - first_data_)};
    largest_.from_exposure_us = std::max(largest_.from_exposure_us, latest_.from_exposure_us);
    largest_.from_arrival_us = std::max(largest_.from_arrival_us, latest_.from_arrival_us);
  }
  [[nodiscard]] const Latencies& latest() const { return latest_; }
  /// Since the last call.
  [[nodiscard]] Latencies take_largest() {
    const Latencies largest = largest_;
    largest_ = Latencies();
    return largest;
  }

 private:
  [[nodiscard]] static std::uint32_t in_us(Duration length) {
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(length.ns / 1000, 0, 0xFFFFFFFF));
  }

  Time mid_exposure_;
  Time first_data_;
  bool pending_ = false;  ///< a frame whose first packet has not gone out
  Latencies latest_;
  Latencies largest_;
};

}  // namespace relnav::app
