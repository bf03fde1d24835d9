#pragma once
/// The telemetry packets: value structs and the one table that serializer, decoder, ICD and tests are made from.
/// Frames, symbols and the order of covariances: docs/conventions.md and docs/telemetry-icd.md.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/telemetry/events.hpp"
#include "fsw/telemetry/field.hpp"

namespace relnav::telemetry {

/// Also the packet's APID offset from the configured base, and the PUS structure id minus one (service 3).
enum class PacketId : std::uint8_t {
  rel_state = 0,
  features = 1,
  health = 2,
  event = 3,
  time = 4,
  command_ack = 5,
  pong = 6
};
inline constexpr std::size_t packet_count = 7;

inline constexpr std::size_t max_packet_bytes = 1400;
inline constexpr std::size_t max_features_per_packet = 64;

enum class Estimator : std::uint8_t {
  none = 0,
  mono_least_squares = 1,
  stereo_least_squares = 2,
  motor = 3,
  inverse_depth_ekf = 4,
  orthogonal = 5
};
enum class FrameCode : std::uint8_t { camera_0 = 0, camera_1 = 1, target = 2, chaser_body = 3, inertial = 4 };

/// How well the clock's offset to TAI is known.
enum class SyncStatus : std::uint8_t {
  none = 0,      ///< no pulse so far
  coarse = 1,    ///< pulses came, too few for the drift
  locked = 2,    ///< offset and drift follow the pulses
  holdover = 3,  ///< no pulse any more: both are the last known
};
/// Who said which second of TAI a pulse is.
enum class SecondsSource : std::uint8_t { configuration = 0, command = 1 };

/// What became of a telecommand; its number is the PUS service 1 subtype.
enum class CommandStage : std::uint8_t { accepted = 1, refused = 2, done = 7, failed = 8 };

[[nodiscard]] constexpr bool is_command_stage(std::uint8_t subtype) {
  return subtype == 1 || subtype == 2 || subtype == 7 || subtype == 8;
}

/// Bits of RelStatePacket::valid_flags. A quantity whose bit is clear is filled with zeros (q_CT: identity).
namespace valid {
inline constexpr std::uint8_t pose = 0x01;
inline constexpr std::uint8_t pose_covariance = 0x02;
inline constexpr std::uint8_t velocity = 0x04;
inline constexpr std::uint8_t rate = 0x08;
inline constexpr std::uint8_t rate_covariance = 0x10;
inline constexpr std::uint8_t scale = 0x20;      ///< metres are metres (clear: free scale)
inline constexpr std::uint8_t predicted = 0x40;  ///< no measurement of this frame went into the state
}  // namespace valid

/// Bits of HealthPacket::flags.
namespace health {
inline constexpr std::uint8_t camera_streaming = 0x01;  ///< the first one
inline constexpr std::uint8_t filter_running = 0x02;
inline constexpr std::uint8_t arithmetic_overflow = 0x04;      ///< a fixed-point number saturated since start
inline constexpr std::uint8_t second_camera_streaming = 0x08;  ///< of a pair
}  // namespace health

struct RelStatePacket {
  std::uint64_t time_ns = 0;
  std::uint32_t frame_sequence = 0;
  std::uint8_t camera = 0;
  std::uint8_t mode = 0;
  std::uint8_t valid_flags = 0;
  std::uint8_t quality = 0;
  std::uint16_t reset_counter = 0;
  std::uint8_t estimator = 0;
  std::uint8_t parent_frame = static_cast<std::uint8_t>(FrameCode::camera_0);
  std::uint8_t child_frame = static_cast<std::uint8_t>(FrameCode::target);
  std::array<double, 3> t_CT{};
  std::array<double, 4> q_CT{0.0, 0.0, 0.0, 1.0};
  std::array<double, 3> v_C{};
  std::array<double, 3> omega_C{};
  std::array<float, 21> pose_covariance{};
  std::array<float, 21> rate_covariance{};
};

struct FeatureEntry {
  std::uint16_t slot = 0;
  std::uint16_t generation = 0;
  std::int32_t u_px_256 = 0;
  std::int32_t v_px_256 = 0;
  float residual_px = 0.0F;
  std::uint8_t use = 0;
};

struct FeaturesPacket {
  std::uint64_t time_ns = 0;
  std::uint32_t frame_sequence = 0;
  std::uint8_t part = 0;
  std::uint8_t parts = 1;
  std::uint16_t features_total = 0;
  BoundedVector<FeatureEntry, max_features_per_packet> entries;
};

struct HealthPacket {
  std::uint64_t time_ns = 0;
  std::uint32_t frame_sequence = 0;
  std::uint8_t mode = 0;
  std::uint8_t flags = 0;
  std::uint8_t last_status = 0;
  std::uint32_t frames_processed = 0;
  std::uint32_t frames_refused = 0;
  std::uint32_t frames_incomplete = 0;
  std::uint32_t frames_lost = 0;
  std::uint16_t camera_losses = 0;
  std::uint16_t features = 0;
  std::uint16_t matched = 0;
  std::uint16_t inliers = 0;
  std::uint32_t refused_updates = 0;
  std::uint32_t covariance_repairs = 0;
  std::uint16_t reset_counter = 0;
  float test_ratio = 0.0F;
  std::uint32_t telemetry_dropped = 0;
  std::uint32_t event_count = 0;
  std::uint32_t events_suppressed = 0;
  std::uint32_t latency_us = 0;
  std::uint32_t latency_max_us = 0;
  std::uint32_t arrival_latency_us = 0;
  std::uint32_t arrival_latency_max_us = 0;
};

struct EventPacket {
  std::uint16_t event_id = 0;
  std::uint32_t occurrence = 0;
  std::uint32_t suppressed = 0;
  std::uint8_t status = 0;
  std::uint64_t time_ns = 0;
  std::uint32_t frame_sequence = 0;
  std::array<std::int64_t, 4> args{};
};

struct TimePacket {
  std::uint64_t time_ns = 0;
  std::uint64_t tai_ns = 0;
  std::int32_t drift_ppb = 0;
  std::int32_t residual_ns = 0;
  std::uint32_t pulse_age_ms = 0;
  std::uint32_t pulses_used = 0;
  std::uint32_t pulses_missed = 0;
  std::uint32_t pulses_refused = 0;
  std::uint8_t sync = 0;
  std::uint8_t seconds_source = 0;
  std::int32_t exposure_offset_ns = 0;
};

struct CommandAckPacket {
  std::uint16_t request_packet_id = 0;
  std::uint16_t request_sequence = 0;
  std::uint8_t stage = static_cast<std::uint8_t>(CommandStage::accepted);
  std::uint8_t code = 0;
  std::uint8_t service = 0;
  std::uint8_t subtype = 0;
  std::uint64_t time_ns = 0;
};

struct PongPacket {
  std::uint64_t time_ns = 0;
};

namespace labels {

inline constexpr std::array<Label, 4> mode_items{{{0, "STANDBY"}, {1, "ACQUIRE"}, {2, "TRACK"}, {3, "LOST"}}};
inline constexpr std::array<Label, 6> estimator_items{{{0, "none"},
                                                       {1, "mono_least_squares"},
                                                       {2, "stereo_least_squares"},
                                                       {3, "motor"},
                                                       {4, "inverse_depth_ekf"},
                                                       {5, "orthogonal"}}};
inline constexpr std::array<Label, 5> frame_items{{{0, "C0"}, {1, "C1"}, {2, "T"}, {3, "B"}, {4, "I"}}};
inline constexpr std::array<Label, 6> use_items{{{0, "not_expected"},
                                                 {1, "not_found"},
                                                 {2, "rejected"},
                                                 {3, "low_innovation"},
                                                 {4, "high_innovation"},
                                                 {5, "added"}}};
inline constexpr std::array<Label, 7> valid_items{{{valid::pose, "pose"},
                                                   {valid::pose_covariance, "pose_covariance"},
                                                   {valid::velocity, "velocity"},
                                                   {valid::rate, "rate"},
                                                   {valid::rate_covariance, "rate_covariance"},
                                                   {valid::scale, "scale"},
                                                   {valid::predicted, "predicted"}}};
inline constexpr std::array<Label, 4> health_items{{{health::camera_streaming, "camera_streaming"},
                                                    {health::filter_running, "filter_running"},
                                                    {health::arithmetic_overflow, "arithmetic_overflow"},
                                                    {health::second_camera_streaming, "second_camera_streaming"}}};
inline constexpr std::array<Label, 4> sync_items{{{0, "none"}, {1, "coarse"}, {2, "locked"}, {3, "holdover"}}};
inline constexpr std::array<Label, 2> seconds_items{{{0, "configuration"}, {1, "command"}}};
inline constexpr std::array<Label, 4> stage_items{{{1, "accepted"}, {2, "refused"}, {7, "done"}, {8, "failed"}}};

[[nodiscard]] consteval std::array<Label, static_cast<std::size_t>(Status::unfinished) + 1U> make_status_items() {
  std::array<Label, static_cast<std::size_t>(Status::unfinished) + 1U> items{};
  for (std::size_t i = 0; i < items.size(); ++i) items[i] = {i, to_string(static_cast<Status>(i))};
  return items;
}
inline constexpr auto status_items = make_status_items();

[[nodiscard]] consteval std::array<Label, event_definitions.size()> make_event_items() {
  std::array<Label, event_definitions.size()> items{};
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i] = {static_cast<std::uint64_t>(event_definitions[i].id), event_definitions[i].name};
  }
  return items;
}
inline constexpr auto event_items = make_event_items();

