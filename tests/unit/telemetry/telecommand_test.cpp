#include "fsw/telemetry/telecommand.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fsw/base/generator.hpp"
#include "tests/unit/telemetry/packet_samples.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav::telemetry;
using relnav::Status;

TEST_GROUP(Telecommand) {
  using Bytes = std::vector<std::uint8_t>;
  PacketConfig config{.apid_base = 0x123};
  Telecommand command;

  Bytes encoded(TelecommandId id, std::uint32_t argument = 0, std::uint16_t sequence = 0) {
    Bytes bytes(max_telecommand_bytes);
    const auto size = encode_telecommand(id, argument, sequence, config, bytes);
    CHECK_TRUE(size.has_value());
    bytes.resize(size.value());
    return bytes;
  }
  Status parse(const Bytes& bytes) { return parse_telecommand(bytes, config, command); }
  Status parse_sealed(Bytes bytes) {
    packet_samples::seal(bytes);
    return parse(bytes);
  }
  /// `ping` with this byte.
  Status with_byte(std::size_t at, std::uint8_t value) {
    Bytes bytes = encoded(TelecommandId::ping);
    bytes[at] = value;
    return parse_sealed(bytes);
  }
  /// A command of this service and subtype with these data.
  Status with_data(std::uint8_t service, std::uint8_t subtype, const Bytes& data) {
    Bytes bytes{0x19, 0x23, 0xC0, 0x07, 0, static_cast<std::uint8_t>(6 + data.size()), 0x2F, service, subtype, 0, 0};
    bytes.insert(bytes.end(), data.begin(), data.end());
    bytes.insert(bytes.end(), {0, 0});
    return parse_sealed(bytes);
  }
};

TEST(Telecommand, EachComesBack) {
  for (const TelecommandDefinition& d : telecommand_definitions) {
    const Bytes bytes = encoded(d.id, 0xFEDCBA98, 0x3FFF);
    LONGS_EQUAL(telecommand_size(d), bytes.size());
    CHECK_TRUE(parse(bytes) == Status::ok);
    CHECK_TRUE(command.id == d.id);
    CHECK_TRUE(command.is_ours);
    LONGS_EQUAL(0x1923, command.request.packet_id);
    LONGS_EQUAL(0xFFFF, command.request.sequence);
    LONGS_EQUAL(d.service, command.request.service);
    LONGS_EQUAL(d.subtype, command.request.subtype);
    UNSIGNED_LONGS_EQUAL(d.argument_bytes == 0 ? 0U : 0xFEDCBA98U, command.argument);
  }
}

// Written down by hand; the CRC is Python's binascii.crc_hqx(bytes, 0xFFFF).
TEST(Telecommand, BytesOnTheWire) {
  const Bytes ping{0x19, 0x23, 0xC0, 0x05, 0x00, 0x06, 0x2F, 0x11, 0x01, 0x00, 0x00, 0x61, 0x6D};
  CHECK_TRUE(encoded(TelecommandId::ping, 0, 5) == ping);
  const Bytes restart{0x19, 0x23, 0xC0, 0x06, 0x00, 0x07, 0x2F, 0x08, 0x01, 0x00, 0x00, 0x03, 0x18, 0xE7};
  CHECK_TRUE(encoded(TelecommandId::restart, 0, 6) == restart);
  const Bytes set_tai{0x19, 0x23, 0xC0, 0x07, 0x00, 0x0A, 0x2F, 0x09, 0x80,
                      0x00, 0x00, 0x7B, 0xE6, 0x4F, 0xA5, 0x91, 0x78};
  CHECK_TRUE(encoded(TelecommandId::set_tai, 0x7BE64FA5, 7) == set_tai);
}

TEST(Telecommand, SourceAndReportFlagsDoNotMatter) {
  CHECK_TRUE(with_byte(6, 0x20) == Status::ok);
  CHECK_TRUE(with_byte(9, 0xFF) == Status::ok);
  CHECK_TRUE(with_byte(10, 0xFF) == Status::ok);
}

TEST(Telecommand, OtherPacketsAreUnsupported) {
  CHECK_TRUE(with_byte(0, 0x09) == Status::unsupported);  // telemetry
  CHECK_FALSE(command.is_ours);
  CHECK_TRUE(with_byte(0, 0x39) == Status::unsupported);  // version 1
  CHECK_TRUE(with_byte(0, 0x11) == Status::unsupported);  // no secondary header
  CHECK_TRUE(with_byte(1, 0x24) == Status::unsupported);  // another APID
  CHECK_FALSE(command.is_ours);
  LONGS_EQUAL(0, command.request.service);
  CHECK_TRUE(with_byte(2, 0x40) == Status::unsupported);  // first segment
  CHECK_TRUE(command.is_ours);
  CHECK_TRUE(with_byte(2, 0x80) == Status::unsupported);  // last segment
  CHECK_TRUE(with_byte(6, 0x1F) == Status::unsupported);  // PUS-A
  CHECK_TRUE(with_byte(6, 0x3F) == Status::unsupported);
  LONGS_EQUAL(17, command.request.service);
}

