#include "fsw/vision/feature_tracker.hpp"

namespace relnav::vision {

Status FeatureTracker::store(SlotHandle slot, const ImageView& image, int u_px, int v_px) {
  if (slot.index >= entries_.size()) return Status::invalid_argument;
  Entry& entry = entries_[slot.index];
  entry.slot = slot;
  const Status status = capture_patch(image, u_px, v_px, entry.patch);
  entry.stored = status == Status::ok;
  return status;
}

Status FeatureTracker::drop(SlotHandle slot) {
  if (!holds(slot)) return Status::stale_handle;
  entries_[slot.index].stored = false;
  return Status::ok;
}

void FeatureTracker::clear() {
  for (Entry& entry : entries_) entry.stored = false;
}

bool FeatureTracker::holds(SlotHandle slot) const {
  return slot.index < entries_.size() && entries_[slot.index].stored && entries_[slot.index].slot == slot;
}

MatchOutcome FeatureTracker::match_one(const ImageView& image, const FeaturePrediction& prediction, FeatureMatch& match,
                                       MatchReport& report) {
  if (!holds(prediction.slot)) return MatchOutcome::no_patch;
  const Status warped = warp_patch(entries_[prediction.slot.index].patch, prediction.warp, options_.warp, warped_);
  if (warped == Status::not_finite) return MatchOutcome::bad_prediction;
  if (warped != Status::ok || warped_.variance_q6 <= 0) return MatchOutcome::not_matchable;

  SearchResult found;
  const Status searched = search(warped_, image, prediction.uv_px, prediction.S_px2, options_.search, scratch_, found);
  report.positions += static_cast<std::uint32_t>(found.positions);
  report.capped += found.capped ? 1U : 0U;
  report.on_lattice += found.on_lattice ? 1U : 0U;
  if (searched == Status::outside_domain) return MatchOutcome::outside_image;
  if (searched != Status::ok) return MatchOutcome::bad_prediction;
  if (!(found.score >= options_.min_score)) return MatchOutcome::low_score;
  if (options_.max_second_ratio < 1.0 && found.second_score > options_.max_second_ratio * found.score) {
    return MatchOutcome::ambiguous;
  }

  SubpixelResult refined;
  const Status status = refine(warped_, image, found.u_px, found.v_px, found.score, options_.subpixel, refined);
  report.iterations += static_cast<std::uint32_t>(refined.iterations);
  if (status != Status::ok) return MatchOutcome::not_refined;
  report.quadratic += refined.quadratic ? 1U : 0U;
  match = {prediction.slot, refined.uv_px, refined.sigma_px, found.score};
  return MatchOutcome::matched;
}

Status FeatureTracker::match(const ImageView& image, const FeaturePredictions& predictions, FeatureMatches& matches,
                             MatchReport& report) {
  matches.clear();
  report = MatchReport{};
  if (!image.is_valid()) return Status::invalid_argument;
  for (const FeaturePrediction& prediction : predictions) {
    FeatureMatch match;
    const MatchOutcome outcome = match_one(image, prediction, match, report);
    static_cast<void>(report.outcomes.push_back(outcome));
    if (outcome != MatchOutcome::matched) continue;
    ++report.matched;
    static_cast<void>(matches.push_back(match));
  }
  return Status::ok;
}

}  // namespace relnav::vision
