#include "platform/linux/aravis_settings.hpp"

#include <arv.h>

#include <array>
#include <cstdio>
#include <cstring>

#include "platform/linux/pixel_conversion.hpp"

namespace relnav::platform::linux {
namespace {

struct Format {
  const char* name;
  RawFormat format;
  std::uint32_t number;  ///< GenICam's pixel format naming convention
  std::uint32_t bits;
};
/// The best first.
constexpr std::array formats{
    Format{"y16", RawFormat::y16, 0x01100007, 16},
    Format{"y12", RawFormat::y12, 0x01100005, 16},
    Format{"y12p", RawFormat::y12p, 0x010C0047, 12},
    Format{"y10", RawFormat::y10, 0x01100003, 16},
    Format{"y10p", RawFormat::y10p, 0x010A0046, 10},
    Format{"grey8", RawFormat::grey8, 0x01080001, 8},
    Format{"bayer_rggb8", RawFormat::bayer_rggb8, 0x01080009, 8},
    Format{"bayer_grbg8", RawFormat::bayer_grbg8, 0x01080008, 8},
    Format{"bayer_gbrg8", RawFormat::bayer_gbrg8, 0x0108000A, 8},
    Format{"bayer_bggr8", RawFormat::bayer_bggr8, 0x0108000B, 8},
};

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

class Pusher {
 public:
  Pusher(ArvCamera* camera, const CameraSettings& settings, AppliedSettings& applied, std::string& problem)
      : camera_(camera), settings_(settings), applied_(applied), problem_(problem) {}

  Status push() {
    arv_camera_stop_acquisition(camera_, failure_);  // left running by somebody; if it is not, that is no error
    for (const auto step : {&Pusher::push_format, &Pusher::push_size, &Pusher::push_rate_and_trigger,
                            &Pusher::push_exposure, &Pusher::push_gain}) {
      const Status status = (this->*step)();
      if (status != Status::ok) return status;
    }
    return Status::ok;
  }

 private:
  Status refuse(const std::string& what, const std::string& expectation, Status status = Status::unsupported) {
    problem_ = "camera " + settings_.device + ": " + what + " (expected " + expectation + ")";
    return status;
  }
  Status failed(const char* what) {
    return refuse(std::string(what) + " is not accepted: " + failure_.text(), "a camera that takes it",
                  failure_.status());
  }
  Status check(const std::string& what, double value, double low, double high) {
    if (value >= low && value <= high) return Status::ok;
    return refuse(what + " " + number(value) + " is not offered", number(low) + " to " + number(high));
  }

  Status push_format() {
    guint count = 0;
    gint64* const offered = arv_camera_dup_available_pixel_formats(camera_, &count, failure_);
    if (failure_.happened()) return failed("the question for pixel formats");
    const Format* chosen = nullptr;
    std::string names;
    bool known = settings_.format.empty();
    for (const Format& format : formats) {
      known = known || settings_.format == format.name;
      bool there = false;
      for (guint i = 0; i < count; ++i) there = there || offered[i] == static_cast<gint64>(format.number);
      if (!there) continue;
      names += (names.empty() ? "" : ", ") + std::string(format.name);
      const bool fits = settings_.format.empty() ? significant_bits(format.format) <= settings_.max_bits
                                                 : settings_.format == format.name;
      if (chosen == nullptr && fits) chosen = &format;
    }
    g_free(offered);
    if (!known) return refuse("there is no pixel format '" + settings_.format + "'", names);
    if (chosen == nullptr) {
      return refuse(settings_.format.empty() ? "it offers no pixel format that is known here"
                                             : "pixel format " + settings_.format + " is not offered",
                    names.empty() ? "a grey or 8-bit Bayer one" : names);
    }
    arv_camera_set_pixel_format(camera_, chosen->number, failure_);
    if (failure_.happened()) return failed("the pixel format");
    applied_.format = chosen->format;
    applied_.bits_per_pixel = chosen->bits;
    applied_.pixel_format = chosen->number;
    return Status::ok;
  }

  Status check_side(const char* what, std::uint32_t value, void (*bounds)(ArvCamera*, gint*, gint*, GError**),
                    gint (*increment)(ArvCamera*, GError**)) {
    gint low = 0;
    gint high = 0;
    bounds(camera_, &low, &high, failure_);
    if (failure_.happened()) return failed(what);
    gint step = increment(camera_, failure_);
    if (failure_.happened() || step < 1) step = 1;
    const auto wanted = static_cast<std::int64_t>(value);
    if (wanted >= low && wanted <= high && (wanted - low) % step == 0) return Status::ok;
    return refuse(std::string(what) + " " + std::to_string(value) + " px is not offered",
                  std::to_string(low) + " to " + std::to_string(high) + " in steps of " + std::to_string(step));
  }

