#pragma once
#include <cstdint>

#include "fsw/app/auto_exposure.hpp"
#include "fsw/app/coop_navigator.hpp"
#include "fsw/app/filter_watch.hpp"
#include "fsw/app/frame_checks.hpp"
#include "fsw/app/line_config.hpp"
#include "fsw/app/noncoop_navigator.hpp"
#include "fsw/base/time.hpp"
#include "fsw/geometry/camera_model.hpp"
#include "fsw/telemetry/ccsds.hpp"

namespace relnav::app {

/// What is navigated on.
enum class NavigationKind : std::uint8_t {
  noncoop,      ///< nothing known of the target, one camera
  coop_mono,    ///< known light spots, one camera
  coop_stereo,  ///< known light spots, two cameras
};

/// The second camera of a pair: p_C1 = R_C1C0 p_C0 + t_C1C0 (m).
struct SecondCamera {
  CameraIntrinsics intrinsics;
  Mat3 R_C1C0 = Mat3::Identity();
  Vec3 t_C1C0 = Vec3::Zero();
  Duration pair_tolerance{1'000'000};  ///< largest difference of two mid-exposures that belong together
};

/// Everything the flight loop is told. Counts are frames unless they say otherwise.
struct FlightLoopConfig {
  NavigationKind navigation = NavigationKind::noncoop;
  CameraIntrinsics camera;
  SecondCamera second;  ///< coop_stereo
  NavigatorConfig navigator;
  CoopNavigatorConfig coop;  ///< coop_mono, coop_stereo; its lengths are true metres
  bool scale_known = false;  ///< the start range is a measured one: telemetry marks lengths as true metres

  telemetry::PacketConfig packets;           ///< epoch_offset_ns not negative
  std::uint16_t features_every_frames = 10;  ///< FEATURES packets; 0: none
  std::uint16_t health_every_frames = 10;    ///< HEALTH packets; 0: none
  std::uint16_t event_spacing_frames = 30;   ///< least distance of two reports of the same event

  Duration acquire_wait{50'000'000};       ///< longest wait of one step() for a frame
  Duration camera_silence{5'000'000'000};  ///< waited in vain for so long: the camera counts as lost
  std::uint16_t lost_after_frames = 10;    ///< frames in a row without enough inliers, or not usable; at least 1
  std::uint16_t min_inliers = 4;           ///< of a frame that counts as tracked
  FrameLimits frames;                      ///< latest_time_ns is cut to what telemetry can carry
  FilterLimits filter;
  LineConfig lines;
  AutoExposureConfig exposure;  ///< of cameras that have an exposure control

  [[nodiscard]] bool is_scale_known() const { return scale_known || navigation != NavigationKind::noncoop; }

  /// For a motion model; the caller adds camera and range.
  [[nodiscard]] static FlightLoopConfig defaults(MotionKind motion) {
    FlightLoopConfig config;
    config.navigator.filter = NoncoopConfig::defaults(motion);
    return config;
  }
};

/// What is wrong with a configuration; the `item` of a configuration_refused event.
enum class ConfigItem : std::uint8_t {
  none = 0,
  camera = 1,
  navigator = 2,
  packets = 3,
  limits = 4,
  lines = 5,
  exposure = 6
};

}  // namespace relnav::app
