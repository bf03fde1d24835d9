#include "hil/replay/run_history.hpp"

namespace relnav::hil {

FrameRecord record_of(const app::StepReport& report, Time time) {
  FrameRecord r;
  r.time = time;
  r.status = report.status;
  r.mode = report.mode;
  r.has_pose = report.status == Status::ok && report.state.t_CT.allFinite() && report.state.R_CT.allFinite();
  r.known_target = report.estimator != telemetry::Estimator::inverse_depth_ekf;
  r.state = report.state;
  r.reset_counter = report.reset_counter;
  r.features = report.features;
  r.matched = report.matched;
  r.inliers = report.inliers;
  r.refused_updates = report.refused_updates;
  r.test_ratio = report.test_ratio;
  r.times = report.times;
  return r;
}

}  // namespace relnav::hil
