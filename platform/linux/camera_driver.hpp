#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/frame.hpp"

namespace relnav::platform::linux {

/// How pixels lie in a driver's buffer. Multi-byte values are little-endian.
enum class RawFormat : std::uint8_t {
  grey8,
  y10,  ///< 10 significant bits in 16
  y12,  ///< 12 significant bits in 16
  y16,
  y10p,  ///< 4 pixels in 5 bytes, as GenICam's Mono10p: a stream of bits, lowest first
  y12p,  ///< 2 pixels in 3 bytes, as GenICam's Mono12p
  yuyv,
  bayer_rggb8,
  bayer_grbg8,
  bayer_gbrg8,
  bayer_bggr8,
};

/// What moment of the exposure a driver's stamp means.
enum class StampMeaning : std::uint8_t { start_of_exposure, mid_exposure, end_of_exposure };

enum class Trigger : std::uint8_t {
  free_running,
  software,  ///< one frame for each call of CameraDriver::trigger()
  line,      ///< one frame for each edge on the camera's input, driven by somebody else
};

/// A control of the device that has no member of its own in CameraSettings, such as a sensor's trigger mode.
struct DeviceControl {
  std::string name;  ///< as v4l2-ctl writes it, e.g. "trigger_mode"
  std::int32_t value = 0;
};

/// Everything that a camera is told. A driver's open() pushes all of it, each time: a camera that lost its power has forgotten.
struct CameraSettings {
  std::string device;  ///< v4l2: path of the device node; aravis: name, serial number or address, as Aravis lists them
  std::string serial;  ///< aravis: the camera must have this serial number; empty: any
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::string format;    ///< name in RawFormat's spelling, e.g. "grey8"; empty: the deepest that the camera offers...
  int max_bits = 16;     ///< ...with at most so many significant bits
  double rate_hz = 0.0;  ///< 0: as the camera stands
  double exposure_us = 0.0;             ///< 0: as the camera stands
  double gain = -1.0;                   ///< in the driver's unit; negative: as the camera stands
  std::vector<DeviceControl> controls;  ///< v4l2: set after all else, in this order
  Trigger trigger = Trigger::free_running;
  StampMeaning stamp_meaning = StampMeaning::end_of_exposure;  ///< where the driver does not say
  bool original_stamps =
      false;  ///< stamps are taken as they are, of the camera's own clock (a replayed capture, a camera under PTP);
              ///< else they are brought to CLOCK_MONOTONIC
  std::uint32_t packet_bytes = 0;         ///< GigE Vision; 0: negotiated
  std::uint32_t socket_buffer_bytes = 0;  ///< GigE Vision; 0: two frames, or what the system allows
};

/// What a camera that streams can be told, in the driver's unit of gain.
struct ExposureRange {
  double least_us = 0.0;
  double most_us = 0.0;
  bool has_gain = false;  ///< false: there is none to set
  double gain_least = 0.0;
  double gain_most = 0.0;
};

struct ExposureValues {
  double exposure_us = 0.0;
  double gain = -1.0;  ///< negative: there is none to set
};

/// One buffer of a driver, on loan until give_back().
struct RawImage {
  std::span<const std::uint8_t> bytes;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t stride_bytes = 0;
  RawFormat format = RawFormat::grey8;
  bool complete = false;  ///< false: damaged or in part, not to be used
  Time stamp;
  StampMeaning stamp_meaning = StampMeaning::end_of_exposure;
  hal::ClockId clock = hal::ClockId::monotonic;  ///< of `stamp`
  Time first_data;                               ///< CLOCK_MONOTONIC; dequeued where the driver does not know
  Time dequeued;                                 ///< CLOCK_MONOTONIC
  bool has_sequence = false;                     ///< false: the driver does not count (some give 0 for ever)
  std::uint32_t sequence = 0;  ///< of a complete one: frames since open(), from 0, with lost ones; no wrap
  Duration exposure;           ///< 0: not known
  double gain = 0.0;           ///< 0: not known
  std::uint32_t buffer = 0;    ///< names it towards give_back()
};

/// What StreamCamera needs to know of one kind of camera. Not thread-safe; no call blocks longer than it says.
class CameraDriver {
 public:
  virtual ~CameraDriver() = default;
  /// Opens the device, pushes every setting, starts streaming. On any error everything is closed again and problem() says in
  /// one line what is wrong with what. no_data: there is no such device (yet); unsupported: no camera, or none with these
  /// settings; no_capacity: busy; io_error, timeout; invalid_argument: settings that contradict each other.
  virtual Status open(const CameraSettings& settings) = 0;
  /// Complete teardown: nothing is left mapped, open or running. Images on loan are void.
  virtual void close() = 0;
  /// The oldest image that waits. no_data or timeout: none came within `wait`; device_lost: gone, close() comes next;
  /// incomplete never: see RawImage::complete.
  virtual Status take(Duration wait, RawImage& image) = 0;
  virtual Status give_back(std::uint32_t buffer) = 0;
  /// With Trigger::software: asks for one frame.
  virtual Status trigger() = 0;
  /// unsupported: the camera has no exposure time to set; else as adjust().
  virtual Status exposure_range(ExposureRange& range) = 0;
  /// Tells a camera that streams another exposure within its range; `values` becomes what it made of it. Does not wait for a
  /// frame. RawImage::exposure and gain follow with the frames that may have them. io_error: not accepted, and all is as
  /// before; timeout: no answer yet; device_lost; not_configured: not open.
  virtual Status adjust(ExposureValues& values) = 0;
  /// Images that may be on loan at once while streaming goes on.
  [[nodiscard]] virtual std::uint32_t max_loans() const = 0;
  /// Frames that the driver knows it lost for want of a free buffer, since open().
  [[nodiscard]] virtual std::uint64_t underruns() const = 0;
  /// One line about the latest error: device, what is wrong, what was expected.
  [[nodiscard]] virtual const std::string& problem() const = 0;
};

}  // namespace relnav::platform::linux
