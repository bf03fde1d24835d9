/// Where each field stands, written down by hand and checked bit by bit on all-zero and all-ones packets.
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "fsw/telemetry/codec.hpp"
#include "fsw/telemetry/visit.hpp"
#include "tests/unit/telemetry/packet_samples.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav::telemetry;
using packet_samples::Buffer;
using relnav::Status;

namespace {

struct Place {
  const char* name;
  std::size_t offset;  ///< in the body
  std::size_t bytes;
};

const std::vector<Place> rel_state_places{{"time_ns", 0, 8},
                                          {"frame_sequence", 8, 4},
                                          {"camera", 12, 1},
                                          {"mode", 13, 1},
                                          {"valid_flags", 14, 1},
                                          {"quality", 15, 1},
                                          {"reset_counter", 16, 2},
                                          {"estimator", 18, 1},
                                          {"parent_frame", 19, 1},
                                          {"child_frame", 20, 1},
                                          {"t_CT", 21, 24},
                                          {"q_CT", 45, 32},
                                          {"v_C", 77, 24},
                                          {"omega_C", 101, 24},
                                          {"pose_covariance", 125, 84},
                                          {"rate_covariance", 209, 84}};
const std::vector<Place> features_places{
    {"time_ns", 0, 8}, {"frame_sequence", 8, 4}, {"part", 12, 1}, {"parts", 13, 1}, {"features_total", 14, 2}};
const std::vector<Place> feature_entry_places{{"slot", 0, 2},     {"generation", 2, 2},   {"u_px_256", 4, 4},
                                              {"v_px_256", 8, 4}, {"residual_px", 12, 4}, {"use", 16, 1}};
const std::vector<Place> health_places{
    {"time_ns", 0, 8},         {"frame_sequence", 8, 4},      {"mode", 12, 1},
    {"flags", 13, 1},          {"last_status", 14, 1},        {"frames_processed", 15, 4},
    {"frames_refused", 19, 4}, {"frames_incomplete", 23, 4},  {"frames_lost", 27, 4},
    {"camera_losses", 31, 2},  {"features", 33, 2},           {"matched", 35, 2},
    {"inliers", 37, 2},        {"refused_updates", 39, 4},    {"covariance_repairs", 43, 4},
    {"reset_counter", 47, 2},  {"test_ratio", 49, 4},         {"telemetry_dropped", 53, 4},
    {"event_count", 57, 4},    {"events_suppressed", 61, 4},  {"latency_us", 65, 4},
    {"latency_max_us", 69, 4}, {"arrival_latency_us", 73, 4}, {"arrival_latency_max_us", 77, 4}};
const std::vector<Place> event_places{{"event_id", 0, 2}, {"occurrence", 2, 4}, {"suppressed", 6, 4},
                                      {"status", 10, 1},  {"time_ns", 11, 8},   {"frame_sequence", 19, 4},
                                      {"args", 23, 32}};
const std::vector<Place> time_places{
    {"time_ns", 0, 8},       {"tai_ns", 8, 8},          {"drift_ppb", 16, 4},         {"residual_ns", 20, 4},
    {"pulse_age_ms", 24, 4}, {"pulses_used", 28, 4},    {"pulses_missed", 32, 4},     {"pulses_refused", 36, 4},
    {"sync", 40, 1},         {"seconds_source", 41, 1}, {"exposure_offset_ns", 42, 4}};
/// The first four: PUS request identifier.
const std::vector<Place> command_ack_places{
    {"request_packet_id", 0, 2}, {"request_sequence", 2, 2}, {"stage", 4, 1},  {"code", 5, 1},
    {"service", 6, 1},           {"subtype", 7, 1},          {"time_ns", 8, 8}};
const std::vector<Place> pong_places{{"time_ns", 0, 8}};

/// Bytes of the field with all bits set as packet_samples::fill() does, and zero.
void check_bytes(std::span<const std::uint8_t> bytes, bool ones, const FieldDefinition& field) {
  const std::array<std::uint8_t, 8> latest_time{0x3B, 0x9A, 0xC9, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
  const std::size_t step = size_of(field.type);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::uint8_t expected = ones ? 0xFF : 0;
    if (ones && field.type == FieldType::f64) expected = i % step == 0 ? 0x7F : i % step == 1 ? 0xEF : 0xFF;
    if (ones && field.type == FieldType::f32) expected = i % step == 0 ? 0x7F : i % step == 1 ? 0x7F : 0xFF;
    if (ones && field.type == FieldType::u64) expected = latest_time[i % step];
    UNSIGNED_LONGS_EQUAL_TEXT(expected, bytes[i], field.name);
  }
}

void check_table(std::span<const FieldDefinition> fields, const std::vector<Place>& places) {
  LONGS_EQUAL(places.size(), fields.size());
  std::size_t offset = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    STRCMP_EQUAL(places[i].name, fields[i].name);
    LONGS_EQUAL_TEXT(places[i].offset, offset, places[i].name);
    LONGS_EQUAL_TEXT(places[i].bytes, size_of(fields[i]), places[i].name);
    offset += size_of(fields[i]);
  }
}

