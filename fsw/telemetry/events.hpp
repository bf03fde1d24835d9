#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace relnav::telemetry {

/// Severity of an event; its number is the PUS service 5 subtype.
enum class Severity : std::uint8_t { info = 1, low = 2, medium = 3, high = 4 };

[[nodiscard]] constexpr const char* to_string(Severity severity) {
  switch (severity) {
    case Severity::info: return "INFO";
    case Severity::low: return "LOW";
    case Severity::medium: return "MEDIUM";
    case Severity::high: return "HIGH";
  }
  return "UNKNOWN";
}

/// What can happen. Numbers are part of the ICD: never reuse one, add at the end.
enum class EventId : std::uint16_t {
  mode_changed = 1,
  configuration_accepted = 2,
  configuration_refused = 3,
  frame_refused_out_of_order = 4,
  frame_refused_size = 5,
  frame_refused_format = 6,
  frame_refused_age = 7,
  frame_incomplete = 8,
  frame_gap = 9,
  camera_lost = 10,
  camera_recovered = 11,
  image_without_contrast = 12,
  image_frozen = 13,
  too_few_features = 14,
  feature_capacity = 15,
  update_refused = 16,
  covariance_repaired = 17,
  filter_reset = 18,
  chart_switched = 19,
  track_acquired = 20,
  track_lost = 21,
  telemetry_dropped = 22,
  numerical_fault = 23,
  pose_ambiguous = 24,
  spots_dropped = 25,
  pair_incomplete = 26,
  safe_state_entered = 27,
  time_synchronised = 28,
  time_lost = 29,
  time_jumped = 30,
  command_refused = 31,
  line_failed = 32,
  image_torn = 33,
};

struct EventDefinition {
  EventId id;
  const char* name;
  Severity severity;
  const char* description;
  std::array<const char*, 4> args;  ///< meaning of each argument; "" for one that is not used (and 0)
};

