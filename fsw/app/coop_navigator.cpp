#include "fsw/app/coop_navigator.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/app/stage_timer.hpp"
#include "fsw/attitude/so3.hpp"

namespace relnav::app {
namespace {

/// Window about an expected marker: so many sigmas of its prediction, what a glint beside it moves the middle of a region, and
/// surroundings from which the threshold is taken.
constexpr double window_sigmas = 4.0;
constexpr double pull_px = 4.0;
constexpr int surroundings_px = 8;
constexpr double largest_window_px = 80.0;
constexpr double image_border_px = 2.0;
/// Frames in which the spots of one are searched before those of a later one take their place: what is found has to be met
/// again, and nothing is known of its motion yet.
constexpr int frames_searched = 4;
/// Age of the spots from which on nothing found in them would be met again, be the frames as rare as they may.
constexpr Duration longest_search{10'000'000'000};
/// What finding the spots of a whole picture takes, and more for each of them, in three-point problems.
constexpr int work_of_a_picture = 1000;
constexpr int work_of_a_spot = 22;
/// Mean size of the windows, of six at least, from which on the whole picture takes less: they overlap, and what is found
/// in them is fitted more closely.
constexpr int wide_window_px = 2000;
constexpr std::size_t least_windows = 6;
/// Frames in which a tear, once found, is taken for granted.
constexpr int most_torn_frames = 10;

bool are_wide(std::span<const vision::PixelRegion> windows) {
  int covered_px = 0;
  for (const vision::PixelRegion& w : windows) covered_px += (w.u1_px - w.u0_px) * (w.v1_px - w.v0_px);
  return covered_px > wide_window_px * static_cast<int>(std::max(windows.size(), least_windows));
}

vision::SpotSettings in_levels_of(vision::SpotSettings settings, double full_scale_dn) {
  const double levels = full_scale_dn / settings.full_scale_dn;
  settings.full_scale_dn = full_scale_dn;
  settings.read_noise_dn *= levels;
  settings.gain_electrons_dn /= levels;
  return settings;
}

}  // namespace

Status CoopNavigatorConfig::check() const {
  const bool parts = spots.check() == Status::ok && search.check() == Status::ok && tracking.check() == Status::ok &&
                     filter.check() == Status::ok;
  const std::size_t markers = target.features.size();
  const bool own = markers >= least_markers && markers <= most_markers && sensor_bits >= 8 && sensor_bits <= 16 &&
                   min_observations >= 4 && phi_CT_expected.allFinite() && expected_cone_rad >= 0.0;
  return parts && own ? Status::ok : Status::invalid_argument;
}

vision::SpotSettings CoopNavigatorConfig::coarse_spots() const {
  vision::SpotSettings coarse = spots;
  coarse.converged_px = std::max(spots.converged_px, 0.05);
  return coarse;
}

Status CoopNavigator::configure(const CoopNavigatorConfig& config, const CameraRig& rig) {
  if (config.check() != Status::ok) return Status::invalid_argument;
  const Status status = estimator_.configure(config.estimator, rig, config.target);
  if (status != Status::ok) return status;
  config_ = config;
  filter_.configure(config.filter);
  restart();
  return Status::ok;
}

void CoopNavigator::restart() {
  filter_.restart();
  restart_search();
  sights_.restart();
  torn_.fill({});
}

void CoopNavigator::restart_search() {
  acquisition_.restart();
  uses_expected_ = false;
  search_ = Search::none;
}

Status CoopNavigator::find_spots(const CameraImage& image, std::span<const vision::PixelRegion> windows,
                                 LightSpots& spots, StepReport& report) {
  spots.clear();
  vision::SpotReport found;
  const auto find_in = [&](const auto& view, double full_scale_dn) {
    const bool anywhere = windows.empty() || are_wide(windows);
    const vision::SpotSettings& settings = anywhere ? config_.coarse_spots() : config_.spots;
    Status status = finder_.configure(in_levels_of(settings, full_scale_dn));
    if (status != Status::ok) return status;
    return anywhere ? finder_.find(view, spots, found) : finder_.find(view, windows, surroundings_px, spots, found);
  };
  Status status = Status::ok;
  if (const auto* grey = std::get_if<vision::ImageView>(&image)) {
    status = find_in(*grey, config_.spots.full_scale_dn);
  } else if (const auto* deep = std::get_if<vision::ImageView16>(&image)) {
    status = find_in(*deep, (1 << config_.sensor_bits) - 1);
  }
  report.dropped += found.overflow + found.dropped_runs + found.dropped_regions;
  return status;
}

Status CoopNavigator::process(std::span<const CameraImage> images, Time time, StepReport& report) {
  const std::size_t cameras = estimator_.rig().size();
  if (images.size() != cameras) return Status::invalid_argument;
  report.estimator =
      cameras == 2 ? telemetry::Estimator::stereo_least_squares : telemetry::Estimator::mono_least_squares;
  return filter_.has_started() ? track(images, time, report) : acquire(images, time, report);
}

Status CoopNavigator::acquire(std::span<const CameraImage> images, Time time, StepReport& report) {
  // After a gap, or on a new time base, the spots are of no use.
  const bool is_of_use = looked_at_ < time && time - looked_at_ <= longest_search;
  if (search_ == Search::found && is_of_use) {
    begin_filter();
    return track(images, time, report);
  }
  const bool goes_on = search_ == Search::running && is_of_use && (searches_left_ > 0 || acquisition_.is_weighing());
  const Status status = goes_on ? search(config_.search.max_hypotheses, report) : look(images, time, report);
  report.matched = 0;
  for (std::size_t c = 0; c < images.size(); ++c) {
    report.matched = static_cast<std::uint16_t>(report.matched + spots_[c].size());
  }
  return status;
}

Status CoopNavigator::look(std::span<const CameraImage> images, Time time, StepReport& report) {
  StageTimer timer(clock_);
  search_ = Search::none;
  for (std::size_t c = 0; c < images.size(); ++c) {
    const Status status = find_spots(images[c], {}, spots_[c], report);
    if (status != Status::ok) return status;
  }
  acquisition_.change_spots();
  search_ = Search::running;
  searches_left_ = frames_searched;
  looked_at_ = time;
  report.times.detect_ns += timer.lap();
  // What each picture has left of the work of a search.
  int budget = 0;
  bool sees = false;
  for (std::size_t c = 0; c < images.size(); ++c) {
    if (std::holds_alternative<std::monostate>(images[c])) continue;
    sees = true;
    budget += config_.search.max_hypotheses;
    budget -= work_of_a_picture + work_of_a_spot * static_cast<int>(spots_[c].size());
  }
  if (sees && budget <= 0) return Status::unfinished;
  const Status status = search(std::max(budget, 1), report);  // without any picture it says so
  return search_ == Search::found ? start(time, report) : status;
}

Status CoopNavigator::search(int budget, StepReport& report) {
  StageTimer timer(clock_);
  --searches_left_;
  const AttitudePrior expected{true, exp_so3(config_.phi_CT_expected), config_.expected_cone_rad};
  SpotSearchSettings settings = config_.search;
  settings.max_hypotheses = budget;
  const auto acquire_pose = [&](const AttitudePrior& prior) {
    return acquisition_.acquire(estimator_.rig(), config_.target, spots_, settings, prior, acquired_);
  };
  const int work = acquisition_.is_new() ? 0 : acquired_.effort.work;
  Status status = acquire_pose(uses_expected_ ? expected : AttitudePrior{});
  // What the spots alone leave open, or too close to chance, the expected attitude may decide.
  const bool undecided = status == Status::no_data || (status == Status::ok && acquired_.ambiguous);
  if (undecided && !uses_expected_ && config_.expected_cone_rad > 0.0) {
    acquisition_.restart();
    uses_expected_ = true;
    settings.max_hypotheses = budget - (acquired_.effort.work - work);
    status = settings.max_hypotheses > 0 ? acquire_pose(expected) : Status::unfinished;
  }
  report.times.match_ns += timer.lap();
  if (status == Status::unfinished) return status;
  restart_search();
  if (status == Status::no_data) return Status::too_few_features;  // of the spots, none make up the target
  if (status != Status::ok) return status;
  if (acquired_.ambiguous) return Status::ambiguous;
  search_ = Search::found;
  return Status::unfinished;
}

void CoopNavigator::begin_filter() {
  restart_search();
  filter_.start(looked_at_, acquired_.best.estimate);
  sights_.begin(acquired_.best.observations);
}

Status CoopNavigator::start(Time time, StepReport& report) {
  begin_filter();
  solution_.estimate = acquired_.best.estimate;
  solution_.used.fill(true);
  // As tracking sees it, for the report.
  markers_.clear();
  assignment_.observations = acquired_.best.observations;
  assignment_.marker.clear();
  for (std::size_t i = 0; i < assignment_.observations.size(); ++i) {
    const PoseObservation& o = assignment_.observations[i];
    ExpectedMarker m;
    m.feature = o.feature;
    m.camera = o.camera;
    m.uv_px = o.uv_px;
    if (markers_.push_back(m) != Status::ok ||
        assignment_.marker.push_back(static_cast<std::uint16_t>(i)) != Status::ok) {
      break;
    }
  }
  take(time, report);
  return Status::ok;
}

Status CoopNavigator::look_for_expected(std::span<const CameraImage> images, const Pose& pose, const Mat6& covariance,
                                        StepReport& report) {
  markers_.clear();
  BoundedVector<vision::PixelRegion, config::max_target_features> windows;
  for (std::size_t c = 0; c < images.size(); ++c) {
    spots_[c].clear();
    if (std::holds_alternative<std::monostate>(images[c])) continue;
    const std::size_t first = markers_.size();
    expect_markers(estimator_.rig(), config_.target, pose, covariance, static_cast<std::uint16_t>(c), image_border_px,
                   config_.tracking, markers_);
    windows.clear();
    for (std::size_t k = first; k < markers_.size(); ++k) {
      const ExpectedMarker& m = markers_[k];
      const double floor2 = config_.tracking.floor_sigma_px * config_.tracking.floor_sigma_px;
      const auto half = [&](int axis) {
        const double sigmas = window_sigmas * std::sqrt(m.S_px2(axis, axis) + floor2);
        return static_cast<int>(std::min(largest_window_px, sigmas + pull_px + surroundings_px));
      };
      const int u = static_cast<int>(m.uv_px(0) + 0.5);
      const int v = static_cast<int>(m.uv_px(1) + 0.5);
      const vision::PixelRegion window{std::max(0, u - half(0)), std::max(0, v - half(1)), u + half(0) + 1,
                                       v + half(1) + 1};
      if (windows.push_back(window) != Status::ok) break;
    }
    if (windows.empty()) continue;
    const Status status = find_spots(images[c], {windows.begin(), windows.size()}, spots_[c], report);
    if (status != Status::ok) return status;
  }
  sights_.mark(markers_);
  assign_spots(markers_, spots_, Markers::in_sight, config_.tracking, assignment_);
  return Status::ok;
}

void CoopNavigator::remember_markers(std::span<const CameraImage> images) {
  markers_before_.clear();
  const Pose pose = filter_.pose();
  const Mat6 covariance = filter_.pose_covariance();
  for (std::size_t c = 0; c < images.size(); ++c) {
    if (std::holds_alternative<std::monostate>(images[c])) continue;
    expect_markers(estimator_.rig(), config_.target, pose, covariance, static_cast<std::uint16_t>(c), image_border_px,
                   config_.tracking, markers_before_);
  }
}

void CoopNavigator::drop_late_spots(const Tear& tear, StepReport& report) {
  drop_late_side(tear, assignment_);
  torn_[tear.camera].tear = tear;
  report.tears[tear.camera] = tear;
}

void CoopNavigator::drop_torn_parts(std::span<const CameraImage> images, StepReport& report) {
  for (std::size_t c = 0; c < images.size(); ++c) {
    Tear tear;
    const auto camera = static_cast<std::uint16_t>(c);
    if (find_tear(markers_before_, markers_, spots_[c], camera, config_.tear, tear)) drop_late_spots(tear, report);
  }
}

bool CoopNavigator::drop_torn_outliers(std::span<const CameraImage> images, std::array<bool, config::max_cameras>& done,
                                       StepReport& report) {
  for (std::size_t c = 0; c < images.size(); ++c) {
    if (done[c]) continue;
    const Torn& torn = torn_[c];
    Tear tear = torn.tear;
    const auto camera = static_cast<std::uint16_t>(c);
    // With half of the markers gone in the frame before, nothing is known well enough to tell anew: the tear stays where it was
    // until the image is of one moment again. Not for ever: outliers may have another cause.
    const bool goes_on = torn.frames > 0 && torn.frames < most_torn_frames &&
                         has_outliers(assignment_.observations, solution_.used, camera, config_.tear);
    if (goes_on ||
        find_tear_by_outliers(markers_before_, markers_, assignment_, solution_.used, camera, config_.tear, tear)) {
      drop_late_spots(tear, report);
      done[c] = true;
      return true;
    }
  }
  return false;
}

Status CoopNavigator::update(std::span<const CameraImage> images, const Pose& predicted, Time time,
                             StepReport& report) {
  if (assignment_.observations.size() < config_.min_observations) return update_from_few(images, report);
  Status status = estimator_.solve(assignment_.observations, &predicted, solution_);
  std::array<bool, config::max_cameras> done{};
  for (std::size_t pass = 0; pass < images.size() && status == Status::ok; ++pass) {
    if (!drop_torn_outliers(images, done, report)) break;
    solution_.used.fill(false);
    if (assignment_.observations.size() < config_.min_observations) return update_from_few(images, report);
    status = estimator_.solve(assignment_.observations, &predicted, solution_);
  }
  if (status == Status::ok) status = filter_.update(solution_.estimate);
  if (status == Status::ok) {
    look_at_sights(images, report);
    take(time, report);
  } else {
    solution_.used.fill(false);
    report_markers(report);
  }
  return status;
}

Status CoopNavigator::track(std::span<const CameraImage> images, Time time, StepReport& report) {
  StageTimer timer(clock_);
  remember_markers(images);
  Status status = filter_.predict(time);
  if (status != Status::ok) return status;
  report.times.predict_ns += timer.lap();
  const Pose predicted = filter_.pose();
  status = look_for_expected(images, predicted, filter_.pose_covariance(), report);
  if (status == Status::ok) drop_torn_parts(images, report);
  report.times.match_ns += timer.lap();
  if (status != Status::ok) return status;

  solution_.used.fill(false);
  report.state = filter_.output();
  status = update(images, predicted, time, report);
  for (std::size_t c = 0; c < torn_.size(); ++c) {
    torn_[c].frames = report.tears[c].exists() ? std::min(torn_[c].frames + 1, most_torn_frames) : 0;
  }
  report.times.update_ns += timer.lap();
  return status;
}

Status CoopNavigator::update_from_few(std::span<const CameraImage> images, StepReport& report) {
  const bool any = !assignment_.observations.empty();  // none is no fault: the loop counts frames without an update
  const Status status =
      any ? filter_.update(estimator_.rig(), config_.target, assignment_.observations, solution_.used) : Status::ok;
  if (any && status == Status::ok) {
    solution_.estimate.pose = filter_.pose();
    solution_.estimate.covariance = filter_.pose_covariance();
    look_at_sights(images, report);
  }
  report.state = filter_.output();
  report_markers(report);
  report.inliers = static_cast<std::uint16_t>(
      std::count(solution_.used.begin(), solution_.used.begin() + assignment_.observations.size(), true));
  return status;
}

void CoopNavigator::look_at_sights(std::span<const CameraImage> images, const StepReport& report) {
  for (std::size_t c = 0; c < images.size(); ++c) {
    if (std::holds_alternative<std::monostate>(images[c]) || report.tears[c].exists()) continue;
    const auto camera = static_cast<std::uint16_t>(c);
    agreeing_markers_.clear();
    expect_markers(estimator_.rig(), config_.target, solution_.estimate.pose, solution_.estimate.covariance, camera,
                   image_border_px, config_.tracking, agreeing_markers_);
    find_agreeing_spots(agreeing_markers_, spots_, config_.tracking, agreeing_);
    sights_.record(camera, agreeing_markers_, agreeing_);
  }
}

void CoopNavigator::take(Time time, StepReport& report) {
  const PoseEstimate& e = solution_.estimate;
  report.state = filter_.output();
  report.state.time = time;
  report.state.t_CT = e.pose.t_CT;
  report.state.R_CT = e.pose.R_CT;
  report.state.pose_covariance = e.covariance;
  report_markers(report);
  report.inliers = static_cast<std::uint16_t>(e.used);
  report.test_ratio = e.degrees_of_freedom > 0 ? e.chi2 / static_cast<double>(e.degrees_of_freedom) : 0.0;
}

void CoopNavigator::report_markers(StepReport& report) const {
  report.features = static_cast<std::uint16_t>(markers_.size());
  report.matched = static_cast<std::uint16_t>(assignment_.observations.size());
  report.inliers = 0;
  std::array<std::size_t, config::max_observations> observed;
  observed.fill(config::max_observations);
  for (std::size_t i = 0; i < assignment_.marker.size(); ++i) observed[assignment_.marker[i]] = i;
  for (std::size_t k = 0; k < markers_.size(); ++k) {
    if (markers_[k].camera != report.camera) continue;  // FEATURES packets are about one image
    FeatureReport f;
    f.index = markers_[k].feature;
    f.predicted_px = markers_[k].uv_px;
    f.use = FeatureUse::not_found;
    if (observed[k] < config::max_observations) {
      f.measured_px = assignment_.observations[observed[k]].uv_px;
      f.use = solution_.used[observed[k]] ? FeatureUse::low_innovation : FeatureUse::rejected;
    }
    if (report.feature_reports.push_back(f) != Status::ok) return;
  }
}

}  // namespace relnav::app
