#include "fsw/vision/spot_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fsw/vision/spot_normal.hpp"
#include "fsw/vision/spot_profile.hpp"

namespace relnav::vision {
namespace {

constexpr int max_iterations = 12;
constexpr int max_half_px = 14;          // of the window
constexpr double profile_error = 0.02;   // of the level of the spot
constexpr double least_reach = 1.5;      // of the window beyond the spot, in point spreads, among other lights
constexpr double ring_reach = 3.0;       // of the ring
constexpr double added_reach = 1.0;      // on a dark background
constexpr double width_error_px = 0.04;  // of the width of the profile
constexpr double damping = 1.02;        // of the diagonal of amplitude and width, which hardly differ behind saturation
constexpr double clutter_weight = 0.3;  // of the variance of the ring in that of a pixel
// Normalised square residual at which the trust in a pixel has fallen to a quarter: at least, and at most in the first
// iterations and the later ones. Neighbours are let go of slowly, lest a start off the middle settle between two lights.
constexpr double least_scale = 9.0;
constexpr std::array<double, 4> first_scales{320.0, 80.0, 40.0, 20.0};
constexpr double path_error_px = 1.0;  // of the seed's half length
constexpr double least_path_px = 0.2;  // half length
constexpr std::size_t parameters = SpotNormal::parameters;
using Vector = SpotNormal::Vector;

double squared(double x) { return x * x; }

/// Level and scatter of the ring, from its quantiles: a neighbour in the ring does not count.
struct LightRing {
  double level = 0.0;
  double scatter = 0.0;
};

template <typename Pixel>
class Fit {
 public:
  Fit(const GreyImageView<Pixel>& image, const SpotSettings& settings, const SpotSeed& seed)
      : image_(image), settings_(settings), seed_(seed), inverse_s_(1.0 / settings.psf_sigma_px) {
    const double length = seed.half_streak_px.norm();
    if (length > 0.0) along_ = seed.half_streak_px / length;
    set_half_length(length);
  }

  [[nodiscard]] Status run(SpotFit& fit) {
    const double s = settings_.psf_sigma_px;
    // Of a disc drawn along the path: area = pi r^2 + 4 r L.
    const double drawn = 2.0 / pi * x_[5];
    const double radius = std::sqrt(drawn * drawn + seed_.area_px / pi) - drawn;
    ring_ = measure_ring(radius + ring_reach * s);
    clutter_variance_ = clutter_weight * squared(ring_.scatter);
    const double noise = std::sqrt(noise_variance(ring_.level));
    reach_px_ = s * (least_reach + added_reach * noise / (noise + ring_.scatter));
    if (!(seed_.peak_dn > ring_.level + 1.0)) return Status::no_convergence;
    const double room = settings_.full_scale_dn - ring_.level;
    x_ = {seed_.uv_px(0), seed_.uv_px(1), 0.0, std::max(radius, 0.7 * s), ring_.level, x_[5]};
    x_[2] = (seed_.peak_dn - ring_.level) / spot_profile(0.0, x_[3], inverse_s_).level;
    if (seed_.peak_dn >= settings_.full_scale_dn) {
      // Much brighter and narrower than it looks, with the same edge.
      x_[3] = std::max(radius - 0.7 * s, 0.5 * s);
      x_[2] = 0.5 * room / spot_profile(radius, x_[3], inverse_s_).level;
    }
    const double least = 0.2 * settings_.min_contrast * settings_.full_scale_dn;
    bool converged = false;
    scale_ = squared(4.0);
    for (int i = 0; i < max_iterations && !converged; ++i) {
      SpotNormal normal;
      accumulate(normal, first_scales[std::min(static_cast<std::size_t>(i), first_scales.size() - 1)]);
      if (used_ < 6.0) return Status::rank_deficient;
      // Far from the solution, or behind saturation, amplitude and width hardly differ.
      normal.matrix[2][2] *= damping;
      normal.matrix[3][3] *= damping;
      normal.matrix[2][2] += 1e-3 * squared(1.0 / room);
      normal.matrix[5][5] += 1.0 / squared(path_error_px);
      if (!normal.factorise()) return Status::rank_deficient;
      const Vector step = normal.solve(normal.right);
      const double limit = 0.7;
      x_[0] += std::clamp(step[0], -limit, limit);
      x_[1] += std::clamp(step[1], -limit, limit);
      x_[2] = std::clamp(x_[2] + std::clamp(step[2], -0.4 * x_[2], 0.6 * x_[2]), least, 100.0 * room);
      x_[3] = std::clamp(x_[3] + std::clamp(step[3], -0.5, 0.5), 0.5 * s, 12.0);
      x_[4] += step[4];
      set_half_length(std::min(x_[5] + std::clamp(step[5], -0.5, 0.5), 12.0));
      fit.iterations = i + 1;
      converged = std::fabs(step[0]) < settings_.converged_px && std::fabs(step[1]) < settings_.converged_px &&
                  std::fabs(step[3]) < 10.0 * settings_.converged_px;
      if (!(squared(x_[0] - seed_.uv_px(0)) + squared(x_[1] - seed_.uv_px(1)) <
            squared(1.0 + 0.5 * (radius + x_[5])))) {
        return Status::no_convergence;
      }
    }
    return finish(fit);
  }

