#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "fsw/base/generator.hpp"
#include "fsw/telemetry/codec.hpp"
#include "fsw/telemetry/visit.hpp"
#include "tests/unit/telemetry/packet_samples.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav::telemetry;
using packet_samples::Buffer;
using relnav::Status;

namespace {

void randomize(relnav::Generator& g, double& x) { x = (g.uniform() - 0.5) * 1e3; }
void randomize(relnav::Generator& g, float& x) { x = static_cast<float>(g.uniform() - 0.5); }
template <typename T>
requires std::is_integral_v<T>
void randomize(relnav::Generator& g, T& x) {
  x = static_cast<T>((static_cast<std::uint64_t>(g.next()) << 32U) | g.next());
}
template <typename T, std::size_t N>
void randomize(relnav::Generator& g, std::array<T, N>& xs) {
  for (T& x : xs) randomize(g, x);
}
template <typename Fields, typename Value>
void randomize_all(relnav::Generator& g, const Fields& fields, Value& value) {
  std::apply([&](const auto&... f) { (randomize(g, value.*(f.member)), ...); }, fields);
}
template <typename Fields, typename Value>
bool equal(const Fields& fields, const Value& a, const Value& b) {
  bool same = true;
  std::apply([&](const auto&... f) { ((same = same && a.*(f.member) == b.*(f.member)), ...); }, fields);
  return same;
}

/// Every place of `fields` that holds a float, one after the other, set to each value that is not finite: encode() must refuse.
template <typename Packet, typename Value, typename Fields>
int refuses_not_finite(Packet& packet, Value& value, const Fields& fields) {
  int refused = 0;
  PacketContext context;
  Buffer buffer{};
  buffer.fill(0x55);
  const auto try_number = [&](auto& x) {
    using T = std::remove_reference_t<decltype(x)>;
    if constexpr (std::is_floating_point_v<T>) {
      const T saved = x;
      for (const T bad : {std::numeric_limits<T>::quiet_NaN(), -std::numeric_limits<T>::quiet_NaN(),
                          std::numeric_limits<T>::infinity(), -std::numeric_limits<T>::infinity()}) {
        x = bad;
        CHECK_TRUE(encode(packet, context, buffer).status() == Status::not_finite);
        ++refused;
      }
      x = saved;
    }
  };
  const auto try_member = [&](auto& member) {
    if constexpr (requires { member.size(); }) {
      for (auto& x : member) try_number(x);
    } else {
      try_number(member);
    }
  };
  std::apply([&](const auto&... f) { (try_member(value.*(f.member)), ...); }, fields);
  for (const std::uint8_t byte : buffer) LONGS_EQUAL(0x55, byte);  // nothing was written
  return refused;
}

template <typename Packet>
void check_small_buffers(const Packet& packet, std::size_t size) {
  for (std::size_t capacity = 0; capacity < size; ++capacity) {
    PacketContext context;
    Buffer buffer{};
    buffer.fill(0x55);
    CHECK_TRUE(encode(packet, context, std::span<std::uint8_t>(buffer).first(capacity)).status() ==
               Status::no_capacity);
    for (const std::uint8_t byte : buffer) CHECK_TRUE(byte == 0x55);
    for (std::size_t i = 0; i < packet_count; ++i) LONGS_EQUAL(0, context.sequence_count(static_cast<PacketId>(i)));
  }
  PacketContext context;
  Buffer buffer{};
  buffer.fill(0x55);
  LONGS_EQUAL(size, encode(packet, context, std::span<std::uint8_t>(buffer).first(size)).value());
  LONGS_EQUAL(0x55, buffer[size]);
}

}  // namespace

TEST_GROUP(TelemetryCodec) {
  PacketContext context;
  PacketConfig config;
  Buffer buffer{};
  RelStatePacket rel_state;
  FeaturesPacket features;
  HealthPacket health;
  EventPacket event;
  TimePacket time;
  CommandAckPacket ack;
  PongPacket pong;

  void setup() override { event.event_id = static_cast<std::uint16_t>(EventId::frame_gap); }
  template <typename Packet>
  std::span<std::uint8_t> encoded(const Packet& packet) {
    const auto size = encode(packet, context, buffer);
    CHECK_TRUE(size.has_value());
    return std::span<std::uint8_t>(buffer).first(size.value());
  }
};

