#pragma once
#include <cstdint>
#include <vector>

#include "hil/io/image.hpp"
#include "hil/render/point_spread.hpp"
#include "hil/render/worker_pool.hpp"

namespace relnav::hil {

/// From light to numbers. Figures are those of a small CMOS sensor.
struct SensorSettings {
  double electrons_per_s = 2e7;   ///< of a pixel that sees a white, matt surface facing the sun (aperture included)
  double full_well_e = 20'000.0;  ///< electrons of the highest level at gain 1
  double read_noise_e = 25.0;     ///< sd
  double dark_current_e_s = 50.0;
  double dark_level = 0.01;       ///< added to all levels, share of the highest
  bool noise = true;              ///< shot and read noise
  double response_sd = 0.005;     ///< how the pixels' responses differ, fixed by the seed
  std::uint32_t dead_pixels = 0;  ///< that see nothing
  std::uint32_t hot_pixels = 0;   ///< with a dark current that fills them in 20 ms .. 1 s
  std::uint32_t bits = 8;         ///< 8; 10, 12, 16: two bytes a pixel, the value in the upper bits
};

class Sensor {
 public:
  Sensor(const SensorSettings& settings, std::uint32_t width, std::uint32_t height, std::uint64_t seed);

  /// Level = quantised(gain (electrons + noise)) + dark level; electrons are limited by the full well, levels by the highest.
  /// Noise is normal with variance electrons + read noise^2 (the sum of 8 bytes of a hash of seed, frame, pixel: 4.9 sd at
  /// most); where some electrons are all there is, Poisson's skewness is missed.
  void expose(const Plane& radiance, double exposure_s, double gain, std::uint32_t frame, WorkerPool& pool,
              Image& out) const;

 private:
  SensorSettings settings_;
  std::uint32_t seed_;
  std::vector<float> response_;  // of each pixel
  std::vector<float> dark_e_s_;  // of each pixel
};

}  // namespace relnav::hil
