#pragma once
#include "fsw/estimation/pose_least_squares.hpp"
#include "fsw/estimation/spot_tracking.hpp"

namespace relnav {

struct TearSettings {
  double gate_chi2 = 16.0;  ///< two degrees of freedom, 3e-4: of a spot that stands where a marker is said to be
  double moved_chi2 =
      64.0;  ///< of a single marker's motion since the frame before: less does not tell two moments apart
  double model_sigma_px = 0.1;       ///< of spots and markers, added to where the filter says that a marker was
  double prediction_sigma_px = 0.7;  ///< and to where it says that one is now: targets do not move quite like that
  int least_late = 2;                ///< spots of the frame before; a single one is an outlier like any other
  double alarm_z = 4.0;              ///< chi-square of a side beyond so many sigmas is no noise
};

/// Where the image of a camera changes from one moment to another.
struct Tear {
  std::uint16_t camera = 0;
  double row_px = 0.0;      ///< v, halfway between the nearest spots of either moment
  bool late_below = true;   ///< larger v is of the frame before; else smaller v is
  std::uint16_t late = 0;   ///< spots of the frame before; 0: there is no tear
  std::uint16_t fresh = 0;  ///< spots of this one
  [[nodiscard]] bool exists() const { return late > 0; }
};

/// Whether the image of `camera` was put together from two frames: rows on one side still show the frame before (a buffer that
/// was read while it was written). On that side markers have a spot where they stood then, on the other where they are
/// expected now; markers that have hardly moved, and those with a spot at both places or at neither, say nothing. `before`
/// and `now`: markers expected at the two times, with the covariance of the prediction; `spots`: of the camera. A tear that
/// lies above or below all markers cannot be told from a late frame.
[[nodiscard]] bool find_tear(const ExpectedMarkers& before, const ExpectedMarkers& now, const LightSpots& spots,
                             std::uint16_t camera, const TearSettings& settings, Tear& out);

/// A pose left out so many observations of `camera` that its image may be torn.
[[nodiscard]] bool has_outliers(const PoseObservations& observations, const ObservationMask& used, std::uint16_t camera,
                                const TearSettings& settings);

/// find_tear() where the motion is too small for single spots to tell, or known too loosely, and a pose has_outliers(). The
/// side of a row counts as late that as a whole stands where its markers were in the frame before although they should have
/// moved, if two spots at least on the other side do not; of several rows, the one with most spots that do (each for gate_chi2
/// less its own).
[[nodiscard]] bool find_tear_by_outliers(const ExpectedMarkers& before, const ExpectedMarkers& now,
                                         const SpotAssignment& found, const ObservationMask& used, std::uint16_t camera,
                                         const TearSettings& settings, Tear& out);

/// Takes the observations of the late side out.
void drop_late_side(const Tear& tear, SpotAssignment& found);

}  // namespace relnav
