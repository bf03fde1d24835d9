#pragma once
#include <string>
#include <vector>

#include "hil/io/image_entry.hpp"

namespace relnav::hil {

/// A source of frames as whoever drives a run sees it: how far it has got.
class RunCamera {
 public:
  [[nodiscard]] virtual std::size_t frames_listed() const = 0;
  /// Rows dealt with so far: handed out and given back, or no image.
  [[nodiscard]] virtual std::size_t frames_done() const = 0;
  /// Row handed out last.
  [[nodiscard]] virtual const ImageEntry& last_entry() const = 0;
  /// One line: file and expectation. Empty while every image was good.
  [[nodiscard]] virtual const std::string& problem() const = 0;
  [[nodiscard]] bool finished() const { return frames_done() == frames_listed(); }

 protected:
  RunCamera() = default;
  RunCamera(const RunCamera&) = default;
  RunCamera& operator=(const RunCamera&) = default;
  ~RunCamera() = default;
};

/// Those that the loop takes its frames from, in their order.
using RunCameras = std::vector<const RunCamera*>;

}  // namespace relnav::hil
