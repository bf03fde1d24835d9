#pragma once
#include <cstdint>

#include "fsw/base/time.hpp"
#include "hil/io/image.hpp"

namespace relnav::hil {

/// One frame as a player (frame_player.hpp) hands it to a sink, faults applied.
struct ServedFrame {
  const Image* image = nullptr;              ///< valid during write()
  Time stamp;                                ///< of the capture, on the recording's own clock
  std::uint64_t number = 0;                  ///< frames since the start, from 0, over all loops; lost ones count
  bool lost = false;                         ///< is never sent: its number is skipped, and its trigger used up
  std::uint32_t packets_lost_per_mille = 0;  ///< on the way of this frame; for sinks that have packets
};

struct FrameShape {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t bytes_per_pixel = 1;  ///< 1 or 2 (the machine's byte order)
};

/// Where a player's frames go: something that others take for a camera. Where it is (a device, an address) is told to the
/// constructor. Pace is the player's business; a sink that works in lock step lets write() wait for the trigger.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// The camera appears, before the first frame and after unplug(). All frames have this shape. Throws InputError.
  virtual void plug(const FrameShape& shape) = 0;
  /// The camera vanishes.
  virtual void unplug() = 0;
  /// True: the frame is sent (or lost, as it should be). False: nobody took it within `wait`; call again with the same one.
  /// Throws std::runtime_error when it will never work: one line, what is wrong with what.
  virtual bool write(const ServedFrame& frame, Duration wait) = 0;
};

}  // namespace relnav::hil
