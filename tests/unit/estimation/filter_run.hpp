#pragma once
// A filter and its simulated target, frame by frame, as the flight loop would run them.
#include "tests/support/feature_simulation.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

namespace relnav::test {

class FilterRun {
 public:
  FilterRun(const NoncoopConfig& config, const TargetMotion& motion, double noise_px, std::uint64_t seed, double dt_s,
            int body_points = 400, std::size_t most_features = config::max_features)
      : FilterRun(config, motion, noise_px, seed, dt_s, Normal(seed), body_points, most_features) {}

  void step() {
    simulation_.advance(dt_s_);
    time_ = time_ + Duration{static_cast<std::int64_t>(dt_s_ * 1e9 + 0.5)};
    if (filter_.predict(time_) != Status::ok) std::abort();
    filter_.predict_features(predictions_);
    simulation_.measure(predictions_, matches_);
    last_ = filter_.update(matches_);
    dropped_.clear();
    filter_.drop_spent_features(dropped_);
    for (const SlotHandle slot : dropped_) simulation_.forget(slot);
    if (filter_.has_room()) simulation_.add_features(filter_);
  }
  /// dphi with R_true = Exp([dphi x]) R_est. T's axes were C's at the start.
  [[nodiscard]] Vec3 attitude_error(const RelativeState& out) const {
    return log_so3(R_CT_true() * out.R_CT.transpose());
  }
  [[nodiscard]] Mat3 R_CT_true() const { return simulation_.R_CB() * R_CB0_.transpose(); }
  [[nodiscard]] const FilterUpdate& last() const { return last_; }
  [[nodiscard]] NoncoopFilter& filter() { return filter_; }
  [[nodiscard]] FeatureSimulation& simulation() { return simulation_; }

 private:
  FilterRun(const NoncoopConfig& config, const TargetMotion& motion, double noise_px, std::uint64_t seed, double dt_s,
            Normal rng, int body_points, std::size_t most_features)
      : simulation_(motion, random_body(rng, body_points), sample_camera(), noise_px, seed + 1000),
        dt_s_(dt_s),
        R_CB0_(motion.R_CB0) {
    if (filter_.configure(config, sample_camera()) != Status::ok) std::abort();
    simulation_.set_most_features(most_features);
    simulation_.start(filter_, time_);
  }

  NoncoopFilter filter_;
  FeatureSimulation simulation_;
  FeaturePredictions predictions_;
  FeatureMatches matches_;
  BoundedVector<SlotHandle, config::max_features> dropped_;
  FilterUpdate last_;
  Time time_{1'000'000'000};
  double dt_s_;
  Mat3 R_CB0_;
};

}  // namespace relnav::test