  Status push_size() {
    if ((settings_.width_px == 0) != (settings_.height_px == 0))
      return refuse("width and height", "both, or none", Status::invalid_argument);
    if (settings_.width_px != 0) {
      if (arv_camera_is_region_offset_available(camera_, failure_)) {
        arv_camera_set_integer(camera_, "OffsetX", 0, failure_);
        arv_camera_set_integer(camera_, "OffsetY", 0, failure_);
      }
      Status status =
          check_side("width", settings_.width_px, arv_camera_get_width_bounds, arv_camera_get_width_increment);
      if (status == Status::ok)
        status =
            check_side("height", settings_.height_px, arv_camera_get_height_bounds, arv_camera_get_height_increment);
      if (status != Status::ok) return status;
      arv_camera_set_region(camera_, -1, -1, static_cast<gint>(settings_.width_px),
                            static_cast<gint>(settings_.height_px), failure_);
      if (failure_.happened()) return failed("the size");
    }
    gint x = 0;
    gint y = 0;
    gint width = 0;
    gint height = 0;
    arv_camera_get_region(camera_, &x, &y, &width, &height, failure_);
    if (failure_.happened()) return failed("the question for the size");
    applied_.width_px = static_cast<std::uint32_t>(width);
    applied_.height_px = static_cast<std::uint32_t>(height);
    if (settings_.width_px != 0 &&
        (applied_.width_px != settings_.width_px || applied_.height_px != settings_.height_px))
      return refuse("it stays at " + std::to_string(width) + " x " + std::to_string(height) + " px",
                    std::to_string(settings_.width_px) + " x " + std::to_string(settings_.height_px));
    if (applied_.width_px * applied_.bits_per_pixel % 8 != 0)
      return refuse("rows of " + std::to_string(width) + " packed pixels end within a byte", "a multiple of 4 px");
    return Status::ok;
  }

  Status push_rate_and_trigger() {
    arv_camera_set_acquisition_mode(camera_, ARV_ACQUISITION_MODE_CONTINUOUS, failure_);
    if (failure_.happened()) return failed("continuous acquisition");
    arv_camera_clear_triggers(camera_, failure_);
    if (settings_.trigger == Trigger::free_running) return push_rate();
    std::string source = "Software";
    if (settings_.trigger == Trigger::line) {
      source = first_line();
      if (source.empty()) return refuse("it has no trigger input", "a trigger source named Line...");
    }
    arv_camera_set_trigger(camera_, source.c_str(), failure_);
    if (failure_.happened()) return failed(("trigger source " + source).c_str());
    return Status::ok;
  }

  Status push_rate() {
    if (settings_.rate_hz <= 0.0) return Status::ok;
    if (!arv_camera_is_frame_rate_available(camera_, failure_)) return refuse("it has no frame rate to set", "rate 0");
    double low = 0.0;
    double high = 0.0;
    arv_camera_get_frame_rate_bounds(camera_, &low, &high, failure_);
    if (failure_.happened()) return failed("the question for frame rates");
    const Status status = check("a rate in Hz of", settings_.rate_hz, low, high);
    if (status != Status::ok) return status;
    arv_camera_set_frame_rate(camera_, settings_.rate_hz, failure_);
    return failure_.happened() ? failed("the frame rate") : Status::ok;
  }

  std::string first_line() {
    guint count = 0;
    const char** const sources = arv_camera_dup_available_trigger_sources(camera_, &count, failure_);
    std::string found;
    for (guint i = 0; i < count && found.empty(); ++i) {
      if (std::strncmp(sources[i], "Line", 4) == 0) found = sources[i];
    }
    g_free(sources);
    return found;
  }

  Status push_exposure() {
    const bool there = arv_camera_is_exposure_time_available(camera_, failure_) != 0;
    if (settings_.exposure_us > 0.0) {
      if (!there) return refuse("it has no exposure time to set", "exposure 0");
      if (arv_camera_is_exposure_auto_available(camera_, failure_))
        arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, failure_);
      double low = 0.0;
      double high = 0.0;
      arv_camera_get_exposure_time_bounds(camera_, &low, &high, failure_);
      if (failure_.happened()) return failed("the question for exposure times");
      const Status status = check("an exposure in us of", settings_.exposure_us, low, high);
      if (status != Status::ok) return status;
      arv_camera_set_exposure_time(camera_, settings_.exposure_us, failure_);
      if (failure_.happened()) return failed("the exposure time");
    }
    if (there) applied_.exposure_us = arv_camera_get_exposure_time(camera_, failure_);
    return Status::ok;
  }

