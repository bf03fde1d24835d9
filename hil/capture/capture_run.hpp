#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hil/capture/frame_recorder.hpp"
#include "platform/linux/stream_camera.hpp"

namespace relnav::hil {

struct CaptureLimits {
  std::uint64_t frames = 0;           ///< 0: no end
  Duration patience{10'000'000'000};  ///< so long without the camera, and the run ends
};

struct CaptureCounts {
  std::uint64_t received = 0;               ///< whole frames that the camera gave
  std::uint64_t missing = 0;                ///< numbers that never came
  std::uint64_t incomplete = 0;             ///< came damaged
  std::vector<std::uint32_t> without_room;  ///< sequence numbers of whole frames for which the disk was too slow
  std::uint64_t camera_losses = 0;
  std::uint64_t underruns = 0;  ///< of the missing, as far as the driver knows: it had no free buffer
  Duration streaming;           ///< from the first frame to the last
};

struct CaptureOutcome {
  CaptureCounts counts;
  std::string problem;  ///< one line; empty: ended as it should
};

/// Tries for so long; false: no such camera, or `go_on`, asked at least every 0.1 s, says no.
[[nodiscard]] bool open_camera(platform::linux::StreamCamera& camera, Duration patience,
                               const std::function<bool()>& go_on);

/// Of an open camera. Acquires until `limits.frames` were recorded or are about to be, until `go_on`, asked at least every 0.1 s, says no, or
/// until the camera or the recorder fails for good. Opens a lost camera again. The recorder is finished and all leases are back
/// afterwards. `camera` needs one lease more than the recorder has room.
[[nodiscard]] CaptureOutcome run_capture(platform::linux::StreamCamera& camera, FrameRecorder& recorder,
                                         const CaptureLimits& limits,
                                         const std::function<bool(const CaptureCounts&)>& go_on);

/// "3, 7-12, 20" of increasing numbers; of many only the first ranges.
[[nodiscard]] std::string ranges_text(const std::vector<std::uint32_t>& numbers);

}  // namespace relnav::hil