inline constexpr Labels mode{LabelKind::enumeration, "Mode", mode_items};
inline constexpr Labels estimator{LabelKind::enumeration, "Estimator", estimator_items};
inline constexpr Labels frame{LabelKind::enumeration, "FrameCode", frame_items};
inline constexpr Labels use{LabelKind::enumeration, "FeatureUse", use_items};
inline constexpr Labels status{LabelKind::enumeration, "Status", status_items};
inline constexpr Labels event{LabelKind::enumeration, "EventId", event_items};
inline constexpr Labels valid_flags{LabelKind::flags, "ValidFlags", valid_items};
inline constexpr Labels health_flags{LabelKind::flags, "HealthFlags", health_items};
inline constexpr Labels sync{LabelKind::enumeration, "SyncStatus", sync_items};
inline constexpr Labels seconds{LabelKind::enumeration, "SecondsSource", seconds_items};
inline constexpr Labels stage{LabelKind::enumeration, "CommandStage", stage_items};

}  // namespace labels

inline constexpr auto rel_state_fields = std::tuple{
    field(&RelStatePacket::time_ns, "time_ns", "ns", "Time of validity: mid-exposure of the frame"),
    field(&RelStatePacket::frame_sequence, "frame_sequence", "", "Sequence number of the frame, from the camera"),
    field(&RelStatePacket::camera, "camera", "", "Camera whose frame it is"),
    field(&RelStatePacket::mode, "mode", "", "Mode of the flight loop after the frame", labels::mode),
    field(&RelStatePacket::valid_flags, "valid_flags", "", "Which of the quantities below are meant",
          labels::valid_flags),
    field(&RelStatePacket::quality, "quality", "%", "Inliers of the features searched for, 0 to 100"),
    field(&RelStatePacket::reset_counter, "reset_counter", "",
          "Goes up by one each time the estimate jumps because the filter started anew"),
    field(&RelStatePacket::estimator, "estimator", "", "What made the estimate", labels::estimator),
    field(&RelStatePacket::parent_frame, "parent_frame", "", "Frame C: vectors are expressed in it", labels::frame),
    field(&RelStatePacket::child_frame, "child_frame", "", "Frame T: the one whose pose is given", labels::frame),
    field(&RelStatePacket::t_CT, "t_CT", "m", "Origin of T in C; x, y, z"),
    field(&RelStatePacket::q_CT, "q_CT", "",
          "Hamilton unit quaternion of R_CT (p_C = R_CT p_T + t_CT); x, y, z, w with w >= 0"),
    field(&RelStatePacket::v_C, "v_C", "m/s", "Time derivative of t_CT"),
    field(&RelStatePacket::omega_C, "omega_C", "rad/s", "Angular rate of T relative to C, expressed in C"),
    field(&RelStatePacket::pose_covariance, "pose_covariance", "m2, m rad, rad2",
          "Of [dt dphi], row-major upper triangle"),
    field(&RelStatePacket::rate_covariance, "rate_covariance", "m2/s2, m rad/s2, rad2/s2",
          "Of [dv domega], row-major upper triangle")};