 private:
  struct Model {
    double level = 0.0;
    double residual = 0.0;
    double variance = 0.0;  // of the noise
    double allowed = 0.0;   // variance that noise, clutter and the profile's errors explain
    double weight = 0.0;
    double trust = 0.0;  // of this, against outliers
    bool censored = false;
    Vector row{};
  };

  /// What hardly moved has not moved: from there on it is a round spot.
  void set_half_length(double px) {
    x_[5] = px > least_path_px ? px : 0.0;
    if (!(x_[5] > 0.0)) along_.setZero();
  }

  [[nodiscard]] LightRing measure_ring(double radius) const {
    std::array<double, 128> levels;
    std::size_t count = 0;
    const double inner = squared(radius);
    const double outer = squared(radius + 2.0);
    const int half = std::min(static_cast<int>(radius + x_[5] + 3.0), max_half_px + 4);
    const int uc = static_cast<int>(seed_.uv_px(0) + 0.5);
    const int vc = static_cast<int>(seed_.uv_px(1) + 0.5);
    // Of a wide ring every second or third pixel.
    const int stride = outer - inner > 36.0 ? 3 : 1;
    int skipped = 0;
    for (int v = std::max(vc - half, 0); v <= std::min(vc + half, image_.height - 1); ++v) {
      for (int u = std::max(uc - half, 0); u <= std::min(uc + half, image_.width - 1); ++u) {
        const double r2 = off_path(Vec2(u, v) - seed_.uv_px).squaredNorm();
        if (r2 < inner || r2 > outer || ++skipped % stride != 0) continue;
        if (count < levels.size()) levels[count++] = *image_.at(u, v);
      }
    }
    if (count < 4) return {0.0, settings_.full_scale_dn};
    const auto quantile = [&](double fraction) {
      auto* const wanted = levels.data() + static_cast<std::size_t>(fraction * static_cast<double>(count - 1));
      std::nth_element(levels.data(), wanted, levels.data() + count);
      return *wanted;
    };
    const double level = quantile(0.5);
    return {level, 0.5 * (quantile(0.84) - quantile(0.16))};
  }

  [[nodiscard]] double noise_variance(double level) const {
    // 1/12: levels are whole numbers.
    return squared(settings_.read_noise_dn) + 1.0 / 12.0 + std::max(level, 0.0) / settings_.gain_electrons_dn;
  }

  [[nodiscard]] bool model_at(int u, int v, double reach2, Model& model) const {
    const Vec2 from_middle(u - x_[0], v - x_[1]);
    const Vec2 from_path = off_path(from_middle);
    const double r2 = from_path.squaredNorm();
    if (r2 > reach2) return false;
    const double r = std::sqrt(r2 + 1e-9);
    const SpotProfile profile = spot_profile(r, x_[3], inverse_s_);
    const double amplitude = x_[2];
    const double spot = amplitude * profile.level;
    const double level = *image_.at(u, v);
    model.level = level;
    model.residual = level - (x_[4] + spot);
    model.censored = level >= settings_.full_scale_dn && model.residual <= 0.0;
    model.variance = noise_variance(x_[4] + spot);
    const double outward = -amplitude * profile.by_radius / r;
    // Beyond the ends a longer path comes nearer.
    const double lengthwise = from_path.dot(along_);
    model.row = {
        outward * from_path(0),         outward * from_path(1), profile.level, amplitude * profile.by_width, 1.0,
        outward * std::fabs(lengthwise)};
    model.allowed = model.variance + clutter_variance_ +
                    squared(profile_error * std::min(spot, settings_.full_scale_dn)) +
                    squared(width_error_px * amplitude * profile.by_radius);
    const double normalised = squared(model.residual) / model.allowed;
    // Other lights only add: what is darker than the model is believed.
    model.trust = model.residual > 0.0 ? squared(scale_ / (scale_ + normalised)) : 1.0;
    model.weight = model.censored ? 0.0 : model.trust / model.allowed;
    return true;
  }

  /// From the nearest point of the path to a pixel, both from the middle of the spot.
  [[nodiscard]] Vec2 off_path(const Vec2& from_middle) const {
    return from_middle - along_ * std::clamp(from_middle.dot(along_), -x_[5], x_[5]);
  }

  template <typename Visit>
  void for_each(Visit&& visit) const {
    const double reach = std::min(x_[3] + reach_px_, static_cast<double>(max_half_px));
    const int half = static_cast<int>(reach + x_[5]) + 1;
    const int uc = static_cast<int>(x_[0] + 0.5);
    const int vc = static_cast<int>(x_[1] + 0.5);
    Model model;
    for (int v = std::max(vc - half, 0); v <= std::min(vc + half, image_.height - 1); ++v) {
      for (int u = std::max(uc - half, 0); u <= std::min(uc + half, image_.width - 1); ++u) {
        if (model_at(u, v, squared(reach), model)) visit(model);
      }
    }
  }

