#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "fsw/telemetry/codec.hpp"
#include "tests/unit/telemetry/packet_samples.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav::telemetry;
using packet_samples::Buffer;
using relnav::Status;

namespace {
constexpr std::size_t health_bytes = packet_size(definition_of(PacketId::health));
}

TEST_GROUP(TelemetryHeader) {
  PacketContext context;
  HealthPacket packet;
  Buffer buffer{};
  PacketHeader header;

  std::span<std::uint8_t> bytes() { return std::span<std::uint8_t>(buffer).first(health_bytes); }
  void encode_health() { CHECK_TRUE(encode(packet, context, buffer).value() == health_bytes); }
  Status configure(PacketConfig config) { return context.configure(config); }

  /// A packet of nothing but zeros (or ones) in every bit of its headers that may vary.
  void background(bool ones) {
    buffer.fill(0);
    const std::array<std::uint8_t, 19> zeros{0x08, 0, 0xC0, 0, 0, health_bytes - 7, 0x20};
    const std::array<std::uint8_t, 19> all_ones{
        0x0F, 0xFF, 0xFF, 0xFF, 0,   health_bytes - 7, 0x2F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
        0xFF, 0xFF, 0xFF, 0xFF, 0xFF};
    const auto& from = ones ? all_ones : zeros;
    for (std::size_t i = 0; i < from.size(); ++i) buffer[i] = from[i];
  }
  /// Inverts the bits of `mask` at byte `at` and gives the header as it is then read, all fields xor-ed with the background's.
  PacketHeader difference(bool ones, std::size_t at, std::uint32_t mask, std::size_t width) {
    background(ones);
    packet_samples::seal(bytes());
    PacketHeader before;
    CHECK_TRUE(read_header(bytes(), before) == Status::ok);
    for (std::size_t i = 0; i < width; ++i) {
      buffer[at + i] = static_cast<std::uint8_t>(buffer[at + i] ^ ((mask >> (8 * (width - 1 - i))) & 0xFFU));
    }
    packet_samples::seal(bytes());
    PacketHeader after;
    CHECK_TRUE(read_header(bytes(), after) == Status::ok);
    const auto x16 = [](unsigned a, unsigned b) { return static_cast<std::uint16_t>(a ^ b); };
    const auto x8 = [](unsigned a, unsigned b) { return static_cast<std::uint8_t>(a ^ b); };
    return {x16(before.apid, after.apid),
            x16(before.sequence_count, after.sequence_count),
            x16(before.data_length, after.data_length),
            x8(before.time_reference_status, after.time_reference_status),
            x8(before.service, after.service),
            x8(before.subtype, after.subtype),
            x16(before.message_count, after.message_count),
            x16(before.destination_id, after.destination_id),
            before.cuc_seconds ^ after.cuc_seconds,
            x16(before.cuc_fraction, after.cuc_fraction)};
  }
  void check_only(std::size_t at, std::uint32_t mask, std::size_t width, const PacketHeader& expected) {
    for (const bool ones : {false, true}) {
      const PacketHeader d = difference(ones, at, mask, width);
      LONGS_EQUAL(expected.apid, d.apid);
      LONGS_EQUAL(expected.sequence_count, d.sequence_count);
      LONGS_EQUAL(0, d.data_length);
      LONGS_EQUAL(expected.time_reference_status, d.time_reference_status);
      LONGS_EQUAL(expected.service, d.service);
      LONGS_EQUAL(expected.subtype, d.subtype);
      LONGS_EQUAL(expected.message_count, d.message_count);
      LONGS_EQUAL(expected.destination_id, d.destination_id);
      UNSIGNED_LONGS_EQUAL(expected.cuc_seconds, d.cuc_seconds);
      LONGS_EQUAL(expected.cuc_fraction, d.cuc_fraction);
    }
  }
  Status read_with_byte(std::size_t at, std::uint8_t value) {
    encode_health();
    buffer[at] = value;
    packet_samples::seal(bytes());
    return read_header(bytes(), header);
  }
};

