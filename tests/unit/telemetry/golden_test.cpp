/// Packets made by golden/make_golden.py from the ICD, without any of our code.
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "fsw/telemetry/codec.hpp"
#include "fsw/telemetry/visit.hpp"
#include "tests/unit/telemetry/packet_samples.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav::telemetry;
using relnav::Status;

namespace {

struct Golden {
  std::vector<std::uint8_t> bytes;
  std::vector<std::string> fields;  ///< "name value"
};

Golden load(const std::string& name) {
  std::ifstream file(std::string(RELNAV_SOURCE_DIR "/tests/unit/telemetry/golden/") + name + ".txt");
  CHECK_TRUE(file.is_open());
  Golden golden;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    if (line.rfind("hex ", 0) != 0) {
      golden.fields.push_back(line);
      continue;
    }
    for (std::size_t i = 4; i + 1 < line.size(); i += 2) {
      golden.bytes.push_back(static_cast<std::uint8_t>(std::stoul(line.substr(i, 2), nullptr, 16)));
    }
  }
  return golden;
}

/// The value that a golden line states, read as the type of the field.
bool same_value(const std::string& text, const FieldValue& value) {
  switch (value.type) {
    case FieldType::u8:
    case FieldType::u16:
    case FieldType::u32:
    case FieldType::u64: return std::strtoull(text.c_str(), nullptr, 10) == value.as_unsigned;
    case FieldType::i16:
    case FieldType::i32:
    case FieldType::i64: return std::strtoll(text.c_str(), nullptr, 10) == value.as_signed;
    case FieldType::f32:
    case FieldType::f64:
      return std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)) ==
             std::bit_cast<std::uint64_t>(value.as_double);
  }
  return false;
}

}  // namespace

TEST_GROUP(TelemetryGolden) {
  PacketConfig config{.apid_base = 0x123,
                      .destination_id = 0x0B0C,
                      .time_reference_status = 5,
                      .epoch_offset_ns = unix_epoch_since_1958_ns + 37'000'000'000LL};

  void check_fields(const Golden& golden, PacketId id) {
    const auto opened = open_packet(golden.bytes, config);
    CHECK_TRUE(opened.has_value());
    CHECK_TRUE(opened.value().definition->id == id);
    LONGS_EQUAL(3, opened.value().header.sequence_count);
    LONGS_EQUAL(3, opened.value().header.message_count);
    std::size_t line = 0;
    for_each_field(opened.value(), [&](const FieldDefinition& field, std::int32_t entry, std::uint16_t element,
                                       const FieldValue& value) {
      std::ostringstream text;
      if (entry != no_entry) text << "entry" << entry << '.';
      text << field.name;
      if (field.count > 1) text << '[' << element << ']';
      const std::string name = text.str();
      CHECK_TRUE(line < golden.fields.size());
      const std::string& expected = golden.fields[line];
      const std::size_t space = expected.find(' ');
      STRCMP_EQUAL(expected.substr(0, space).c_str(), name.c_str());
      CHECK_TRUE_TEXT(same_value(expected.substr(space + 1), value), name.c_str());
      ++line;
    });
    LONGS_EQUAL(golden.fields.size(), line);
  }

  template <typename Packet>
  Packet check(const char* name, PacketId id, std::uint8_t subtype) {
    const Golden golden = load(name);
    check_fields(golden, id);
    Packet packet;
    CHECK_TRUE(decode(golden.bytes, config, packet) == Status::ok);
    PacketContext context;
    CHECK_TRUE(context.configure(config) == Status::ok);
    for (int i = 0; i < 3; ++i) context.advance(id, subtype);
    packet_samples::Buffer buffer{};
    const auto size = encode(packet, context, buffer);
    CHECK_TRUE(size.has_value());
    LONGS_EQUAL(golden.bytes.size(), size.value());
    MEMCMP_EQUAL(golden.bytes.data(), buffer.data(), golden.bytes.size());
    return packet;
  }
};

TEST(TelemetryGolden, RelState) {
  const auto packet = check<RelStatePacket>("rel_state", PacketId::rel_state, 25);
  DOUBLES_EQUAL(30.5, packet.t_CT[2], 0.0);
  DOUBLES_EQUAL(0.7, packet.q_CT[3], 0.0);
  DOUBLES_EQUAL(-0.004, packet.omega_C[1], 0.0);
  DOUBLES_EQUAL(10.25, static_cast<double>(packet.pose_covariance[20]), 0.0);
}
TEST(TelemetryGolden, Features) {
  const auto packet = check<FeaturesPacket>("features", PacketId::features, 26);
  LONGS_EQUAL(2, packet.entries.size());
  LONGS_EQUAL(65, packet.entries[1].slot);
}
TEST(TelemetryGolden, Health) {
  const auto packet = check<HealthPacket>("health", PacketId::health, 25);
  LONGS_EQUAL(100001, packet.frames_processed);
  LONGS_EQUAL(21, packet.events_suppressed);
  UNSIGNED_LONGS_EQUAL(4294967295, packet.latency_max_us);
  LONGS_EQUAL(25, packet.arrival_latency_max_us);
}
TEST(TelemetryGolden, Event) {
  const auto packet = check<EventPacket>("event", PacketId::event, 2);
  LONGS_EQUAL(4, packet.event_id);
  CHECK_TRUE(packet.args[3] == std::numeric_limits<std::int64_t>::min());
}
TEST(TelemetryGolden, Time) {
  const auto packet = check<TimePacket>("time", PacketId::time, 25);
  CHECK_TRUE(packet.tai_ns == 2'078'691'237'000'000'000ULL);
  LONGS_EQUAL(-20000, packet.drift_ppb);
  LONGS_EQUAL(-33, packet.exposure_offset_ns);
}
TEST(TelemetryGolden, CommandAck) {
  const auto packet = check<CommandAckPacket>("command_ack", PacketId::command_ack, 8);
  LONGS_EQUAL(0x1923, packet.request_packet_id);
  LONGS_EQUAL(128, packet.subtype);
}
TEST(TelemetryGolden, Pong) { CHECK_TRUE(check<PongPacket>("pong", PacketId::pong, 2).time_ns > 0); }
