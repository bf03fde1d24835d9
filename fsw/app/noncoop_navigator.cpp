#include "fsw/app/noncoop_navigator.hpp"

#include "fsw/app/filter_watch.hpp"
#include "fsw/app/stage_timer.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/math/chi_square.hpp"

namespace relnav::app {

Status NoncoopNavigator::configure(const NavigatorConfig& config, const CameraModel& camera) {
  const Status status = filter_.configure(config.filter, camera);
  if (status != Status::ok) return status;
  config_ = config;
  camera_ = camera;
  tracker_.configure(config.tracker);
  restart();
  return Status::ok;
}

void NoncoopNavigator::restart() {
  started_ = false;
  tracker_.clear();
}

Status NoncoopNavigator::find_corners(const vision::ImageView& image, std::size_t wanted,
                                      vision::CornerCandidates& candidates) {
  vision::FastOptions options;
  options.threshold = config_.fast_threshold;
  const vision::FastResult found = vision::detect_fast(image, options, corners_);
  // no_capacity is no fault here: the strongest corners of a busy image are what is wanted.
  if (found.status != Status::ok && found.status != Status::no_capacity) return found.status;
  return vision::select_corners(image, {corners_.data(), found.count}, {tracked_px_.data(), tracked_px_.size()}, wanted,
                                config_.spread, candidates);
}

Status NoncoopNavigator::start(const vision::ImageView& image, Time time, StepReport& report) {
  vision::CornerCandidates candidates;
  tracked_px_.clear();
  const Status status = find_corners(image, config::max_features, candidates);
  if (status != Status::ok) return status;
  if (candidates.size() < config_.min_start_features) return Status::too_few_features;

  // Line of sight to the middle of what is seen, and its half width, both as tangents. Of the two axes of the scatter the
  // shorter one counts: solar panels and booms stretch the other far beyond the depth of the body.
  Vec2 sum = Vec2::Zero();
  Mat2 sum2 = Mat2::Zero();
  double count = 0.0;
  for (const CornerCandidate& c : candidates) {
    Vec3 ray_C;
    if (camera_.unproject(Vec2(c.u_px, c.v_px), ray_C) != Status::ok || !(ray_C.z() > 0.0)) continue;
    const Vec2 xy = ray_C.head<2>() / ray_C.z();
    sum += xy;
    sum2 += xy * xy.transpose();
    count += 1.0;
  }
  if (count < static_cast<double>(config_.min_start_features)) return Status::too_few_features;
  const Vec2 mean = sum / count;
  const Mat2 scatter = sum2 / count - mean * mean.transpose();
  const double half_sum = 0.5 * (scatter(0, 0) + scatter(1, 1));
  const double half_difference = 0.5 * (scatter(0, 0) - scatter(1, 1));
  const double root = std::sqrt(half_difference * half_difference + scatter(0, 1) * scatter(0, 1));
  const double half_extent = std::sqrt(std::max(0.0, 2.0 * (half_sum - root)));
  filter_.start(time, Vec3(mean(0), mean(1), 1.0).normalized(), half_extent);
  started_ = true;
  plant(image, candidates, report);
  filter_.add_scale_uncertainty();
  return Status::ok;
}

void NoncoopNavigator::add_features(const vision::ImageView& image, StepReport& report) {
  if (!filter_.has_room()) return;
  const std::size_t room = config::max_features - filter_.state().features().size();
  vision::CornerCandidates candidates;
  if (find_corners(image, room, candidates) != Status::ok) return;
  plant(image, candidates, report);
}

void NoncoopNavigator::plant(const vision::ImageView& image, const vision::CornerCandidates& candidates,
                             StepReport& report) {
  for (const CornerCandidate& c : candidates) {
    const Expected<SlotHandle> slot = filter_.add_feature(Vec2(c.u_px, c.v_px));
    if (!slot) continue;
    if (tracker_.store(slot.value(), image, c.u_px, c.v_px) != Status::ok) continue;  // never found, so soon dropped
    FeatureReport r;
    r.index = slot.value().index;
    r.generation = slot.value().generation;
    r.use = FeatureUse::added;
    r.measured_px = r.predicted_px = Vec2(c.u_px, c.v_px);
    if (report.feature_reports.push_back(r) != Status::ok) return;
  }
}

void NoncoopNavigator::report_matches(const FilterUpdate& update, StepReport& report) const {
  // Matches come in the order of the predictions, each prediction has at most one.
  std::size_t m = 0;
  for (const FeaturePrediction& p : predictions_) {
    FeatureReport r;
    r.index = p.slot.index;
    r.generation = p.slot.generation;
    r.predicted_px = p.uv_px;
    r.use = FeatureUse::not_found;
    if (m < matches_.size() && matches_[m].slot == p.slot) {
      r.measured_px = matches_[m].uv_px;
      switch (update.verdict[m]) {
        case MatchVerdict::low_innovation: r.use = FeatureUse::low_innovation; break;
        case MatchVerdict::high_innovation: r.use = FeatureUse::high_innovation; break;
        case MatchVerdict::incompatible:
        case MatchVerdict::outlier: r.use = FeatureUse::rejected; break;
      }
      ++m;
    }
    if (report.feature_reports.push_back(r) != Status::ok) return;
  }
}

Status NoncoopNavigator::process(std::span<const CameraImage> images, Time time, StepReport& report) {
  const auto* grey = images.size() == 1 ? std::get_if<vision::ImageView>(&images[0]) : nullptr;
  if (grey == nullptr) return Status::invalid_argument;
  const vision::ImageView& image = *grey;
  report.estimator = telemetry::Estimator::inverse_depth_ekf;
  report.feature_reports.clear();
  report.matched = 0;
  report.inliers = 0;
  StageTimer timer(clock_);
  if (!started_) {
    const Status status = start(image, time, report);
    report.times.detect_ns = timer.lap();
    if (status != Status::ok) return status;
    report.state = filter_.output();
    report.features = static_cast<std::uint16_t>(filter_.state().features().size());
    return Status::ok;
  }

  Status status = filter_.predict(time);
  if (status != Status::ok) return status;
  filter_.predict_features(predictions_);
  report.times.predict_ns = timer.lap();

  status = tracker_.match(image, predictions_, matches_, match_report_);
  report.times.match_ns = timer.lap();
  if (status != Status::ok) return status;

  const FilterUpdate update = filter_.update(matches_);
  report.times.update_ns = timer.lap();
  report.matched = static_cast<std::uint16_t>(matches_.size());
  report.inliers = static_cast<std::uint16_t>(update.inliers);
  report.test_ratio = update.rows > 0 ? update.nis / chi2_99(update.rows) : 0.0;
  report_matches(update, report);

  BoundedVector<SlotHandle, config::max_features> dropped;
  filter_.drop_spent_features(dropped);
  for (const SlotHandle slot : dropped) {
    if (tracker_.drop(slot) != Status::ok) continue;  // its patch could not be stored: nothing to forget
  }
  tracked_px_.clear();
  for (const FeaturePrediction& p : predictions_) {
    if (tracked_px_.push_back(p.uv_px) != Status::ok) break;
  }
  add_features(image, report);
  report.times.detect_ns = timer.lap();
  report.state = filter_.output();
  report.features = static_cast<std::uint16_t>(filter_.state().features().size());
  return update.status;
}

Status NoncoopNavigator::check() const { return check_variances(filter_.state()); }

}  // namespace relnav::app
