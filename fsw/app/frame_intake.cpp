#include "fsw/app/frame_intake.hpp"

#include <algorithm>

#include "fsw/app/saturating.hpp"

namespace relnav::app {
namespace {

/// Of two reasons for having no frame the one with the higher rank is told.
int rank_of(const FeedOutcome& outcome) {
  if (outcome.refused || outcome.damaged()) return 3;
  if (outcome.status == Status::device_lost) return 0;
  return outcome.status == Status::no_data ? 1 : 2;
}

/// Of a camera without a frame for this epoch; ok: it gave one, of another time.
Status or_timeout(Status status) { return status == Status::ok ? Status::timeout : status; }

}  // namespace

void FrameIntake::configure(const IntakeSettings& settings) {
  settings_ = settings;
  in_epoch_ = {};
  passed_by_ = {};
  has_epoch_ = false;
  incomplete_ = 0;
}

Status FrameIntake::start(std::size_t& camera) {
  has_epoch_ = false;
  for (camera = 0; camera < settings_.cameras; ++camera) {
    const Status status = feeds_[camera].start();
    if (status == Status::ok) continue;
    for (std::size_t c = 0; c < camera; ++c) static_cast<void>(feeds_[c].stop());  // the start has failed anyway
    return status;
  }
  return Status::ok;
}

Status FrameIntake::stop() {
  Status answer = Status::ok;
  for (std::size_t c = 0; c < settings_.cameras; ++c) {
    const Status stopped = feeds_[c].stop();
    if (answer == Status::ok) answer = stopped;
  }
  in_epoch_ = {};
  passed_by_ = {};
  return answer;
}

FrameEpoch FrameIntake::gather() {
  FrameEpoch epoch;
  in_epoch_ = {};
  for (CameraFeed& feed : feeds_) feed.begin_step();
  if (settings_.cameras == 1) {
    fetch(0, settings_.wait, {}, epoch);
    epoch.restart = feeds_[0].outcome().check.restart;
  } else {
    fetch_pair(epoch);
  }
  choose(epoch);
  if (epoch.status == Status::ok) {
    if (settings_.cameras > 1) look_for_mate(epoch);
  } else {
    say_why_not(epoch);
  }
  return epoch;
}

void FrameIntake::fetch(std::size_t camera, Duration wait, Duration already_waited, FrameEpoch& epoch) {
  CameraFeed& feed = feeds_[camera];
  if (feed.has_frame()) return;
  for (int k = 0; k < most_late; ++k) {
    feed.fetch(wait, already_waited);
    epoch.acquire_time.ns += feed.fetch_time().ns;
    if (!feed.has_frame() || !is_late(feed.frame())) return;
    if (feed.give_back() != Status::ok) return;
    already_waited = {};
  }
}

void FrameIntake::fetch_pair(FrameEpoch& epoch) {
  // The one that has kept silent for longer is asked last: it must not hold up the other.
  const std::size_t one = feeds_[1].silence() < feeds_[0].silence() ? 1 : 0;
  const std::size_t other = 1 - one;
  fetch(one, settings_.wait, {}, epoch);
  if (feeds_[one].has_frame() || !feeds_[one].outcome().waited_in_vain()) {
    fetch(other, settings_.wait, {}, epoch);
    return;
  }
  fetch(other, {}, settings_.wait, epoch);
  // The mate of a frame that came during the wait may just be on its way.
  if (feeds_[other].has_frame() && !feeds_[one].is_lost()) fetch(one, settings_.wait, {}, epoch);
}

void FrameIntake::choose(FrameEpoch& epoch) {
  const hal::Frame* earliest = nullptr;
  for (std::size_t c = 0; c < settings_.cameras; ++c) {
    if (!feeds_[c].has_frame()) continue;
    const hal::Frame& frame = feeds_[c].frame();
    if (earliest == nullptr || frame.mid_exposure < earliest->mid_exposure) earliest = &frame;
  }
  if (earliest == nullptr) return;
  const Time time = earliest->mid_exposure;
  bool first = true;
  for (std::size_t c = 0; c < settings_.cameras; ++c) {
    if (!feeds_[c].has_frame()) continue;
    const hal::Frame& frame = feeds_[c].frame();
    const Duration ahead = frame.mid_exposure - time;
    if (ahead > settings_.pair_tolerance) {
      keep_waiting(c, ahead);
      continue;
    }
    in_epoch_[c] = true;
    passed_by_[c] = 0;
    epoch.images[c] = image_of(frame);
    if (!first) continue;
    first = false;
    epoch.camera = c;
    epoch.stamp = {frame.mid_exposure, frame.sequence};
  }
  epoch.status = epoch.reason = Status::ok;
  // A gap that the other camera has bridged is none.
  if (settings_.cameras > 1) epoch.restart = has_epoch_ && epoch.stamp.time - epoch_time_ > settings_.restart_gap;
  has_epoch_ = true;
  epoch_time_ = epoch.stamp.time;
}

void FrameIntake::keep_waiting(std::size_t camera, Duration ahead) {
  passed_by_[camera] = ahead > settings_.restart_gap ? passed_by_[camera] + 1 : 0;
  if (passed_by_[camera] < most_passed_by) return;
  // One wrong stamp must not keep the camera out until that time has come.
  passed_by_[camera] = 0;
  feeds_[camera].accept_new_time_base();
  static_cast<void>(feeds_[camera].give_back());  // lost if it fails
}

void FrameIntake::look_for_mate(FrameEpoch& epoch) {
  for (std::size_t c = 0; c < settings_.cameras; ++c) {
    const FeedOutcome& outcome = feeds_[c].outcome();
    if (in_epoch_[c] || outcome.refused || outcome.status == Status::device_lost) continue;
    epoch.missing = c;
    epoch.missing_reason = feeds_[c].has_frame() ? Status::timeout : or_timeout(outcome.reason);
    increment(incomplete_);
  }
}

void FrameIntake::say_why_not(FrameEpoch& epoch) {
  const FeedOutcome* best = nullptr;
  for (std::size_t c = 0; c < settings_.cameras; ++c) {
    const FeedOutcome& outcome = feeds_[c].outcome();
    if (outcome.damaged()) increment(incomplete_);
    if (outcome.waited_in_vain()) epoch.waited = settings_.wait;
    if (best == nullptr || rank_of(outcome) > rank_of(*best)) best = &outcome;
  }
  epoch.status = or_timeout(best->status);
  epoch.reason = or_timeout(best->reason);
  epoch.damaged = best->damaged();
  epoch.refused = best->refused;
  if (epoch.damaged || epoch.refused) epoch.waited = {};
}

Status FrameIntake::give_back(std::size_t camera) {
  if (!in_epoch_[camera]) return Status::ok;
  in_epoch_[camera] = false;
  return feeds_[camera].give_back();
}

void FrameIntake::accept_new_time_base() {
  has_epoch_ = false;
  for (CameraFeed& feed : feeds_) feed.accept_new_time_base();
}

}  // namespace relnav::app
