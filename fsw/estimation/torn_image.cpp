#include "fsw/estimation/torn_image.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace relnav {
namespace {

/// Rows between which spots lie.
struct Extent {
  double least_px = 1e300;
  double most_px = -1e300;
  std::uint16_t count = 0;
  void add(double v_px) {
    least_px = std::min(least_px, v_px);
    most_px = std::max(most_px, v_px);
    ++count;
  }
};

template <typename Marker>
const ExpectedMarker* find_marker(const ExpectedMarkers& markers, const Marker& like) {
  for (const ExpectedMarker& m : markers) {
    if (m.feature == like.feature && m.camera == like.camera) return &m;
  }
  return nullptr;
}

/// An observation held against where its marker was in the frame before.
struct Held {
  double v_px = 0.0;
  double chi2 = 0.0;   ///< of the spot's offset from there
  double moved = 0.0;  ///< of the marker's motion since
};
using HeldByRow = BoundedVector<Held, config::max_target_features>;

/// Rows rise.
void insert(const Held& held, HeldByRow& all) {
  if (all.push_back(held) != Status::ok) return;  // as many places as markers: cannot be
  for (std::size_t i = all.size() - 1; i > 0 && all[i].v_px < all[i - 1].v_px; --i) std::swap(all[i], all[i - 1]);
}

/// Of all.begin() + first, `count` of them.
struct Side {
  Extent rows;
  double chi2 = 0.0;
  double moved = 0.0;
  Side(const HeldByRow& all, std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      rows.add(all[i].v_px);
      chi2 += all[i].chi2;
      moved += all[i].moved;
    }
  }
  [[nodiscard]] bool stands_still(double alarm_z) const { return chi2 < most_of_noise(alarm_z); }
  [[nodiscard]] bool should_have_moved(double alarm_z) const { return moved > most_of_noise(alarm_z); }

 private:
  /// Chi-square has 2 degrees of freedom a spot: mean 2 n, variance 4 n.
  [[nodiscard]] double most_of_noise(double alarm_z) const {
    const double n = rows.count;
    return 2.0 * n + alarm_z * std::sqrt(4.0 * n);
  }
};

/// False: the rows of the two overlap.
bool set_tear(std::uint16_t camera, const Extent& late, const Extent& fresh, Tear& out) {
  const bool late_below = late.least_px > fresh.most_px;
  if (!late_below && !(late.most_px < fresh.least_px)) return false;
  out.camera = camera;
  out.row_px = 0.5 * (late_below ? late.least_px + fresh.most_px : late.most_px + fresh.least_px);
  out.late_below = late_below;
  out.late = late.count;
  out.fresh = fresh.count;
  return true;
}

/// The spot that stands nearest to a marker.
struct Nearest {
  std::size_t spot = config::max_spots;  ///< none
  double offset2_px2 = 1e300;
  [[nodiscard]] bool any() const { return spot < config::max_spots; }
};

/// `sigma_px`: added to the prediction of the marker.
Nearest spot_at(const LightSpots& spots, const ExpectedMarker& marker, double sigma_px, double chi2) {
  Nearest nearest;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Vec2 d = spots[i].uv_px - marker.uv_px;
    const double offset2 = d.squaredNorm();
    const double noise2 = sigma_px * sigma_px + spots[i].sigma_px * spots[i].sigma_px;
    if (offset2 < nearest.offset2_px2 && mahalanobis2(d, marker.S_px2, noise2) < chi2) nearest = {i, offset2};
  }
  return nearest;
}

}  // namespace

bool find_tear(const ExpectedMarkers& before, const ExpectedMarkers& now, const LightSpots& spots, std::uint16_t camera,
               const TearSettings& settings, Tear& out) {
  Extent late;
  Extent fresh;
  for (const ExpectedMarker& here : now) {
    if (here.camera != camera || !here.in_sight) continue;
    const ExpectedMarker* then = find_marker(before, here);
    if (then == nullptr) continue;
    const Vec2 motion = here.uv_px - then->uv_px;
    if (mahalanobis2(motion, then->S_px2, settings.model_sigma_px * settings.model_sigma_px) < settings.moved_chi2)
      continue;
    const Nearest old = spot_at(spots, *then, settings.model_sigma_px, settings.gate_chi2);
    const Nearest young = spot_at(spots, here, settings.prediction_sigma_px, settings.gate_chi2);
    if (old.any() && young.any() && old.spot != young.spot) continue;
    // Where prediction is loose the same spot may be at either place: the nearer one then.
    if (old.any() && (!young.any() || old.offset2_px2 < young.offset2_px2)) {
      late.add(spots[old.spot].uv_px(1));
    } else if (young.any()) {
      fresh.add(spots[young.spot].uv_px(1));
    }
  }
  if (late.count < settings.least_late || fresh.count == 0) return false;
  return set_tear(camera, late, fresh, out);
}

bool has_outliers(const PoseObservations& observations, const ObservationMask& used, std::uint16_t camera,
                  const TearSettings& settings) {
  int left_out = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (observations[i].camera == camera && !used[i]) ++left_out;
  }
  return left_out >= settings.least_late;
}

bool find_tear_by_outliers(const ExpectedMarkers& before, const ExpectedMarkers& now, const SpotAssignment& found,
                           const ObservationMask& used, std::uint16_t camera, const TearSettings& settings, Tear& out) {
  if (!has_outliers(found.observations, used, camera, settings)) return false;
  const auto least = static_cast<std::size_t>(settings.least_late);
  HeldByRow all;
  for (std::size_t i = 0; i < found.observations.size(); ++i) {
    const PoseObservation& o = found.observations[i];
    const ExpectedMarker* then = o.camera == camera ? find_marker(before, o) : nullptr;
    if (then == nullptr) continue;
    const double noise2 = o.sigma_px * o.sigma_px + settings.model_sigma_px * settings.model_sigma_px;
    const Vec2 motion = now[found.marker[i]].uv_px - then->uv_px;
    insert({o.uv_px(1), mahalanobis2(o.uv_px - then->uv_px, then->S_px2, noise2),
            mahalanobis2(motion, then->S_px2, noise2)},
           all);
  }
  bool any = false;
  double most = 0.0;
  for (std::size_t late = all.size(); late >= least; --late) {
    const std::size_t fresh = all.size() - late;
    if (fresh < least) continue;
    for (const bool late_below : {true, false}) {
      const Side old(all, late_below ? fresh : 0, late);
      const Side young(all, late_below ? 0 : late, fresh);
      const double score = settings.gate_chi2 * static_cast<double>(late) - old.chi2;
      if (score > most && old.should_have_moved(settings.alarm_z) && old.stands_still(settings.alarm_z) &&
          !young.stands_still(settings.alarm_z) && set_tear(camera, old.rows, young.rows, out)) {
        any = true;
        most = score;
      }
    }
  }
  return any;
}

void drop_late_side(const Tear& tear, SpotAssignment& found) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.observations.size(); ++i) {
    const PoseObservation o = found.observations[i];
    if (o.camera == tear.camera && (o.uv_px(1) > tear.row_px) == tear.late_below) continue;
    found.observations[kept] = o;
    found.flux[kept] = found.flux[i];
    found.marker[kept++] = found.marker[i];
  }
  found.observations.truncate(kept);
  found.flux.truncate(kept);
  found.marker.truncate(kept);
}

}  // namespace relnav