inline constexpr auto features_fields = std::tuple{
    field(&FeaturesPacket::time_ns, "time_ns", "ns", "Mid-exposure of the frame"),
    field(&FeaturesPacket::frame_sequence, "frame_sequence", "", "Sequence number of the frame, from the camera"),
    field(&FeaturesPacket::part, "part", "", "Number of this packet among those of the frame, from 0"),
    field(&FeaturesPacket::parts, "parts", "", "Packets of the frame"),
    field(&FeaturesPacket::features_total, "features_total", "", "Features in all parts together")};

inline constexpr auto feature_entry_fields = std::tuple{
    field(&FeatureEntry::slot, "slot", "", "Slot of the feature"),
    field(&FeatureEntry::generation, "generation", "", "Use of the slot: another number is another feature"),
    field(&FeatureEntry::u_px_256, "u_px_256", "px/256", "Measured u, or predicted u when there is no measurement"),
    field(&FeatureEntry::v_px_256, "v_px_256", "px/256", "Measured v, or predicted v when there is no measurement"),
    field(&FeatureEntry::residual_px, "residual_px", "px",
          "Distance from predicted to measured; 0 when there is no measurement"),
    field(&FeatureEntry::use, "use", "", "What became of the feature in the frame", labels::use)};

inline constexpr auto health_fields = std::tuple{
    field(&HealthPacket::time_ns, "time_ns", "ns", "Mid-exposure of the latest frame that was used"),
    field(&HealthPacket::frame_sequence, "frame_sequence", "", "Sequence number of that frame"),
    field(&HealthPacket::mode, "mode", "", "Mode of the flight loop", labels::mode),
    field(&HealthPacket::flags, "flags", "", "Yes/no states", labels::health_flags),
    field(&HealthPacket::last_status, "last_status", "", "Outcome of the latest step", labels::status),
    field(&HealthPacket::frames_processed, "frames_processed", "", "Frames used since start"),
    field(&HealthPacket::frames_refused, "frames_refused", "", "Frames refused since start (order, size, format, age)"),
    field(&HealthPacket::frames_incomplete, "frames_incomplete", "",
          "Frames that arrived damaged, or are missing in a pair, since start"),
    field(&HealthPacket::frames_lost, "frames_lost", "", "Frames missing by sequence number since start"),
    field(&HealthPacket::camera_losses, "camera_losses", "", "Losses of a camera since start"),
    field(&HealthPacket::features, "features", "", "Features in the filter"),
    field(&HealthPacket::matched, "matched", "", "Features found in the latest frame"),
    field(&HealthPacket::inliers, "inliers", "", "Features used of those"),
    field(&HealthPacket::refused_updates, "refused_updates", "", "Updates the filter refused since start"),
    field(&HealthPacket::covariance_repairs, "covariance_repairs", "", "Covariances repaired since start"),
    field(&HealthPacket::reset_counter, "reset_counter", "", "As in REL_STATE"),
    field(&HealthPacket::test_ratio, "test_ratio", "",
          "Normalised innovation squared over its 99 % bound, latest update"),
    field(&HealthPacket::telemetry_dropped, "telemetry_dropped", "", "Packets the link did not take since start"),
    field(&HealthPacket::event_count, "event_count", "", "Events since start, reported or not"),
    field(&HealthPacket::events_suppressed, "events_suppressed", "",
          "Events not reported one by one since start (rate limit)"),
    field(&HealthPacket::latency_us, "latency_us", "us",
          "From mid-exposure to the first packet of the frame, latest frame; 0 where its stamps are of another clock "
          "than "
          "the loop's"),
    field(&HealthPacket::latency_max_us, "latency_max_us", "us", "Largest latency since the previous HEALTH"),
    field(&HealthPacket::arrival_latency_us, "arrival_latency_us", "us",
          "From the first data of the frame to its first packet, latest frame; 0 as latency_us"),
    field(&HealthPacket::arrival_latency_max_us, "arrival_latency_max_us", "us",
          "Largest arrival latency since the previous HEALTH")};

