#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/camera.hpp"
#include "hal/clock.hpp"
#include "hil/io/image.hpp"
#include "hil/io/image_entry.hpp"
#include "hil/replay/run_camera.hpp"

namespace relnav::hil {

enum class Pace : std::uint8_t {
  max,   ///< a frame whenever one is asked for
  real,  ///< a frame not before its stamp, counted from the first frame handed out
};

enum class Depth : std::uint8_t {
  eight_bits,  ///< of 16-bit images the upper byte
  as_filed,    ///< mono8 or mono16
};

/// Camera over the images of a data set, in their order there: mid_exposure is the stamp that they have there (of
/// ClockId::device: the recording's own clock), sequence the row. An image that is missing, damaged or of another size is
/// answered with incomplete, once; problem() then says why, and the next call goes on.
class ReplayCamera final : public hal::Camera, public RunCamera {
 public:
  ReplayCamera(std::vector<ImageEntry> entries, std::uint32_t width_px, std::uint32_t height_px, hal::Clock& clock,
               Pace pace = Pace::max, Depth depth = Depth::eight_bits);

  Status start() override;
  Status acquire(Duration wait, hal::Frame& frame) override;
  Status release(const hal::Frame& frame) override;
  Status stop() override;
  [[nodiscard]] std::uint32_t max_leases() const override { return static_cast<std::uint32_t>(slots_.size()); }

  [[nodiscard]] std::size_t frames_listed() const override { return entries_.size(); }
  [[nodiscard]] bool exhausted() const { return next_ == entries_.size(); }
  [[nodiscard]] std::size_t frames_done() const override;
  [[nodiscard]] const ImageEntry& last_entry() const override { return entries_[next_ > 0 ? next_ - 1 : 0]; }
  [[nodiscard]] std::uint32_t incomplete_frames() const { return incomplete_; }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  struct Slot {
    Image image;
    std::uint32_t lease = 0;  ///< 0: free
  };
  /// Status::timeout or no_data while the next frame is not due yet.
  Status await_due(Duration wait);

  std::vector<ImageEntry> entries_;
  std::uint32_t width_px_;
  std::uint32_t height_px_;
  hal::Clock& clock_;
  Pace pace_;
  Depth depth_;
  std::array<Slot, 3> slots_;
  std::size_t next_ = 0;
  bool streaming_ = false;
  bool paced_ = false;
  Time first_handed_out_;
  Time first_stamp_;
  std::uint32_t last_lease_ = 0;
  std::uint32_t incomplete_ = 0;
  std::string problem_;
};

}  // namespace relnav::hil
