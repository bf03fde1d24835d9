#pragma once
#include <array>
#include <cmath>

#include "hil/dynamics/motion_settings.hpp"
#include "hil/dynamics/turning.hpp"
#include "hil/scenarios/gaussian.hpp"

namespace relnav::hil {

/// Unsteadiness of an attitude: eight harmonics an axis, evenly over half to one and a half times the frequency, of
/// random phase. A function of time alone, with an exact rate.
class Jitter {
 public:
  Jitter(const JitterSettings& settings, std::uint64_t seed) : settings_(settings) {
    Gaussian random(seed);
    for (Vec3& phase : phases_) {
      for (int i = 0; i < 3; ++i) phase(i) = random.uniform(0.0, 2.0 * pi);
    }
  }

  /// The true camera against the one that is aimed.
  [[nodiscard]] Turning at(double t_s) const {
    if (settings_.sigma_rad == 0.0) return {};
    const double amplitude = settings_.sigma_rad * std::sqrt(2.0 / static_cast<double>(phases_.size()));
    Vec3 phi = Vec3::Zero();
    Vec3 phi_rate = Vec3::Zero();
    for (std::size_t k = 0; k < phases_.size(); ++k) {
      const double turn = (static_cast<double>(k) + 0.5) / static_cast<double>(phases_.size());
      const double w = 2.0 * pi * settings_.frequency_hz * (0.5 + turn);
      for (int i = 0; i < 3; ++i) {
        phi(i) += amplitude * std::sin(w * t_s + phases_[k](i));
        phi_rate(i) += amplitude * w * std::cos(w * t_s + phases_[k](i));
      }
    }
    return turning_exp(phi, phi_rate);
  }

 private:
  JitterSettings settings_;
  std::array<Vec3, 8> phases_;
};

}  // namespace relnav::hil
