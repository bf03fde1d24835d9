#include "fsw/telemetry/byte_stream.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include <CppUTest/TestHarness.h>

using relnav::Status;
using relnav::telemetry::is_finite;
using relnav::telemetry::PacketReader;
using relnav::telemetry::PacketWriter;

TEST_GROUP(ByteStream) { std::array<std::uint8_t, 64> buffer{}; };

TEST(ByteStream, BigEndianBytes) {
  PacketWriter writer(buffer);
  writer.u8(0x01);
  writer.u16(0x0203);
  writer.u32(0x04050607);
  writer.u64(0x08090A0B0C0D0E0F);
  writer.i16(-2);
  writer.i32(-3);
  writer.i64(-4);
  writer.f32(-1.5F);
  writer.f64(-2.0);
  const std::array<std::uint8_t, 41> expected{1,    2,    3,    4,    5,    6,    7,    8,    9,    10,   11,
                                              12,   13,   14,   15,   0xFF, 0xFE, 0xFF, 0xFF, 0xFF, 0xFD, 0xFF,
                                              0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFC, 0xBF, 0xC0, 0,    0,
                                              0xC0, 0,    0,    0,    0,    0,    0,    0};
  CHECK_TRUE(writer.status() == Status::ok);
  LONGS_EQUAL(expected.size(), writer.size());
  LONGS_EQUAL(expected.size(), writer.written().size());
  MEMCMP_EQUAL(expected.data(), buffer.data(), expected.size());
  LONGS_EQUAL(0, buffer[expected.size()]);
}

TEST(ByteStream, ReaderTakesBackWhatTheWriterPut) {
  PacketWriter writer(buffer);
  writer.u8(200);
  writer.u16(60000);
  writer.u32(4000000000U);
  writer.u64(~0ULL);
  writer.i16(std::numeric_limits<std::int16_t>::min());
  writer.i32(std::numeric_limits<std::int32_t>::min());
  writer.i64(std::numeric_limits<std::int64_t>::min());
  writer.f32(0.1F);
  writer.f64(-0.0);
  PacketReader reader(writer.written());
  LONGS_EQUAL(200, reader.u8());
  LONGS_EQUAL(60000, reader.u16());
  CHECK_TRUE(reader.u32() == 4000000000U);
  CHECK_TRUE(reader.u64() == ~0ULL);
  CHECK_TRUE(reader.i16() == std::numeric_limits<std::int16_t>::min());
  CHECK_TRUE(reader.i32() == std::numeric_limits<std::int32_t>::min());
  CHECK_TRUE(reader.i64() == std::numeric_limits<std::int64_t>::min());
  CHECK_TRUE(std::bit_cast<std::uint32_t>(reader.f32()) == std::bit_cast<std::uint32_t>(0.1F));
  CHECK_TRUE(std::bit_cast<std::uint64_t>(reader.f64()) == 0x8000000000000000ULL);
  LONGS_EQUAL(0, reader.remaining());
  CHECK_TRUE(reader.status() == Status::ok);
}

TEST(ByteStream, WriterStopsAtTheEnd) {
  buffer.fill(0xEE);
  PacketWriter writer(std::span<std::uint8_t>(buffer).first(5));
  writer.u32(0);
  writer.u16(0);  // does not fit
  writer.u8(0);   // would fit, but comes after
  CHECK_TRUE(writer.status() == Status::no_capacity);
  LONGS_EQUAL(4, writer.size());
  LONGS_EQUAL(0xEE, buffer[4]);
  LONGS_EQUAL(0xEE, buffer[5]);
}

TEST(ByteStream, ReaderGivesZeroPastTheEnd) {
  buffer.fill(0xEE);
  PacketReader reader(std::span<const std::uint8_t>(buffer).first(3));
  LONGS_EQUAL(0xEEEE, reader.u16());
  LONGS_EQUAL(0, reader.u16());
  LONGS_EQUAL(0, reader.u8());
  CHECK_TRUE(reader.status() == Status::incomplete);
}

TEST(ByteStream, Finite) {
  CHECK_TRUE(is_finite(0.0));
  CHECK_TRUE(is_finite(-std::numeric_limits<double>::max()));
  CHECK_TRUE(is_finite(std::numeric_limits<double>::denorm_min()));
  CHECK_FALSE(is_finite(std::numeric_limits<double>::infinity()));
  CHECK_FALSE(is_finite(-std::numeric_limits<double>::infinity()));
  CHECK_FALSE(is_finite(std::numeric_limits<double>::quiet_NaN()));
  CHECK_TRUE(is_finite(std::numeric_limits<float>::max()));
  CHECK_FALSE(is_finite(std::numeric_limits<float>::infinity()));
  CHECK_FALSE(is_finite(-std::numeric_limits<float>::quiet_NaN()));
}