  /// Normal equations at the present model, with the background's prior; sets the scale of outliers for the next.
  void accumulate(SpotNormal& normal, double most) {
    double sum = 0.0;
    double weights = 0.0;
    used_ = 0.0;
    for_each([&](const Model& model) {
      if (model.censored) return;
      normal.add(model.row, model.residual, model.weight);
      sum += model.weight * squared(model.residual);
      weights += model.weight * model.allowed;
      used_ += 1.0;
    });
    const Vector background{0.0, 0.0, 0.0, 0.0, 1.0, 0.0};
    const double variance = squared(ring_.scatter) + noise_variance(ring_.level);
    normal.add(background, ring_.level - x_[4], 1.0 / variance);
    if (weights > 0.0) scale_ = std::clamp(9.0 * sum / weights, least_scale, most);
  }

  [[nodiscard]] Status finish(SpotFit& fit) {
    SpotNormal normal;
    accumulate(normal, first_scales.back());
    normal.matrix[5][5] += 1.0 / squared(path_error_px);
    if (used_ < 6.0 || !normal.factorise()) return Status::rank_deficient;
    const Vector along_u = normal.solve({1.0, 0.0, 0.0, 0.0, 0.0, 0.0});
    const Vector along_v = normal.solve({0.0, 1.0, 0.0, 0.0, 0.0, 0.0});
    double noise = 0.0;
    double seen = 0.0;
    double squares = 0.0;
    double signal = 0.0;
    double full = 0.0;
    double flux = 0.0;
    for_each([&](const Model& model) {
      flux += std::max(model.level - x_[4], 0.0);
      if (model.censored) return;
      double a = 0.0;
      double b = 0.0;
      for (std::size_t k = 0; k < parameters; ++k) {
        a += along_u[k] * model.row[k];
        b += along_v[k] * model.row[k];
      }
      const double leverage = squared(model.weight) * (a * a + b * b);
      noise += leverage * model.variance;
      seen += leverage * squared(model.residual);
      const double gradient = squared(model.row[0]) + squared(model.row[1]);
      squares += gradient * model.trust * squared(model.residual);
      signal += gradient * model.trust;
      full += gradient;
    });
    const double height = std::min(x_[2] * spot_profile(0.0, x_[3], inverse_s_).level, settings_.full_scale_dn - x_[4]);
    fit.uv_px = Vec2(x_[0], x_[1]);
    fit.flux_dn = flux;
    fit.background_dn = x_[4];
    fit.amplitude_dn = x_[2];
    fit.half_width_px = x_[3];
    fit.half_length_px = x_[5];
    fit.misfit = signal > 0.0 && height > 0.0 ? std::sqrt(squares / signal) / height : 1.0;
    fit.support = full > 0.0 ? signal / full : 0.0;
    // Residuals scatter by chance too: only what is beyond twice the noise counts. Where other lights cover part of the
    // flank, what is left of it is pulled as well; the fourth power is measured on two rendered sequences.
    const double excess = std::max(seen - 2.0 * noise, 0.0) / squared(squared(std::max(fit.support, 0.1)));
    fit.sigma_px =
        std::sqrt(0.5 * noise + 0.5 * squared(settings_.sigma_clutter) * excess + squared(settings_.sigma_floor_px));
    const bool bright = height >= 0.5 * settings_.min_contrast * settings_.full_scale_dn;
    // From the far side of the flank alone a centre outside the image is a guess.
    const bool inside = x_[0] > -0.5 && x_[1] > -0.5 && x_[0] < image_.width - 0.5 && x_[1] < image_.height - 0.5;
    return bright && inside ? Status::ok : Status::no_convergence;
  }

  const GreyImageView<Pixel>& image_;
  const SpotSettings& settings_;
  const SpotSeed& seed_;
  double inverse_s_;
  LightRing ring_{};
  double clutter_variance_ = 0.0;
  double reach_px_ = 0.0;
  Vec2 along_ = Vec2::Zero();  // direction of the path; zero for a spot at rest
  Vector x_{};
  double scale_ = 1.0;  // normalised square residual at which the weight has fallen to a quarter
  double used_ = 0.0;   // pixels
};

}  // namespace

Status fit_spot(const ImageView& image, const SpotSettings& settings, const SpotSeed& seed, SpotFit& fit) {
  fit = SpotFit{};
  return Fit<std::uint8_t>(image, settings, seed).run(fit);
}
Status fit_spot(const ImageView16& image, const SpotSettings& settings, const SpotSeed& seed, SpotFit& fit) {
  fit = SpotFit{};
  return Fit<std::uint16_t>(image, settings, seed).run(fit);
}

}  // namespace relnav::vision