TEST(TelemetryHeader, EachFieldIsReadFromItsOwnBits) {
  check_only(0, 0x07FF, 2, {.apid = 0x7FF});
  check_only(2, 0x3FFF, 2, {.sequence_count = 0x3FFF});
  check_only(6, 0x0F, 1, {.time_reference_status = 0x0F});
  check_only(7, 0xFF, 1, {.service = 0xFF});
  check_only(8, 0xFF, 1, {.subtype = 0xFF});
  check_only(9, 0xFFFF, 2, {.message_count = 0xFFFF});
  check_only(11, 0xFFFF, 2, {.destination_id = 0xFFFF});
  check_only(13, 0xFFFFFFFF, 4, {.cuc_seconds = 0xFFFFFFFF});
  check_only(17, 0xFFFF, 2, {.cuc_fraction = 0xFFFF});
}

TEST(TelemetryHeader, FixedBitsAreAsTheStandardSays) {
  encode_health();
  LONGS_EQUAL(0x08 | 0x01, buffer[0]);  // version 0, telemetry, secondary header; APID 0x102
  LONGS_EQUAL(0x02, buffer[1]);
  LONGS_EQUAL(0xC0, buffer[2] & 0xC0);  // stand-alone
  LONGS_EQUAL(health_bytes - 7, (buffer[4] << 8) | buffer[5]);
  LONGS_EQUAL(0x20, buffer[6]);  // PUS-C
  LONGS_EQUAL(3, buffer[7]);
  LONGS_EQUAL(25, buffer[8]);
  LONGS_EQUAL(3, (buffer[19] << 8) | buffer[20]);  // structure id
  LONGS_EQUAL(0, relnav::crc16(bytes()));
}

TEST(TelemetryHeader, OtherKindsOfPacketAreUnsupported) {
  CHECK_TRUE(read_with_byte(0, 0x29) == Status::unsupported);  // version 1
  CHECK_TRUE(read_with_byte(0, 0x19) == Status::unsupported);  // telecommand
  CHECK_TRUE(read_with_byte(0, 0x01) == Status::unsupported);  // no secondary header
  CHECK_TRUE(read_with_byte(2, 0x40) == Status::unsupported);  // first segment
  CHECK_TRUE(read_with_byte(6, 0x10) == Status::unsupported);  // PUS-A
  CHECK_TRUE(read_with_byte(6, 0x2F) == Status::ok);
}

TEST(TelemetryHeader, SequenceCountsRunPerPacketAndWrapAt14Bits) {
  EventPacket event;
  event.event_id = static_cast<std::uint16_t>(EventId::mode_changed);
  for (std::uint32_t i = 0; i < 0x4002; ++i) {
    encode_health();
    CHECK_TRUE(read_header(bytes(), header) == Status::ok);
    LONGS_EQUAL(i & 0x3FFFU, header.sequence_count);
    LONGS_EQUAL(i & 0xFFFFU, header.message_count);
    LONGS_EQUAL(0x102, header.apid);
  }
  const auto size = encode(event, context, buffer);
  CHECK_TRUE(read_header(std::span<const std::uint8_t>(buffer).first(size.value()), header) == Status::ok);
  LONGS_EQUAL(0, header.sequence_count);
}

TEST(TelemetryHeader, MessageCountsOfEventsRunPerSeverity) {
  EventPacket event;
  for (const EventId id : {EventId::mode_changed, EventId::camera_lost, EventId::track_acquired, EventId::frame_gap,
                           EventId::image_frozen}) {
    event.event_id = static_cast<std::uint16_t>(id);
    CHECK_TRUE(encode(event, context, buffer).has_value());
  }
  LONGS_EQUAL(5, context.sequence_count(PacketId::event));
  LONGS_EQUAL(2, context.message_count(PacketId::event, 1));
  LONGS_EQUAL(1, context.message_count(PacketId::event, 2));
  LONGS_EQUAL(1, context.message_count(PacketId::event, 3));
  LONGS_EQUAL(1, context.message_count(PacketId::event, 4));
  LONGS_EQUAL(0, context.message_count(PacketId::health, 25));
}

TEST(TelemetryHeader, MessageCountWrapsAt16Bits) {
  for (std::uint32_t i = 0; i < 0x10000; ++i) context.advance(PacketId::health, 25);
  LONGS_EQUAL(0, context.message_count(PacketId::health, 25));
}

