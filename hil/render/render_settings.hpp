#pragma once
#include <cstdint>
#include <string>

#include "hil/render/mesh_file.hpp"
#include "hil/render/point_spread.hpp"
#include "hil/render/sensor.hpp"
#include "platform/files/file_section.hpp"

namespace relnav::hil {

/// How images are made. Section `render` of a scenario; keys, units and ranges: docs/simulation-images.md.
struct RenderSettings {
  std::string mesh;  ///< path; empty: the satellite that is made in code (satellite.hpp)
  MeshPlacement placement;

  std::uint32_t threads = 2;
  std::uint32_t edge_samples = 4;  ///< rays in a pixel with an edge: 4 or a multiple of 8
  std::uint32_t motion_blur = 1;   ///< instants within the exposure, at most; as many as the motion needs
  double row_time_us = 0.0;        ///< rolling shutter: from one row to the next; 0: all rows at once

  double light_radiance = 4.0;  ///< of the markers, in units of a white, matt surface that faces the sun
  double earth_albedo = 0.3;
  double fill = 0.004;  ///< radiance from everywhere, same unit: what the target's parts throw on each other
  bool earth = true;    ///< its disc in the image; Earthshine is there all the same
  bool stars = true;
  double star_brightness = 1.0;  ///< 1: true to life, invisible beside a sunlit target

  PointSpread spread;
  SensorSettings sensor;
};

/// Strict; every key may be left out. Throws InputError with file and line.
[[nodiscard]] RenderSettings read_render_settings(const FileSection& section);
/// The keys that read_render_settings() knows, for the FileSection.
[[nodiscard]] std::vector<std::string> render_keys();

}  // namespace relnav::hil