inline constexpr auto event_fields = std::tuple{
    field(&EventPacket::event_id, "event_id", "", "What happened", labels::event),
    field(&EventPacket::occurrence, "occurrence", "", "How often since start, this time included"),
    field(&EventPacket::suppressed, "suppressed", "",
          "Of these, not reported since the previous report of the same event"),
    field(&EventPacket::status, "status", "", "Why, as a status code", labels::status),
    field(&EventPacket::time_ns, "time_ns", "ns", "Mid-exposure of the frame concerned, or of the latest frame"),
    field(&EventPacket::frame_sequence, "frame_sequence", "", "Sequence number of that frame"),
    field(&EventPacket::args, "args", "", "Arguments, see the table of events")};

inline constexpr auto time_fields = std::tuple{
    field(&TimePacket::time_ns, "time_ns", "ns", "The latest pulse that was used, by the loop's clock, smoothed"),
    field(&TimePacket::tai_ns, "tai_ns", "ns", "TAI of that pulse since 1958-01-01: a whole second"),
    field(&TimePacket::drift_ppb, "drift_ppb", "1e-9", "Rate of the loop's clock against TAI, minus 1"),
    field(&TimePacket::residual_ns, "residual_ns", "ns", "The pulse minus where it was expected, saturated"),
    field(&TimePacket::pulse_age_ms, "pulse_age_ms", "ms", "From the pulse to this packet, saturated"),
    field(&TimePacket::pulses_used, "pulses_used", "", "Pulses used since start"),
    field(&TimePacket::pulses_missed, "pulses_missed", "", "Pulses that did not come between those used, since start"),
    field(&TimePacket::pulses_refused, "pulses_refused", "", "Edges at a time when no pulse was due, since start"),
    field(&TimePacket::sync, "sync", "", "How well TAI is known", labels::sync),
    field(&TimePacket::seconds_source, "seconds_source", "", "Where the whole seconds of TAI are from",
          labels::seconds),
    field(&TimePacket::exposure_offset_ns, "exposure_offset_ns", "ns",
          "Stamp of the latest frame minus the middle of its exposure by the exposure line; 0 when that is not known")};