TEST(Telecommand, CommandsOutsideOfTheTableAreUnsupported) {
  CHECK_TRUE(with_data(17, 2, {}) == Status::unsupported);
  CHECK_TRUE(with_data(18, 1, {}) == Status::unsupported);
  CHECK_TRUE(with_data(8, 1, {}) == Status::unsupported);
  CHECK_TRUE(with_data(8, 1, {0}) == Status::unsupported);
  CHECK_TRUE(with_data(8, 1, {5}) == Status::unsupported);
  CHECK_TRUE(with_data(9, 1, {1}) == Status::unsupported);
  CHECK_TRUE(command.is_ours);
  LONGS_EQUAL(9, command.request.service);
  LONGS_EQUAL(1, command.request.subtype);
  CHECK_TRUE(with_data(8, 1, {4}) == Status::ok);
}

TEST(Telecommand, DataOfAnotherSizeAreRefused) {
  CHECK_TRUE(with_data(17, 1, {1}) == Status::invalid_argument);
  CHECK_TRUE(with_data(8, 1, {1, 0}) == Status::invalid_argument);
  CHECK_TRUE(with_data(9, 128, {}) == Status::invalid_argument);
  CHECK_TRUE(with_data(9, 128, {1, 2, 3}) == Status::invalid_argument);
  CHECK_TRUE(with_data(9, 128, {1, 2, 3, 4, 5}) == Status::invalid_argument);
  UNSIGNED_LONGS_EQUAL(0, command.argument);
  CHECK_TRUE(with_data(9, 128, {1, 2, 3, 4}) == Status::ok);
  UNSIGNED_LONGS_EQUAL(0x01020304, command.argument);
}

TEST(Telecommand, CutOrLongerPacketsAreIncomplete) {
  const Bytes whole = encoded(TelecommandId::set_tai, 1);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CHECK_TRUE(parse(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))) == Status::incomplete);
    CHECK_TRUE(command.is_ours == (size >= primary_header_bytes));
  }
  Bytes longer = whole;
  longer.push_back(0);
  CHECK_TRUE(parse(longer) == Status::incomplete);
  // As long as it says, but too short for a telecommand, with a good CRC.
  Bytes tiny{0x19, 0x23, 0xC0, 0, 0, 5, 0x2F, 17, 1, 0, 0, 0};
  CHECK_TRUE(parse_sealed(tiny) == Status::incomplete);
}

TEST(Telecommand, EveryFlippedBitIsRefused) {
  Bytes bytes = encoded(TelecommandId::set_tai, 0x7BE64FA5, 7);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    CHECK_TRUE(parse(bytes) == (bit / 8 == 4 || bit / 8 == 5 ? Status::incomplete : Status::crc_mismatch));
    CHECK_TRUE(command.is_ours == (bit >= 16));
    LONGS_EQUAL(0, command.request.service);
    UNSIGNED_LONGS_EQUAL(0, command.argument);
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
  }
  CHECK_TRUE(parse(bytes) == Status::ok);
}

TEST(Telecommand, AnyBytesWithAGoodCrcAreHandled) {
  relnav::Generator g(11);
  int accepted = 0;
  for (int i = 0; i < 50000; ++i) {
    Bytes bytes(min_telecommand_bytes + g.below(8));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(g.next() & 0xFFU);
    const Bytes head{0x19, 0x23, 0xC0, 0, 0, static_cast<std::uint8_t>(bytes.size() - 7), 0x2F};
    for (std::size_t k = 0; k < head.size(); ++k) bytes[k] = head[k];
    if (g.below(2) == 0) {  // else hardly any service is one of ours
      bytes[7] = 8;
      bytes[8] = 1;
    }
    const Status status = parse_sealed(bytes);
    CHECK_TRUE(status == Status::ok || status == Status::unsupported || status == Status::invalid_argument);
    if (status == Status::ok) {
      ++accepted;
      LONGS_EQUAL(telecommand_size(definition_of(command.id)), bytes.size());
    }
  }
  CHECK_TRUE(accepted > 0);
}

TEST(Telecommand, EncoderNeedsRoom) {
  Bytes bytes(max_telecommand_bytes, 0x55);
  for (const TelecommandDefinition& d : telecommand_definitions) {
    const auto room = std::span<std::uint8_t>(bytes).first(telecommand_size(d) - 1);
    CHECK_TRUE(encode_telecommand(d.id, 0, 0, config, room).status() == Status::no_capacity);
  }
  for (const std::uint8_t byte : bytes) LONGS_EQUAL(0x55, byte);
}
