#pragma once
#include <cstdint>

namespace relnav::platform::linux {

/// Frames since a stream began, from the numbers that GigE Vision (16 bits, 65535 is followed by 1, 0 is no number) and USB3
/// Vision (64 bits, from 0) put on their frames. Lost frames count.
class BlockIdCounter {
 public:
  /// `first_of_stream`: the number which that kind of camera begins with.
  explicit BlockIdCounter(std::uint64_t first_of_stream = 1) : first_of_stream_(first_of_stream) {}

  std::uint32_t count(std::uint64_t id) {
    if (id < first_of_stream_) return sequence_ + (begun_ ? 1 : 0);  // a frame without its number: most likely the next
    if (!begun_) {
      begun_ = true;
      // A camera that has just been started: what lies before this frame was lost on the way. Else it counts on from earlier.
      if (id >= first_of_stream_ && id - first_of_stream_ < most_lost_at_start) {
        sequence_ = static_cast<std::uint32_t>(id - first_of_stream_);
      }
    } else {
      sequence_ += step(id);
    }
    last_ = id;
    return sequence_;
  }

 private:
  static constexpr std::uint64_t most_lost_at_start = 16;
  static constexpr std::uint64_t ids_of_16_bits = 65535;

  [[nodiscard]] std::uint32_t step(std::uint64_t id) const {
    if (id > last_) return static_cast<std::uint32_t>(id - last_);
    if (last_ <= ids_of_16_bits) {
      const std::uint64_t wrapped = id + ids_of_16_bits - last_;
      if (wrapped < ids_of_16_bits / 2) return static_cast<std::uint32_t>(wrapped);
    }
    return 1;  // it has begun anew, or repeats itself: numbers say nothing here
  }

  std::uint64_t first_of_stream_;
  std::uint64_t last_ = 0;
  std::uint32_t sequence_ = 0;
  bool begun_ = false;
};

}  // namespace relnav::platform::linux
