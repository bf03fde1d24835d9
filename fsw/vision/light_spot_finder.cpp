#include "fsw/vision/light_spot_finder.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "fsw/vision/spot_fit.hpp"

namespace relnav::vision {
namespace {

/// Whether two fits are of one spot.
bool same_place(const LightSpot& a, const LightSpot& b) {
  constexpr double distance_px = 1.5;
  return (a.uv_px - b.uv_px).squaredNorm() < distance_px * distance_px;
}

/// A light at rest, unless one that moved in the exposure fits clearly better: a glint beside a light makes the region longer
/// as well, and a path then follows the glint.
template <typename Pixel>
Status fit_candidate(const GreyImageView<Pixel>& image, const SpotSettings& settings, const SpotCandidate& candidate,
                     SpotFit& fit) {
  constexpr double good = 0.1;
  constexpr double clearly_better = 0.75;
  constexpr double least_path_px = 1.0;  // half length, by the region's moments: below, the middle hardly differs
  // A round spot on one end of a path fits well what it sees and does not weigh down.
  const auto unexplained = [&](const SpotFit& f) {
    const double r = f.half_width_px + 0.5 * settings.psf_sigma_px;
    const double area = r * (pi * r + 4.0 * f.half_length_px);
    const double share = std::min(1.0, area / candidate.area_px);
    return f.misfit / std::max(f.support * f.support * share * share, 0.01);
  };
  SpotSeed seed;
  seed.uv_px = candidate.uv_px;
  seed.area_px = candidate.area_px;
  seed.peak_dn = candidate.peak_dn;
  const Status status = fit_spot(image, settings, seed, fit);
  if (status == Status::ok && unexplained(fit) < good) return status;
  seed.half_streak_px = candidate.half_streak_px;
  SpotFit moved;
  if (!(seed.half_streak_px.squaredNorm() > least_path_px * least_path_px) ||
      fit_spot(image, settings, seed, moved) != Status::ok)
    return status;
  if (status == Status::ok && unexplained(moved) > clearly_better * unexplained(fit)) return status;
  fit = moved;
  return Status::ok;
}

}  // namespace

Status LightSpotFinder::configure(const SpotSettings& settings) {
  const Status status = settings.check();
  if (status != Status::ok) return status;
  settings_ = settings;
  configured_ = true;
  return Status::ok;
}

Status LightSpotFinder::find(const ImageView& image, LightSpots& spots, SpotReport& report) {
  const std::array<PixelRegion, 1> whole{};
  return search(image, whole, 0, spots, report);
}
Status LightSpotFinder::find(const ImageView16& image, LightSpots& spots, SpotReport& report) {
  const std::array<PixelRegion, 1> whole{};
  return search(image, whole, 0, spots, report);
}
Status LightSpotFinder::find(const ImageView& image, std::span<const PixelRegion> windows, int margin_px,
                             LightSpots& spots, SpotReport& report) {
  return search(image, windows, margin_px, spots, report);
}
Status LightSpotFinder::find(const ImageView16& image, std::span<const PixelRegion> windows, int margin_px,
                             LightSpots& spots, SpotReport& report) {
  return search(image, windows, margin_px, spots, report);
}

template <typename Pixel>
Status LightSpotFinder::search(const GreyImageView<Pixel>& image, std::span<const PixelRegion> windows, int margin_px,
                               LightSpots& spots, SpotReport& report) {
  spots.clear();
  report = SpotReport{};
  if (!configured_) return Status::not_configured;
  if (!image.is_valid()) return Status::invalid_argument;
  candidates_.clear();
  RegionCounts counts;
  for (const PixelRegion& window : windows) {
    const PixelRegion region{std::max(window.u0_px, 0), std::max(window.v0_px, 0), std::min(window.u1_px, image.width),
                             std::min(window.v1_px, image.height)};
    if (region.u0_px >= region.u1_px || region.v0_px >= region.v1_px) continue;
    threshold_.measure(image, region, settings_);
    const PixelRegion core{window.u0_px + margin_px, window.v0_px + margin_px, window.u1_px - margin_px,
                           window.v1_px - margin_px};
    regions_.find(image, region, core, settings_, threshold_, candidates_, counts);
  }
  report.found = candidates_.found();
  report.overflow = report.found - static_cast<std::int32_t>(candidates_.kept().size());
  report.rejected = counts.rejected;
  report.dropped_runs = counts.dropped_runs;
  report.dropped_regions = counts.dropped_regions;
  report.raised = counts.raised;
  fit_candidates(image, spots, report);
  return Status::ok;
}

template <typename Pixel>
void LightSpotFinder::fit_candidates(const GreyImageView<Pixel>& image, LightSpots& spots, SpotReport& report) const {
  for (const SpotCandidate& candidate : candidates_.kept()) {
    SpotFit fit;
    if (fit_candidate(image, settings_, candidate, fit) != Status::ok || fit.misfit > settings_.max_misfit ||
        fit.support < settings_.min_support) {
      ++report.misfits;
      continue;
    }
    const LightSpot spot{fit.uv_px, fit.sigma_px, fit.flux_dn / settings_.full_scale_dn, candidate.area_px,
                         candidate.saturated_px};
    const bool repeated =
        std::any_of(spots.begin(), spots.end(), [&](const LightSpot& other) { return same_place(other, spot); });
    if (repeated || spots.push_back(spot) != Status::ok) {
      ++report.repeated;
      continue;
    }
    for (std::size_t i = spots.size() - 1; i > 0 && spots[i].flux > spots[i - 1].flux; --i) {
      std::swap(spots[i], spots[i - 1]);
    }
  }
}

}  // namespace relnav::vision