TEST(TelemetryCodec, RandomPacketsComeBackUnchanged) {
  relnav::Generator g(7);
  for (int i = 0; i < 500; ++i) {
    randomize_all(g, rel_state_fields, rel_state);
    rel_state.time_ns = g.next();
    if (rel_state.q_CT[3] < 0.0) rel_state.q_CT[3] = -rel_state.q_CT[3];
    RelStatePacket rel_state_read;
    CHECK_TRUE(decode(encoded(rel_state), config, rel_state_read) == Status::ok);
    CHECK_TRUE(equal(rel_state_fields, rel_state, rel_state_read));

    randomize_all(g, health_fields, health);
    health.time_ns = g.next();
    HealthPacket health_read;
    CHECK_TRUE(decode(encoded(health), config, health_read) == Status::ok);
    CHECK_TRUE(equal(health_fields, health, health_read));

    randomize_all(g, event_fields, event);
    event.time_ns = g.next();
    event.event_id = static_cast<std::uint16_t>(1 + g.below(event_definitions.size()));
    EventPacket event_read;
    CHECK_TRUE(decode(encoded(event), config, event_read) == Status::ok);
    CHECK_TRUE(equal(event_fields, event, event_read));

    randomize_all(g, time_fields, time);
    time.time_ns = g.next();
    TimePacket time_read;
    CHECK_TRUE(decode(encoded(time), config, time_read) == Status::ok);
    CHECK_TRUE(equal(time_fields, time, time_read));

    randomize_all(g, command_ack_fields, ack);
    ack.time_ns = g.next();
    ack.stage = std::array<std::uint8_t, 4>{1, 2, 7, 8}[g.below(4)];
    CommandAckPacket ack_read;
    CHECK_TRUE(decode(encoded(ack), config, ack_read) == Status::ok);
    CHECK_TRUE(equal(command_ack_fields, ack, ack_read));

    pong.time_ns = g.next();
    PongPacket pong_read;
    CHECK_TRUE(decode(encoded(pong), config, pong_read) == Status::ok);
    CHECK_TRUE(equal(pong_fields, pong, pong_read));

    randomize_all(g, features_fields, features);
    features.time_ns = g.next();
    features.parts = static_cast<std::uint8_t>(1 + g.below(255));
    features.part = static_cast<std::uint8_t>(g.below(features.parts));
    features.entries.clear();
    const std::uint32_t n = g.below(65);
    for (std::uint32_t k = 0; k < n; ++k) {
      FeatureEntry entry;
      randomize_all(g, feature_entry_fields, entry);
      CHECK_TRUE(features.entries.push_back(entry) == Status::ok);
    }
    FeaturesPacket features_read;
    CHECK_TRUE(decode(encoded(features), config, features_read) == Status::ok);
    CHECK_TRUE(equal(features_fields, features, features_read));
    LONGS_EQUAL(n, features_read.entries.size());
    for (std::uint32_t k = 0; k < n; ++k) {
      CHECK_TRUE(equal(feature_entry_fields, features.entries[k], features_read.entries[k]));
    }
  }
}

TEST(TelemetryCodec, SameInputSameBytes) {
  PacketContext other;
  Buffer second{};
  const auto size = encode(rel_state, context, buffer);
  CHECK_TRUE(encode(rel_state, other, second).value() == size.value());
  MEMCMP_EQUAL(buffer.data(), second.data(), buffer.size());
}

TEST(TelemetryCodec, NotFiniteIsRefusedInEveryFloatField) {
  LONGS_EQUAL(4 * (3 + 4 + 3 + 3 + 21 + 21), refuses_not_finite(rel_state, rel_state, rel_state_fields));
  LONGS_EQUAL(4 * 1, refuses_not_finite(health, health, health_fields));
  for (int i = 0; i < 3; ++i) CHECK_TRUE(features.entries.push_back({}) == Status::ok);
  LONGS_EQUAL(4 * 1, refuses_not_finite(features, features.entries[2], feature_entry_fields));
}