  Status push_gain() {
    const bool there = arv_camera_is_gain_available(camera_, failure_) != 0;
    if (settings_.gain >= 0.0) {
      if (!there) return refuse("it has no gain to set", "no gain");
      if (arv_camera_is_gain_auto_available(camera_, failure_))
        arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, failure_);
      double low = 0.0;
      double high = 0.0;
      arv_camera_get_gain_bounds(camera_, &low, &high, failure_);
      if (failure_.happened()) return failed("the question for gains");
      const Status status = check("a gain of", settings_.gain, low, high);
      if (status != Status::ok) return status;
      arv_camera_set_gain(camera_, settings_.gain, failure_);
      if (failure_.happened()) return failed("the gain");
    }
    if (there) applied_.gain = arv_camera_get_gain(camera_, failure_);
    return Status::ok;
  }

  ArvCamera* camera_;
  const CameraSettings& settings_;
  AppliedSettings& applied_;
  std::string& problem_;
  AravisFailure failure_;
};

}  // namespace

AravisFailure::~AravisFailure() { g_clear_error(&error_); }

AravisFailure::operator GError**() {
  g_clear_error(&error_);
  return &error_;
}

const char* AravisFailure::text() const { return error_ != nullptr ? error_->message : ""; }

Status AravisFailure::status() const {
  if (error_ == nullptr) return Status::ok;
  if (error_->domain != ARV_DEVICE_ERROR) return Status::io_error;
  switch (error_->code) {
    case ARV_DEVICE_ERROR_NOT_FOUND:
    case ARV_DEVICE_ERROR_NOT_CONNECTED: return Status::no_data;
    case ARV_DEVICE_ERROR_TIMEOUT: return Status::timeout;
    case ARV_DEVICE_ERROR_NOT_CONTROLLER:
    case ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED:
    case ARV_DEVICE_ERROR_PROTOCOL_ERROR_BUSY: return Status::no_capacity;
    case ARV_DEVICE_ERROR_GENICAM_NOT_FOUND:
    case ARV_DEVICE_ERROR_NO_STREAM_CHANNEL:
    case ARV_DEVICE_ERROR_FEATURE_NOT_FOUND: return Status::unsupported;
    default: return Status::io_error;
  }
}

Status push_settings(ArvCamera* camera, const CameraSettings& settings, AppliedSettings& applied,
                     std::string& problem) {
  return Pusher(camera, settings, applied, problem).push();
}

Status exposure_range_of(ArvCamera* camera, ExposureRange& range) {
  AravisFailure failure;
  ExposureRange read;
  if (!arv_camera_is_exposure_time_available(camera, failure)) return Status::unsupported;
  arv_camera_get_exposure_time_bounds(camera, &read.least_us, &read.most_us, failure);
  if (failure.happened()) return failure.status();
  read.has_gain = arv_camera_is_gain_available(camera, failure) != 0;
  if (read.has_gain) arv_camera_get_gain_bounds(camera, &read.gain_least, &read.gain_most, failure);
  if (failure.happened()) return failure.status();
  range = read;
  return Status::ok;
}

Status push_exposure(ArvCamera* camera, ExposureValues& values) {
  AravisFailure failure;
  const double former_us = arv_camera_get_exposure_time(camera, failure);
  if (arv_camera_is_exposure_auto_available(camera, failure))
    arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, failure);
  arv_camera_set_exposure_time(camera, values.exposure_us, failure);
  if (failure.happened()) return failure.status();
  if (values.gain >= 0.0) {
    if (arv_camera_is_gain_auto_available(camera, failure)) arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, failure);
    arv_camera_set_gain(camera, values.gain, failure);
    if (failure.happened()) {
      AravisFailure ignored;
      arv_camera_set_exposure_time(camera, former_us, ignored);
      return failure.status();
    }
    values.gain = arv_camera_get_gain(camera, failure);
    if (failure.happened()) return failure.status();
  }
  values.exposure_us = arv_camera_get_exposure_time(camera, failure);
  return failure.status();
}

}  // namespace relnav::platform::linux