/// Sets one field at a time against a background of zeros, then of ones: only its own bytes may differ from the background.
template <typename Packet, typename Value, typename Fields>
void walk(Packet& packet, Value& value, const Fields& fields, std::span<const FieldDefinition> definitions,
          const std::vector<Place>& places, std::size_t body_start) {
  for (const bool ones : {false, true}) {
    for (std::size_t target = 0; target < places.size(); ++target) {
      packet_samples::fill_all(fields, value, ones);
      std::size_t index = 0;
      std::apply(
          [&](const auto&... f) {
            const auto set = [&](auto& member) {
              if (index++ != target) return;
              member = {};
              if (!ones) packet_samples::fill(member);
            };
            (set(value.*(f.member)), ...);
          },
          fields);
      if constexpr (requires { packet.event_id; }) packet.event_id = static_cast<std::uint16_t>(EventId::frame_gap);
      if constexpr (requires { packet.stage; }) packet.stage = static_cast<std::uint8_t>(CommandStage::failed);
      if constexpr (requires { packet.parts; }) {
        if (packet.part >= packet.parts) continue;  // refused by encode(): seen by CodecRefuses
      }
      PacketContext context;
      Buffer buffer{};
      const auto size = encode(packet, context, buffer);
      CHECK_TRUE(size.has_value());
      for (std::size_t i = 0; i < places.size(); ++i) {
        if (std::strcmp(places[i].name, "event_id") == 0 || std::strcmp(places[i].name, "stage") == 0) continue;
        check_bytes(std::span<const std::uint8_t>(buffer).subspan(body_start + places[i].offset, places[i].bytes),
                    (i == target) != ones, definitions[i]);
      }
    }
  }
}

}  // namespace

TEST_GROUP(TelemetryLayout){};

TEST(TelemetryLayout, RelStateTable) { check_table(rel_state_field_definitions, rel_state_places); }
TEST(TelemetryLayout, FeaturesTable) { check_table(features_field_definitions, features_places); }
TEST(TelemetryLayout, FeatureEntryTable) { check_table(feature_entry_field_definitions, feature_entry_places); }
TEST(TelemetryLayout, HealthTable) { check_table(health_field_definitions, health_places); }
TEST(TelemetryLayout, EventTable) { check_table(event_field_definitions, event_places); }
TEST(TelemetryLayout, TimeTable) { check_table(time_field_definitions, time_places); }
TEST(TelemetryLayout, CommandAckTable) { check_table(command_ack_field_definitions, command_ack_places); }
TEST(TelemetryLayout, PongTable) { check_table(pong_field_definitions, pong_places); }

TEST(TelemetryLayout, RelStateFieldsMoveOnlyTheirOwnBits) {
  RelStatePacket packet;
  walk(packet, packet, rel_state_fields, rel_state_field_definitions, rel_state_places, 21);
}

TEST(TelemetryLayout, HealthFieldsMoveOnlyTheirOwnBits) {
  HealthPacket packet;
  walk(packet, packet, health_fields, health_field_definitions, health_places, 21);
}