TEST(TelemetryCodec, RefusedPacketUsesNoSequenceCount) {
  rel_state.t_CT[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK_TRUE(encode(rel_state, context, buffer).status() == Status::not_finite);
  LONGS_EQUAL(0, context.sequence_count(PacketId::rel_state));
  LONGS_EQUAL(0, context.message_count(PacketId::rel_state, 25));
}

TEST(TelemetryCodec, SmallBuffersAreRefusedUntouched) {
  check_small_buffers(rel_state, packet_size(definition_of(PacketId::rel_state)));
  check_small_buffers(health, packet_size(definition_of(PacketId::health)));
  check_small_buffers(event, packet_size(definition_of(PacketId::event)));
  check_small_buffers(time, packet_size(definition_of(PacketId::time)));
  check_small_buffers(ack, packet_size(definition_of(PacketId::command_ack)));
  check_small_buffers(pong, packet_size(definition_of(PacketId::pong)));
  for (std::uint16_t i = 0; i < 5; ++i)
    CHECK_TRUE(features.entries.push_back(packet_samples::feature(i)) == Status::ok);
  check_small_buffers(features, packet_size(definition_of(PacketId::features), 5));
}

TEST(TelemetryCodec, QuaternionGoesOutWithWNotNegative) {
  rel_state.q_CT = {0.1, -0.5, 0.5, -0.7};
  RelStatePacket read;
  CHECK_TRUE(decode(encoded(rel_state), config, read) == Status::ok);
  DOUBLES_EQUAL(-0.1, read.q_CT[0], 0.0);
  DOUBLES_EQUAL(0.5, read.q_CT[1], 0.0);
  DOUBLES_EQUAL(-0.5, read.q_CT[2], 0.0);
  DOUBLES_EQUAL(0.7, read.q_CT[3], 0.0);
}

TEST(TelemetryCodec, EventsGoOutUnderTheirSeverity) {
  for (const EventDefinition& definition : event_definitions) {
    event.event_id = static_cast<std::uint16_t>(definition.id);
    const auto bytes = encoded(event);
    LONGS_EQUAL(5, bytes[7]);
    LONGS_EQUAL(static_cast<int>(definition.severity), bytes[8]);
  }
}

TEST(TelemetryCodec, UnknownEventIsRefused) {
  for (const std::uint16_t id :
       {std::uint16_t{0}, static_cast<std::uint16_t>(event_definitions.size() + 1), std::uint16_t{0xFFFF}}) {
    event.event_id = id;
    CHECK_TRUE(encode(event, context, buffer).status() == Status::invalid_argument);
  }
}

TEST(TelemetryCodec, EventUnderTheWrongSeverityIsRefused) {
  const auto bytes = encoded(event);
  bytes[8] = 4;
  packet_samples::seal(bytes);
  EventPacket read;
  CHECK_TRUE(decode(bytes, config, read) == Status::invalid_argument);
}

TEST(TelemetryCodec, AcksGoOutUnderTheirStage) {
  for (unsigned stage = 0; stage < 256; ++stage) {
    ack.stage = static_cast<std::uint8_t>(stage);
    const bool exists = stage == 1 || stage == 2 || stage == 7 || stage == 8;
    const auto size = encode(ack, context, buffer);
    CHECK_TRUE(size.has_value() == exists);
    if (!exists) {
      CHECK_TRUE(size.status() == Status::invalid_argument);
      continue;
    }
    LONGS_EQUAL(1, buffer[7]);
    LONGS_EQUAL(stage, buffer[8]);
    LONGS_EQUAL(1, context.message_count(PacketId::command_ack, ack.stage));
  }
  LONGS_EQUAL(4, context.sequence_count(PacketId::command_ack));
}

TEST(TelemetryCodec, AckUnderAnotherSubtypeThanItsStageIsRefused) {
  const auto with = [&](std::uint8_t subtype, std::uint8_t stage) {
    const auto bytes = encoded(ack);
    bytes[8] = subtype;
    bytes[19 + 4] = stage;
    packet_samples::seal(bytes);
    CommandAckPacket read;
    return decode(bytes, config, read);
  };
  CHECK_TRUE(with(2, 2) == Status::ok);
  CHECK_TRUE(with(2, 1) == Status::invalid_argument);
  CHECK_TRUE(with(3, 3) == Status::invalid_argument);  // no stage of ours
  CHECK_TRUE(with(9, 9) == Status::unsupported);
}

TEST(TelemetryCodec, EveryMessageTypeHasItsOwnCount) {
  for (const PacketDefinition& p : packet_definitions) {
    for (std::uint8_t subtype = p.subtype_first; subtype <= p.subtype_last; ++subtype) context.advance(p.id, subtype);
  }
  for (const PacketDefinition& p : packet_definitions) {
    for (std::uint8_t subtype = p.subtype_first; subtype <= p.subtype_last; ++subtype) {
      LONGS_EQUAL(1, context.message_count(p.id, subtype));
    }
  }
}

TEST(TelemetryCodec, EventOfANewerTableIsUnsupported) {
  const auto bytes = encoded(event);
  bytes[20] = 200;
  packet_samples::seal(bytes);
  EventPacket read;
  CHECK_TRUE(decode(bytes, config, read) == Status::unsupported);
}

TEST(TelemetryCodec, PartMustBeOneOfTheParts) {
  features.part = 1;
  CHECK_TRUE(encode(features, context, buffer).status() == Status::invalid_argument);
  features.parts = 2;
  const auto bytes = encoded(features);
  bytes[21 + 13] = 1;  // parts
  packet_samples::seal(bytes);
  CHECK_TRUE(decode(bytes, config, features) == Status::invalid_argument);
}

TEST(TelemetryCodec, TruncatedPacketsAreIncomplete) {
  const auto bytes = encoded(rel_state);
  RelStatePacket read;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    CHECK_TRUE(decode(bytes.first(length), config, read) == Status::incomplete);
  }
}