inline constexpr auto command_ack_fields = std::tuple{
    field(&CommandAckPacket::request_packet_id, "request_packet_id", "",
          "First two bytes of the telecommand (its APID: the lower 11 bits)"),
    field(&CommandAckPacket::request_sequence, "request_sequence", "",
          "Its next two bytes (sequence count: the lower 14 bits)"),
    field(&CommandAckPacket::stage, "stage", "", "What became of it; also the message subtype", labels::stage),
    field(&CommandAckPacket::code, "code", "", "Why; ok when accepted or done", labels::status),
    field(&CommandAckPacket::service, "service", "", "Service type of the telecommand, 0 when unreadable"),
    field(&CommandAckPacket::subtype, "subtype", "", "Message subtype of the telecommand, 0 when unreadable"),
    field(&CommandAckPacket::time_ns, "time_ns", "ns", "When this was said, by the loop's clock")};

inline constexpr auto pong_fields =
    std::tuple{field(&PongPacket::time_ns, "time_ns", "ns", "When the ping was answered, by the loop's clock")};

inline constexpr auto rel_state_field_definitions = definitions_of(rel_state_fields);
inline constexpr auto features_field_definitions = definitions_of(features_fields);
inline constexpr auto feature_entry_field_definitions = definitions_of(feature_entry_fields);
inline constexpr auto health_field_definitions = definitions_of(health_fields);
inline constexpr auto event_field_definitions = definitions_of(event_fields);
inline constexpr auto time_field_definitions = definitions_of(time_fields);
inline constexpr auto command_ack_field_definitions = definitions_of(command_ack_fields);
inline constexpr auto pong_field_definitions = definitions_of(pong_fields);

