#include "hil/tool/camera_choice.hpp"

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#include "platform/linux/pixel_conversion.hpp"
#include "platform/linux/system_calls.hpp"
#include "platform/linux/v4l2_driver.hpp"
#ifdef RELNAV_HAS_ARAVIS
#include "platform/linux/aravis_driver.hpp"
#endif

namespace relnav::hil {
namespace {

constexpr const char* v4l2_scheme = "v4l2:";
constexpr const char* aravis_scheme = "aravis:";
constexpr std::uint32_t v4l2_buffers = 16;  // more than for flight: while the disk is busy images wait in them

bool begins_with(const std::string& text, const std::string& scheme) {
  return text.rfind(scheme, 0) == 0 && text.size() > scheme.size();
}

std::string format_names() {
  std::string names;
  for (const platform::linux::RawFormat format : platform::linux::all_formats)
    names += (names.empty() ? "" : ", ") + std::string(name_of(format));
  return names;
}

}  // namespace

void add_camera_options(CLI::App& command, CameraChoice& c) {
  command.add_option("--camera", c.camera, "v4l2:/dev/videoN, or aravis:NAME (name, serial number or address)")
      ->required();
  platform::linux::CameraSettings& s = c.settings;
  command.add_option("--width", s.width_px, "Pixels [as the calibration says]")->check(CLI::Range(1, 16384));
  command.add_option("--height", s.height_px, "Pixels [as the calibration says]")->check(CLI::Range(1, 16384));
  command.add_option("--format", s.format, format_names() + " [the deepest that the camera has]");
  command.add_option("--rate", s.rate_hz, "Frames per second [as the camera stands]")->check(CLI::Range(1e-3, 1e4));
  command.add_option("--exposure-us", s.exposure_us, "Microseconds [as the camera stands]")
      ->check(CLI::Range(1.0, 1e9));
  command.add_option("--gain", s.gain, "In the camera's unit [as the camera stands]")->check(CLI::Range(0.0, 1e9));
  command.add_option("--trigger", c.trigger, "free-running, software or line [free-running]")
      ->check(CLI::IsMember({"free-running", "software", "line"}));
  command
      .add_option(
          "--stamps", c.stamps,
          "What the camera's time stamps mean where its driver does not say; original: taken as they are, of the "
          "camera's own clock [end-of-exposure]")
      ->check(CLI::IsMember({"start-of-exposure", "mid-exposure", "end-of-exposure", "original"}));
  command.add_flag("--copy-frames", c.copy_frames, "For sources that overwrite buffers on loan (v4l2loopback)");
  command.add_option("--serial", s.serial, "aravis: the camera must have this serial number");
  command.add_option("--packet-bytes", s.packet_bytes, "aravis: size of a GigE Vision packet [negotiated]")
      ->check(CLI::Range(220, 65535));
  command.add_option("--socket-buffer-bytes", s.socket_buffer_bytes, "aravis: of the receiving socket [two frames]")
      ->check(CLI::Range(4096, 1 << 30));
}

void interpret(CameraChoice& c) {
  using platform::linux::StampMeaning;
  using platform::linux::Trigger;
  platform::linux::CameraSettings& s = c.settings;
  const bool v4l2 = begins_with(c.camera, v4l2_scheme);
  if (!v4l2 && !begins_with(c.camera, aravis_scheme))
    throw InputError("--camera " + in_quotes(c.camera), 0, "names no camera", "v4l2:/dev/videoN or aravis:NAME");
  s.device = c.camera.substr(c.camera.find(':') + 1);
  if (!s.format.empty() && !platform::linux::format_named(s.format))
    throw InputError("--format " + in_quotes(s.format), 0, "is no pixel format", "one of " + format_names());
  if (v4l2 && (!s.serial.empty() || s.packet_bytes > 0 || s.socket_buffer_bytes > 0))
    throw InputError(c.camera, 0, "takes no --serial, --packet-bytes or --socket-buffer-bytes",
                     "these with aravis: only");
  if (v4l2 && c.trigger == "software")
    throw InputError(c.camera, 0, "has no software trigger", "--trigger free-running or line");
  s.trigger = c.trigger == "software" ? Trigger::software : c.trigger == "line" ? Trigger::line : Trigger::free_running;
  s.original_stamps = c.stamps == "original";
  if (c.stamps == "start-of-exposure") s.stamp_meaning = StampMeaning::start_of_exposure;
  if (c.stamps == "mid-exposure") s.stamp_meaning = StampMeaning::mid_exposure;
}

std::unique_ptr<platform::linux::CameraDriver> make_camera_driver(const CameraChoice& c, hal::Clock& clock) {
  if (begins_with(c.camera, v4l2_scheme)) {
    static platform::linux::SystemCalls calls;
    return std::make_unique<platform::linux::V4l2Driver>(calls, clock, v4l2_buffers);
  }
#ifdef RELNAV_HAS_ARAVIS
  return std::make_unique<platform::linux::AravisDriver>();
#else
  throw InputError(c.camera, 0, "this relnav was built without Aravis", "a build where pkg-config finds aravis-0.8");
#endif
}

}  // namespace relnav::hil