TEST(TelemetryHeader, TimeIsCucSince1958RoundedDown) {
  CHECK_TRUE(configure({.epoch_offset_ns = unix_epoch_since_1958_ns + 37'000'000'000LL}) == Status::ok);
  packet.time_ns = 1'500'000'000ULL;
  encode_health();
  CHECK_TRUE(read_header(bytes(), header) == Status::ok);
  UNSIGNED_LONGS_EQUAL(378'691'200UL + 37UL + 1UL, header.cuc_seconds);
  LONGS_EQUAL(0x8000, header.cuc_fraction);
  packet.time_ns = 999'999'999ULL;
  encode_health();
  CHECK_TRUE(read_header(bytes(), header) == Status::ok);
  UNSIGNED_LONGS_EQUAL(378'691'237UL, header.cuc_seconds);
  LONGS_EQUAL(0xFFFF, header.cuc_fraction);
}

TEST(TelemetryHeader, TimesWithoutCucFormAreRefused) {
  packet.time_ns = 4'294'967'295'999'999'999ULL;
  encode_health();
  CHECK_TRUE(read_header(bytes(), header) == Status::ok);
  UNSIGNED_LONGS_EQUAL(0xFFFFFFFFUL, header.cuc_seconds);
  packet.time_ns += 1;
  CHECK_TRUE(encode(packet, context, buffer).status() == Status::outside_domain);
  packet.time_ns = 0x8000000000000000ULL;
  CHECK_TRUE(encode(packet, context, buffer).status() == Status::outside_domain);
  packet.time_ns = 99;
  CHECK_TRUE(configure({.epoch_offset_ns = -100}) == Status::ok);
  CHECK_TRUE(encode(packet, context, buffer).status() == Status::outside_domain);
  packet.time_ns = 0x7FFFFFFFFFFFFFFFULL;
  CHECK_TRUE(configure({.epoch_offset_ns = 1}) == Status::ok);
  CHECK_TRUE(encode(packet, context, buffer).status() == Status::outside_domain);
}

TEST(TelemetryHeader, ApidsOfOthersAreNotUsable) {
  for (std::uint32_t apid = 0; apid < 0x900; ++apid) {
    const bool reserved = apid <= 6 || apid == 0xFE || apid == 0xFF || apid == 2045 || apid >= 0x7FF;
    CHECK_TRUE(is_usable_apid(apid) == !reserved);
  }
}

TEST(TelemetryHeader, BaseWhoseRangeTouchesAReservedApidIsRefused) {
  for (std::uint16_t base = 0; base < 0x900; ++base) {
    bool usable = true;
    for (std::uint32_t i = 0; i < packet_count; ++i) usable = usable && is_usable_apid(base + i);
    CHECK_TRUE((validate({.apid_base = base}) == Status::ok) == usable);
  }
  CHECK_TRUE(configure({.apid_base = 0xFC}) == Status::invalid_argument);
  CHECK_TRUE(configure({.time_reference_status = 16}) == Status::invalid_argument);
  LONGS_EQUAL(default_apid_base, context.config().apid_base);
}

TEST(TelemetryHeader, ConfigurationGoesIntoTheHeaderAndCountsStartAnew) {
  encode_health();
  CHECK_TRUE(configure({.apid_base = 0x7F0, .destination_id = 0xABCD, .time_reference_status = 15}) == Status::ok);
  LONGS_EQUAL(0, context.sequence_count(PacketId::health));
  LONGS_EQUAL(0, context.message_count(PacketId::health, 25));
  encode_health();
  CHECK_TRUE(read_header(bytes(), header) == Status::ok);
  LONGS_EQUAL(0x7F2, header.apid);
  LONGS_EQUAL(0xABCD, header.destination_id);
  LONGS_EQUAL(15, header.time_reference_status);
}

TEST(TelemetryHeader, FramingFindsThePacketsOfAFile) {
  std::array<std::uint8_t, 3 * health_bytes> file{};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK_TRUE(encode(packet, context, std::span<std::uint8_t>(file).subspan(i * health_bytes)).has_value());
  }
  std::span<const std::uint8_t> rest(file);
  for (int i = 0; i < 3; ++i) {
    const auto length = framed_length(rest);
    LONGS_EQUAL(health_bytes, length.value());
    CHECK_TRUE(read_header(rest.first(length.value()), header) == Status::ok);
    LONGS_EQUAL(i, header.sequence_count);
    rest = rest.subspan(length.value());
  }
  CHECK_TRUE(framed_length(rest).status() == Status::no_data);
}

TEST(TelemetryHeader, FramingOfACutFileIsIncomplete) {
  encode_health();
  for (std::size_t length = 1; length < health_bytes; ++length) {
    CHECK_TRUE(framed_length(bytes().first(length)).status() == Status::incomplete);
  }
}
