#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "platform/linux/camera_driver.hpp"
#include "platform/linux/exposure_in_force.hpp"
#include "platform/linux/system_calls.hpp"
#include "platform/linux/v4l2_node.hpp"

struct v4l2_buffer;

namespace relnav::platform::linux {

/// A V4L2 camera: single-planar capture by streaming of mapped buffers, progressive.
///
/// Settings: size and format are taken exactly or refused; the rate within 1 %; exposure through V4L2_CID_EXPOSURE_ABSOLUTE
/// (steps of 100 us), or V4L2_CID_EXPOSURE where the driver gives the length of a line (pixel rate and horizontal blanking);
/// gain through V4L2_CID_GAIN or V4L2_CID_ANALOGUE_GAIN, in its steps. What is set manually has its automatism switched off.
/// V4L2 has no trigger: Trigger::software is unsupported; for Trigger::line name the control that this camera has for it in
/// CameraSettings::controls.
/// `serial` is not looked at: name the camera by its link under /dev/v4l/by-id.
///
/// Stamps are the kernel's: CLOCK_MONOTONIC, or the device's own where the driver only copies them. Marked as start of exposure
/// they are that; the usual mark, end of frame, does not tell readout from exposure: CameraSettings::stamp_meaning holds then.
/// A changed resolution is device_lost; open() then tells whether the camera still has the one asked for.
class V4l2Driver final : public CameraDriver {
 public:
  /// `clock`: CLOCK_MONOTONIC. `buffers`: asked of the device; it may give fewer or more.
  V4l2Driver(SystemCalls& calls, hal::Clock& clock, std::uint32_t buffers = 8)
      : calls_(calls), clock_(clock), node_(calls), buffers_wanted_(buffers) {}
  ~V4l2Driver() override { V4l2Driver::close(); }
  V4l2Driver(const V4l2Driver&) = delete;
  V4l2Driver& operator=(const V4l2Driver&) = delete;

  Status open(const CameraSettings& settings) override;
  void close() override;
  Status take(Duration wait, RawImage& image) override;
  Status give_back(std::uint32_t buffer) override;
  Status trigger() override;
  Status exposure_range(ExposureRange& range) override;
  /// A few ioctls. What is not taken is put back, as far as the device lets itself be told.
  Status adjust(ExposureValues& values) override;
  [[nodiscard]] std::uint32_t max_loans() const override;
  /// V4L2 does not tell: such losses are gaps of the sequence.
  [[nodiscard]] std::uint64_t underruns() const override { return 0; }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  struct Buffer {
    void* address = nullptr;
    std::size_t bytes = 0;
    bool on_loan = false;
  };

  // The steps of open(), in this order.
  Status check_settings();
  Status open_node();
  Status check_capabilities();
  Status choose_format();
  Status set_rate();
  Status set_exposure();
  Status set_gain();
  Status push_exposure(const ExposureValues& values);
  Status set_controls();
  Status map_buffers();
  Status start_streaming();

  /// How the device is told how long to expose.
  struct ExposureUnit {
    std::uint32_t id = 0;
    double unit_us = 0.0;
    const char* name = "";
  };
  [[nodiscard]] std::optional<ExposureUnit> exposure_unit();
  [[nodiscard]] std::uint32_t gain_id();
  /// ok, or the reason why the device does not do with this format.
  Status try_format(RawFormat format, std::string& reason);
  Status set_to(std::uint32_t id, double value, const char* what, const char* unit);
  int enqueue(std::uint32_t index);
  Status dequeue(RawImage& image);
  void fill_in(const v4l2_buffer& buffer, RawImage& image);
  [[nodiscard]] bool format_has_changed();
  [[nodiscard]] bool source_has_changed();

  /// Keep `what` as the problem.
  Status fail(Status status, const std::string& what);
  /// The same, with what `error` (-errno) means.
  Status fail_call(const std::string& what, int error);
  Status lose(const std::string& what, int error = 0);

  SystemCalls& calls_;
  hal::Clock& clock_;
  V4l2Node node_;
  std::uint32_t buffers_wanted_;
  CameraSettings settings_;

  RawFormat format_ = RawFormat::grey8;
  std::uint32_t stride_bytes_ = 0;
  std::uint32_t image_bytes_ = 0;     ///< a whole buffer's, as the device says
  std::uint64_t needed_bytes_ = 0;    ///< up to the last pixel
  ExposureInForce::Values exposure_;  ///< as the device says
  double exposure_us_ = 0.0;          ///< the same
  ExposureInForce in_force_;
  std::vector<Buffer> buffers_;
  bool streaming_ = false;

  bool has_frames_ = false;  ///< since open()
  bool counts_ = true;       ///< the sequence moves
  std::uint32_t first_sequence_ = 0;
  std::uint32_t last_sequence_ = 0;
  std::uint32_t usual_bytes_ = 0;  ///< length of an image after which the format was last seen to be ours
  std::string problem_;
};

}  // namespace relnav::platform::linux
