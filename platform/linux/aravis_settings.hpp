#pragma once
#include <cstdint>
#include <string>

#include "platform/linux/camera_driver.hpp"

typedef struct _ArvCamera ArvCamera;
typedef struct _GError GError;

namespace relnav::platform::linux {

/// Takes an error of glib's on: `arv_f(..., failure)`, then ask. It may be used again.
class AravisFailure {
 public:
  AravisFailure() = default;
  AravisFailure(const AravisFailure&) = delete;
  AravisFailure& operator=(const AravisFailure&) = delete;
  ~AravisFailure();
  operator GError**();  ///< forgets an earlier one
  [[nodiscard]] bool happened() const { return error_ != nullptr; }
  [[nodiscard]] const char* text() const;
  [[nodiscard]] Status status() const;

 private:
  GError* error_ = nullptr;
};

/// What a camera works with after push_settings().
struct AppliedSettings {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  RawFormat format = RawFormat::grey8;
  std::uint32_t bits_per_pixel = 8;
  std::uint32_t pixel_format = 0;  ///< GenICam's number
  double exposure_us = 0.0;        ///< 0: the camera does not say
  double gain = 0.0;
};

/// Tells the camera everything but the transport. What it does not offer is unsupported, and `problem` says in one line what
/// and what it does offer.
Status push_settings(ArvCamera* camera, const CameraSettings& settings, AppliedSettings& applied, std::string& problem);

/// What the camera takes. unsupported: it has no exposure time to set.
Status exposure_range_of(ArvCamera* camera, ExposureRange& range);

/// Exposure and, unless it is negative, gain of a camera that streams; `values` becomes what it made of them.
Status push_exposure(ArvCamera* camera, ExposureValues& values);

}  // namespace relnav::platform::linux
