#pragma once
#include "fsw/estimation/filter_state.hpp"
#include "fsw/estimation/relative_state.hpp"
#include "fsw/estimation/start_adjustment.hpp"

namespace relnav {

/// Sets the filter of a rigid target to an adjusted start, state and full covariance, `now_s` after the first frame. Every
/// feature keeps its slot and becomes an inverse-depth feature again, anchored at its first sight; each has its track.
void take_over_start(const StartAdjustment::Result& start, double now_s, AttitudeChartKind chart, FilterState& state);

/// While the start is undecided: mean and covariance of the mixture of hypotheses instead of those of the best one. Until
/// the data decide, the answer lies between the hypotheses and says so.
void blend_start_hypotheses(const StartAdjustment::Result& start, double now_s, RelativeState& out);

}  // namespace relnav
