#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/config.hpp"
#include "hal/camera.hpp"
#include "hal/raw_container.hpp"
#include "platform/mps2/semihosting.hpp"

namespace relnav::platform::mps2 {

/// Pixels of one frame, of either format.
using FrameMemory = std::array<std::uint8_t, 2 * config::max_image_width * config::max_image_height>;

/// A camera whose link is a raw container on the host, which may still grow: each acquire() transfers the next frame. A frame whose header, size or
/// checksum is wrong, or that its recorder marked, is answered with incomplete, once.
class SemihostedCamera final : public hal::Camera {
 public:
  static constexpr std::size_t leases = 3;
  using Memory = std::array<FrameMemory, leases>;

  SemihostedCamera(const char* path, Memory& memory) : path_(path), memory_(memory) {}

  /// device_lost: no such file, or no whole container.
  Status start() override;
  Status acquire(Duration wait, hal::Frame& frame) override;
  Status release(const hal::Frame& frame) override;
  Status stop() override;
  [[nodiscard]] std::uint32_t max_leases() const override { return leases; }

  /// Frames dealt with so far: handed out and given back, or damaged.
  [[nodiscard]] std::uint32_t frames_done() const;
  [[nodiscard]] bool finished() const { return frames_done() >= header_.frames; }

 private:
  bool read_header();
  /// Header and pixels of the next frame.
  Status transfer(std::uint32_t number, FrameMemory& memory, hal::raw::FrameHeader& header);

  const char* path_;
  Memory& memory_;
  HostFile file_;
  hal::raw::FileHeader header_;
  std::array<std::uint32_t, leases> leases_{};  ///< 0: free
  std::uint32_t last_lease_ = 0;
  std::uint32_t next_ = 0;
  bool streaming_ = false;
};

}  // namespace relnav::platform::mps2