inline constexpr std::array<EventDefinition, 33> event_definitions{{
    {EventId::mode_changed,
     "mode_changed",
     Severity::info,
     "The flight loop's mode changed.",
     {"from_mode", "to_mode", "", ""}},
    {EventId::configuration_accepted,
     "configuration_accepted",
     Severity::info,
     "A configuration was taken.",
     {"configuration_crc", "", "", ""}},
    {EventId::configuration_refused,
     "configuration_refused",
     Severity::medium,
     "A configuration was refused; the previous one stays.",
     {"item", "", "", ""}},
    {EventId::frame_refused_out_of_order,
     "frame_refused_out_of_order",
     Severity::low,
     "A frame's time stamp repeats or goes back; the frame was not used.",
     {"frame_sequence", "time_ns", "previous_time_ns", ""}},
    {EventId::frame_refused_size,
     "frame_refused_size",
     Severity::medium,
     "A frame's size is not the configured one; the frame was not used.",
     {"width_px", "height_px", "expected_width_px", "expected_height_px"}},
    {EventId::frame_refused_format,
     "frame_refused_format",
     Severity::medium,
     "A frame's pixel format is not supported; the frame was not used.",
     {"format", "", "", ""}},
    {EventId::frame_refused_age,
     "frame_refused_age",
     Severity::low,
     "A frame was older than the limit; it was not used.",
     {"frame_sequence", "age_ns", "limit_ns", ""}},
    {EventId::frame_incomplete,
     "frame_incomplete",
     Severity::low,
     "A frame is missing, damaged or in part; it was not used.",
     {"incomplete_frames", "", "", ""}},
    {EventId::frame_gap,
     "frame_gap",
     Severity::low,
     "Frames are missing between two that arrived.",
     {"frame_sequence", "previous_sequence", "missing_frames", ""}},
    {EventId::camera_lost,
     "camera_lost",
     Severity::high,
     "The camera does not answer any more.",
     {"camera", "", "", ""}},
    {EventId::camera_recovered,
     "camera_recovered",
     Severity::info,
     "The camera works again, with all settings sent anew.",
     {"camera", "attempts", "", ""}},
    {EventId::image_without_contrast,
     "image_without_contrast",
     Severity::medium,
     "The image is (almost) of one grey level.",
     {"minimum_level", "maximum_level", "", ""}},
    {EventId::image_frozen,
     "image_frozen",
     Severity::medium,
     "The image repeats although its time stamp advances.",
     {"repeated_frames", "", "", ""}},
    {EventId::too_few_features,
     "too_few_features",
     Severity::medium,
     "Fewer features than the estimator needs.",
     {"features", "needed", "", ""}},
    {EventId::feature_capacity,
     "feature_capacity",
     Severity::low,
     "A feature was not added because every slot is taken.",
     {"features", "capacity", "", ""}},
    {EventId::update_refused,
     "update_refused",
     Severity::low,
     "A measurement contradicts the filter and was not used.",
     {"test_ratio_1e3", "matched", "inliers", ""}},
    {EventId::covariance_repaired,
     "covariance_repaired",
     Severity::medium,
     "A covariance was not positive definite and was repaired.",
     {"repairs", "", "", ""}},
    {EventId::filter_reset,
     "filter_reset",
     Severity::medium,
     "The filter started anew.",
     {"reset_counter", "", "", ""}},
    {EventId::chart_switched,
     "chart_switched",
     Severity::info,
     "The attitude parameters changed to another chart (sequential rotation or shadow set).",
     {"from_chart", "to_chart", "", ""}},
    {EventId::track_acquired, "track_acquired", Severity::info, "The target is tracked.", {"features", "", "", ""}},
    {EventId::track_lost,
     "track_lost",
     Severity::high,
     "The target is no longer tracked.",
     {"frames_without_update", "features", "", ""}},
    {EventId::telemetry_dropped,
     "telemetry_dropped",
     Severity::low,
     "Packets were not taken by the link.",
     {"dropped_packets", "", "", ""}},
    {EventId::numerical_fault,
     "numerical_fault",
     Severity::medium,
     "A computation gave no usable result; its output was not used.",
     {"stage", "", "", ""}},
    {EventId::pose_ambiguous,
     "pose_ambiguous",
     Severity::medium,
     "More than one pose explains the light spots, and nothing decides between them.",
     {"spots", "", "", ""}},
    {EventId::spots_dropped,
     "spots_dropped",
     Severity::low,
     "More light spots than there is room for; the weakest were left out.",
     {"dropped_spots", "", "", ""}},
    {EventId::pair_incomplete,
     "pair_incomplete",
     Severity::low,
     "One camera's frame of a pair is missing, late or damaged; the other one was used alone.",
     {"camera", "time_ns", "incomplete_frames", ""}},
    {EventId::safe_state_entered,
     "safe_state_entered",
     Severity::high,
     "The program cannot go on: the last packet before the platform's safe state. Cause and details are the "
     "platform's.",
     {"cause", "where", "detail", ""}},
    {EventId::time_synchronised,
     "time_synchronised",
     Severity::info,
     "The pulses give offset and drift of the clock against TAI.",
     {"drift_ppb", "residual_ns", "pulses_used", ""}},
    {EventId::time_lost,
     "time_lost",
     Severity::medium,
     "No pulse comes any more; TAI goes on by the last offset and drift.",
     {"pulse_age_ms", "drift_ppb", "pulses_used", ""}},
    {EventId::time_jumped,
     "time_jumped",
     Severity::medium,
     "The pulses moved against the clock for good; the offset to TAI starts anew.",
     {"step_ns", "pulses_refused", "", ""}},
    {EventId::command_refused,
     "command_refused",
     Severity::low,
     "A telecommand was damaged, unknown, or could not be carried out.",
     {"service", "subtype", "sequence_count", "refused_commands"}},
    {EventId::line_failed,
     "line_failed",
     Severity::medium,
     "A digital line does not work; it is requested anew.",
     {"line", "failures", "", ""}},
    {EventId::image_torn,
     "image_torn",
     Severity::medium,
     "Part of an image still shows the frame before; that part was not used.",
     {"camera", "row_px", "late_spots", ""}},
}};

/// nullptr for an id that is not in the table.
[[nodiscard]] constexpr const EventDefinition* find_event(std::uint16_t id) {
  return id >= 1 && id <= event_definitions.size() ? &event_definitions[id - 1U] : nullptr;
}

[[nodiscard]] constexpr const EventDefinition& definition_of(EventId id) {
  return event_definitions[static_cast<std::size_t>(id) - 1U];
}

namespace event_detail {
[[nodiscard]] consteval bool table_is_in_order() {
  for (std::size_t i = 0; i < event_definitions.size(); ++i) {
    if (static_cast<std::size_t>(event_definitions[i].id) != i + 1U) return false;
  }
  return true;
}
}  // namespace event_detail
static_assert(event_detail::table_is_in_order(), "find_event() indexes the table by id");

}  // namespace relnav::telemetry