/// One packet. Its body is `fields`, then, if there are `entry_fields`, a u16 count and that many entries.
struct PacketDefinition {
  PacketId id;
  const char* name;
  std::uint16_t apid_offset;   ///< from the configured base
  std::uint8_t service;        ///< PUS service type
  std::uint8_t subtype_first;  ///< PUS message subtypes; events have one a severity, TC_ACK one a CommandStage
  std::uint8_t subtype_last;
  std::uint16_t structure_id;  ///< PUS structure id, a u16 in front of the body; 0: none
  const char* rate;
  std::span<const FieldDefinition> fields;
  std::span<const FieldDefinition> entry_fields;
  std::uint16_t max_entries;
};

inline constexpr std::array<PacketDefinition, packet_count> packet_definitions{{
    {PacketId::rel_state, "REL_STATE", 0, 3, 25, 25, 1, "each processed frame", rel_state_field_definitions, {}, 0},
    {PacketId::features, "FEATURES", 1, 3, 26, 26, 2, "each processed frame, or decimated", features_field_definitions,
     feature_entry_field_definitions, max_features_per_packet},
    {PacketId::health, "HEALTH", 2, 3, 25, 25, 3, "every N frames", health_field_definitions, {}, 0},
    {PacketId::event, "EVENT", 3, 5, 1, 4, 0, "when something happens", event_field_definitions, {}, 0},
    {PacketId::time,
     "TIME",
     4,
     3,
     25,
     25,
     5,
     "each pulse used, and when they stay away",
     time_field_definitions,
     {},
     0},
    {PacketId::command_ack, "TC_ACK", 5, 1, 1, 8, 0, "for each telecommand", command_ack_field_definitions, {}, 0},
    {PacketId::pong, "PONG", 6, 17, 2, 2, 0, "for each ping", pong_field_definitions, {}, 0},
}};

[[nodiscard]] constexpr const PacketDefinition& definition_of(PacketId id) {
  return packet_definitions[static_cast<std::size_t>(id)];
}

/// Place of a message type among those of all packets, subtype by subtype: each has its own count.
[[nodiscard]] constexpr std::size_t message_index(PacketId id, std::uint8_t subtype) {
  std::size_t index = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(id); ++i) {
    index += packet_definitions[i].subtype_last - packet_definitions[i].subtype_first + 1U;
  }
  return index + subtype - definition_of(id).subtype_first;
}
inline constexpr std::size_t message_types =
    message_index(packet_definitions.back().id, packet_definitions.back().subtype_last) + 1U;

/// Body bytes with `entries` entries.
[[nodiscard]] constexpr std::size_t body_size(const PacketDefinition& definition, std::size_t entries = 0) {
  const std::size_t fixed = size_of(definition.fields);
  return definition.entry_fields.empty() ? fixed : fixed + 2U + entries * size_of(definition.entry_fields);
}

namespace packet_detail {
[[nodiscard]] consteval bool table_is_in_order() {
  for (std::size_t i = 0; i < packet_definitions.size(); ++i) {
    if (static_cast<std::size_t>(packet_definitions[i].id) != i || packet_definitions[i].apid_offset != i) return false;
  }
  return true;
}
}  // namespace packet_detail
static_assert(packet_detail::table_is_in_order(), "definition_of() indexes the table by id");

/// Pixel to px/256: rounded to nearest, saturated; 0 for a value that is not finite.
[[nodiscard]] std::int32_t to_px_256(double px);

}  // namespace relnav::telemetry
