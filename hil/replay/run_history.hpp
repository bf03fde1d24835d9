#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "fsw/app/step_report.hpp"
#include "hil/io/image_entry.hpp"

namespace relnav::hil {

/// What is kept of one step for the summary and the report.
struct FrameRecord {
  Time time;  ///< of the frame, as listed
  Status status = Status::no_data;
  app::Mode mode = app::Mode::standby;
  bool has_pose = false;
  bool known_target = false;  ///< a cooperative estimator made the pose
  RelativeState state;
  std::uint32_t reset_counter = 0;
  std::uint16_t features = 0;
  std::uint16_t matched = 0;
  std::uint16_t inliers = 0;
  std::uint16_t refused_updates = 0;
  double test_ratio = 0.0;
  app::StageTimes times;
};

/// `time`: of the frame or epoch, as listed.
[[nodiscard]] FrameRecord record_of(const app::StepReport& report, Time time);

/// A frame to be shown with its features drawn in.
struct Snapshot {
  Time time;
  std::size_t frame = 0;  ///< row of the image list, from 0
  ImageEntry image;
  app::Mode mode = app::Mode::standby;
  std::vector<app::FeatureReport> features;
};

/// An event packet, as a line of events.log has it.
struct EventNote {
  Time time;  ///< of the frame before which it was sent
  std::string text;
};

struct RunHistory {
  std::vector<FrameRecord> frames;
  std::vector<EventNote> events;
  std::vector<Snapshot> snapshots;
};

}  // namespace relnav::hil