TEST(TelemetryLayout, EventFieldsMoveOnlyTheirOwnBits) {
  EventPacket packet;
  walk(packet, packet, event_fields, event_field_definitions, event_places, 19);
}

TEST(TelemetryLayout, TimeFieldsMoveOnlyTheirOwnBits) {
  TimePacket packet;
  walk(packet, packet, time_fields, time_field_definitions, time_places, 21);
}

TEST(TelemetryLayout, CommandAckFieldsMoveOnlyTheirOwnBits) {
  CommandAckPacket packet;
  walk(packet, packet, command_ack_fields, command_ack_field_definitions, command_ack_places, 19);
}

TEST(TelemetryLayout, PongFieldsMoveOnlyTheirOwnBits) {
  PongPacket packet;
  walk(packet, packet, pong_fields, pong_field_definitions, pong_places, 19);
}

TEST(TelemetryLayout, FeaturesFieldsMoveOnlyTheirOwnBits) {
  FeaturesPacket packet;
  walk(packet, packet, features_fields, features_field_definitions, features_places, 21);
}

TEST(TelemetryLayout, FeatureEntryFieldsMoveOnlyTheirOwnBits) {
  FeaturesPacket packet;
  for (int i = 0; i < 3; ++i) CHECK_TRUE(packet.entries.push_back({}) == Status::ok);
  walk(packet, packet.entries[1], feature_entry_fields, feature_entry_field_definitions, feature_entry_places,
       21 + 18 + 17);
  PacketContext context;
  Buffer buffer{};
  CHECK_TRUE(encode(packet, context, buffer).has_value());
  for (std::size_t i = 0; i < 17; ++i) {  // the neighbours never moved
    LONGS_EQUAL(0, buffer[21 + 18 + i]);
    LONGS_EQUAL(0, buffer[21 + 18 + 34 + i]);
  }
}

TEST(TelemetryLayout, SizesOfPackets) {
  LONGS_EQUAL(21 + 2 + 293, packet_size(definition_of(PacketId::rel_state)));
  LONGS_EQUAL(21 + 2 + 16 + 2, packet_size(definition_of(PacketId::features)));
  LONGS_EQUAL(21 + 2 + 16 + 2 + 64 * 17, packet_size(definition_of(PacketId::features), 64));
  LONGS_EQUAL(21 + 2 + 81, packet_size(definition_of(PacketId::health)));
  LONGS_EQUAL(21 + 55, packet_size(definition_of(PacketId::event)));
  LONGS_EQUAL(21 + 2 + 46, packet_size(definition_of(PacketId::time)));
  LONGS_EQUAL(21 + 16, packet_size(definition_of(PacketId::command_ack)));
  LONGS_EQUAL(21 + 8, packet_size(definition_of(PacketId::pong)));
}

TEST(TelemetryLayout, FullestPacketsStayWithinTheLimit) {
  FeaturesPacket packet;
  for (std::uint16_t i = 0; i < max_features_per_packet; ++i) {
    CHECK_TRUE(packet.entries.push_back(packet_samples::feature(i)) == Status::ok);
  }
  PacketContext context;
  Buffer buffer{};
  const auto size = encode(packet, context, buffer);
  CHECK_TRUE(size.has_value());
  CHECK_TRUE(size.value() <= 1400);
  for (const PacketDefinition& definition : packet_definitions) {
    CHECK_TRUE(packet_size(definition, definition.max_entries) <= 1400);
  }
}

TEST(TelemetryLayout, NamesAreUniqueAndTexted) {
  for (const PacketDefinition& definition : packet_definitions) {
    for (const auto fields : {definition.fields, definition.entry_fields}) {
      for (std::size_t i = 0; i < fields.size(); ++i) {
        CHECK_TRUE(std::strlen(fields[i].name) > 0);
        CHECK_TRUE(std::strlen(fields[i].description) > 0);
        for (std::size_t k = 0; k < i; ++k) CHECK_TRUE(std::strcmp(fields[i].name, fields[k].name) != 0);
        if (fields[i].labels.kind != LabelKind::none) CHECK_FALSE(fields[i].labels.items.empty());
      }
    }
  }
}