TEST(TelemetryCodec, BytesAfterThePacketAreRefused) {
  const auto bytes = encoded(rel_state);
  RelStatePacket read;
  CHECK_TRUE(decode(std::span<const std::uint8_t>(buffer).first(bytes.size() + 1), config, read) == Status::incomplete);
}

TEST(TelemetryCodec, EveryFlippedBitIsRefusedAndLeavesTheResultAlone) {
  const auto bytes = encoded(health);
  HealthPacket read;
  read.frames_processed = 4711;
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    const Status status = decode(bytes, config, read);
    CHECK_TRUE(status == (bit / 8 == 4 || bit / 8 == 5 ? Status::incomplete : Status::crc_mismatch));
    LONGS_EQUAL(4711, read.frames_processed);
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
  }
  CHECK_TRUE(decode(bytes, config, read) == Status::ok);
}

TEST(TelemetryCodec, NotFiniteInAReceivedPacketIsRefused) {
  const auto bytes = encoded(rel_state);
  bytes[21 + 21] = 0x7F;  // t_CT x: infinity
  bytes[21 + 22] = 0xF0;
  packet_samples::seal(bytes);
  RelStatePacket read;
  CHECK_TRUE(decode(bytes, config, read) == Status::not_finite);
}

TEST(TelemetryCodec, AnotherPacketIsNotTheOneAskedFor) {
  HealthPacket read;
  CHECK_TRUE(decode(encoded(rel_state), config, read) == Status::invalid_argument);
}

TEST(TelemetryCodec, PacketsOutsideTheTableAreUnsupported) {
  HealthPacket read;
  const auto with_byte = [&](std::size_t at, std::uint8_t value) {
    const auto bytes = encoded(health);
    bytes[at] = value;
    packet_samples::seal(bytes);
    return decode(bytes, config, read);
  };
  CHECK_TRUE(with_byte(1, 0x07) == Status::unsupported);  // first APID above
  CHECK_TRUE(with_byte(0, 0x08) == Status::unsupported);  // APID below
  CHECK_TRUE(with_byte(7, 5) == Status::unsupported);     // service
  CHECK_TRUE(with_byte(8, 24) == Status::unsupported);    // subtype
  CHECK_TRUE(with_byte(8, 26) == Status::unsupported);
  CHECK_TRUE(with_byte(20, 1) == Status::unsupported);  // structure id
  CHECK_TRUE(with_byte(20, 3) == Status::ok);
}

TEST(TelemetryCodec, OtherApidBaseIsNotOurs) {
  HealthPacket read;
  CHECK_TRUE(context.configure({.apid_base = 0x200}) == Status::ok);
  const auto bytes = encoded(health);
  CHECK_TRUE(decode(bytes, config, read) == Status::unsupported);
  config.apid_base = 0x200;
  CHECK_TRUE(decode(bytes, config, read) == Status::ok);
}

TEST(TelemetryCodec, BodyOfAnotherSizeIsIncomplete) {
  const auto resized = [&](int change) {
    const auto bytes = encoded(health);
    const auto size = static_cast<std::size_t>(static_cast<int>(bytes.size()) + change);
    buffer[5] = static_cast<std::uint8_t>(size - 7);
    const auto other = std::span<std::uint8_t>(buffer).first(size);
    packet_samples::seal(other);
    HealthPacket read;
    return decode(other, config, read);
  };
  CHECK_TRUE(resized(-1) == Status::incomplete);
  CHECK_TRUE(resized(1) == Status::incomplete);
  CHECK_TRUE(resized(0) == Status::ok);
  CHECK_TRUE(resized(21 - 104) == Status::incomplete);  // headers and CRC only
}

