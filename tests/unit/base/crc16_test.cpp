#include "fsw/base/crc16.hpp"

#include <array>
#include <cstdint>
#include <span>

#include <CppUTest/TestHarness.h>

namespace {

constexpr std::array<std::uint8_t, 9> check_input{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
static_assert(relnav::crc16(check_input) == 0x29B1);

/// Bit by bit, after the definition.
std::uint16_t crc_by_definition(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    for (int bit = 7; bit >= 0; --bit) {
      const bool feedback = (((crc >> 15) ^ (static_cast<unsigned>(byte) >> bit)) & 1U) != 0U;
      crc = (crc << 1) & 0xFFFFU;
      if (feedback) crc ^= 0x1021U;
    }
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace

TEST_GROUP(Crc16) {
  std::array<std::uint8_t, 64> data{};
  void setup() override {
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i * 37U + 11U);
  }
};

TEST(Crc16, CheckValue) { LONGS_EQUAL(0x29B1, relnav::crc16(check_input)); }

TEST(Crc16, OfNothingIsTheStartValue) { LONGS_EQUAL(0xFFFF, relnav::crc16({})); }

TEST(Crc16, EveryByteValueAgreesWithTheDefinition) {
  for (unsigned byte = 0; byte < 256; ++byte) {
    data[5] = static_cast<std::uint8_t>(byte);
    LONGS_EQUAL(crc_by_definition(data), relnav::crc16(data));
  }
}

TEST(Crc16, GoesOnOverPieces) {
  const std::span<const std::uint8_t> all(data);
  for (std::size_t cut = 0; cut <= data.size(); ++cut) {
    LONGS_EQUAL(relnav::crc16(all), relnav::crc16(all.subspan(cut), relnav::crc16(all.first(cut))));
  }
}

TEST(Crc16, ZeroOverDataAndItsCrc) {
  const std::uint16_t crc = relnav::crc16(std::span<const std::uint8_t>(data).first(62));
  data[62] = static_cast<std::uint8_t>(crc >> 8U);
  data[63] = static_cast<std::uint8_t>(crc & 0xFFU);
  LONGS_EQUAL(0, relnav::crc16(data));
}

TEST(Crc16, EveryFlippedBitIsSeen) {
  const std::uint16_t good = relnav::crc16(data);
  for (std::size_t bit = 0; bit < data.size() * 8; ++bit) {
    data[bit / 8] = static_cast<std::uint8_t>(data[bit / 8] ^ (1U << (bit % 8)));
    CHECK_TRUE(relnav::crc16(data) != good);
    data[bit / 8] = static_cast<std::uint8_t>(data[bit / 8] ^ (1U << (bit % 8)));
  }
}
