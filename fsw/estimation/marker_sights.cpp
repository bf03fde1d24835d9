#include "fsw/estimation/marker_sights.hpp"

#include <algorithm>

namespace relnav {

void MarkerSights::begin(const PoseObservations& observations) {
  restart();
  for (const PoseObservation& o : observations) sights_[o.camera][o.feature] = {needed + 1, 0.0};
}

void MarkerSights::mark(ExpectedMarkers& markers) const {
  for (ExpectedMarker& m : markers) {
    const Sight& sight = sights_[m.camera][m.feature];
    m.in_sight = sight.frames >= needed;
    m.flux = sight.flux;
  }
}

void MarkerSights::record(std::uint16_t camera, const ExpectedMarkers& expected, const SpotAssignment& agreed) {
  const OfCamera before = sights_[camera];
  OfCamera& now = sights_[camera];
  now = {};
  for (const ExpectedMarker& m : expected) {
    const Sight& had = before[m.feature];
    if (had.frames > lost) now[m.feature] = {static_cast<std::uint8_t>(had.frames - lost), had.flux};
  }
  for (std::size_t i = 0; i < agreed.marker.size(); ++i) {
    const ExpectedMarker& m = expected[agreed.marker[i]];
    const int frames = before[m.feature].frames + 1;
    now[m.feature] = {static_cast<std::uint8_t>(std::min<int>(needed + 1, frames)), agreed.flux[i]};
  }
}

}  // namespace relnav
