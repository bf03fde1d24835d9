#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "hil/serve/fault.hpp"
#include "hil/serve/frame_sink.hpp"
#include "hil/serve/frame_source.hpp"

namespace relnav::hil {

struct PlayerSettings {
  /// Times as fast as it was captured; 0: lock step, a frame whenever the sink takes one.
  double speed = 1.0;
  bool loop = false;  ///< from the start again at the end; stamps and numbers go on
  std::vector<Fault> faults;
};

struct PlayedFrames {
  std::uint64_t sent = 0;
  std::uint64_t lost = 0;    ///< by a fault
  std::uint64_t unseen = 0;  ///< nobody took them in time
};

/// Plays a source into a sink. The first frame waits for somebody to take it, then the pace begins. At a pace, frames whose
/// time has passed while nobody took any or the camera was away are unseen, as with a camera; in lock step none is.
class FramePlayer {
 public:
  FramePlayer(FrameSource& source, PlayerSettings settings);
  /// Plugs the sink, plays until the end or until `stop` says true (asked every 0.1 s), unplugs. Throws as the sink does.
  /// `ready` is called each time that the camera is there (again).
  PlayedFrames play(FrameSink& sink, const std::function<bool()>& stop, const std::function<void()>& ready = {});

 private:
  struct Content {
    std::shared_ptr<const Image> image;
    ServedFrame frame;
  };
  [[nodiscard]] std::int64_t capture_ns(std::uint64_t number) const;
  Content content_of(std::uint64_t number);
  [[nodiscard]] const Fault* fault_at(FaultKind kind, std::uint64_t number) const;
  std::shared_ptr<const Image> image_before(std::uint64_t number, std::uint64_t steps);

  FrameSource& source_;
  PlayerSettings settings_;
  std::int64_t loop_ns_ = 0;  ///< from the first frame of a loop to the first of the next
};

}  // namespace relnav::hil