TEST(TelemetryCodec, EntryCountThatDoesNotFitTheBodyIsIncomplete) {
  for (std::uint16_t i = 0; i < 4; ++i)
    CHECK_TRUE(features.entries.push_back(packet_samples::feature(i)) == Status::ok);
  const auto bytes = encoded(features);
  for (const unsigned count : {0U, 3U, 5U, 65U, 0xFFFFU}) {
    bytes[21 + 16] = static_cast<std::uint8_t>(count >> 8U);
    bytes[21 + 17] = static_cast<std::uint8_t>(count & 0xFFU);
    packet_samples::seal(bytes);
    CHECK_TRUE(open_packet(bytes, config).status() == Status::incomplete);
  }
}

TEST(TelemetryCodec, RandomBytesNeverPassTheCrc) {
  relnav::Generator g(99);
  RelStatePacket read;
  int opened = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::size_t size = g.below(1400);
    for (std::size_t k = 0; k < size; ++k) buffer[k] = static_cast<std::uint8_t>(g.next() & 0xFFU);
    opened += decode(std::span<const std::uint8_t>(buffer).first(size), config, read) == Status::ok ? 1 : 0;
  }
  LONGS_EQUAL(0, opened);
}

TEST(TelemetryCodec, VisitorGivesEveryNumberInOrder) {
  for (std::uint16_t i = 0; i < 2; ++i)
    CHECK_TRUE(features.entries.push_back(packet_samples::feature(i)) == Status::ok);
  features.features_total = 2;
  const auto opened = open_packet(encoded(features), config);
  CHECK_TRUE(opened.has_value());
  LONGS_EQUAL(2, opened.value().entries);
  STRCMP_EQUAL("FEATURES", opened.value().definition->name);
  int fixed = 0;
  int in_entries = 0;
  std::int64_t sum_v = 0;
  for_each_field(opened.value(),
                 [&](const FieldDefinition& field, std::int32_t entry, std::uint16_t, const FieldValue& value) {
                   (entry == no_entry ? fixed : in_entries) += 1;
                   if (std::string_view(field.name) == "v_px_256") sum_v += value.as_signed;
                 });
  LONGS_EQUAL(5, fixed);
  LONGS_EQUAL(12, in_entries);
  LONGS_EQUAL(-128 - 129, sum_v);
}

TEST(TelemetryCodec, PixelsTo256thsRoundAndSaturate) {
  LONGS_EQUAL(0, to_px_256(0.0));
  LONGS_EQUAL(-128, to_px_256(-0.5));
  LONGS_EQUAL(262144, to_px_256(1024.0));
  LONGS_EQUAL(1, to_px_256(0.5 / 256.0));
  LONGS_EQUAL(-1, to_px_256(-0.5 / 256.0));
  LONGS_EQUAL(0, to_px_256(0.49 / 256.0));
  LONGS_EQUAL(std::numeric_limits<std::int32_t>::max(), to_px_256(1e300));
  LONGS_EQUAL(std::numeric_limits<std::int32_t>::min(), to_px_256(-1e300));
  LONGS_EQUAL(0, to_px_256(std::numeric_limits<double>::quiet_NaN()));
}

TEST(TelemetryCodec, EventTableIsComplete) {
  for (std::size_t i = 0; i < event_definitions.size(); ++i) {
    const EventDefinition& definition = event_definitions[i];
    CHECK_TRUE(find_event(static_cast<std::uint16_t>(i + 1)) == &definition);
    CHECK_TRUE(&definition_of(definition.id) == &definition);
    CHECK_TRUE(std::string_view(definition.name).size() > 0);
    CHECK_TRUE(std::string_view(definition.description).size() > 0);
    for (std::size_t k = 0; k < i; ++k) {
      CHECK_TRUE(std::string_view(definition.name) != std::string_view(event_definitions[k].name));
    }
  }
  CHECK_TRUE(find_event(0) == nullptr);
  CHECK_TRUE(find_event(static_cast<std::uint16_t>(event_definitions.size() + 1)) == nullptr);
}
