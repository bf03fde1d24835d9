#include "fsw/base/crc32.hpp"

#include <array>
#include <cstdint>
#include <span>

#include <CppUTest/TestHarness.h>

namespace {

constexpr std::array<std::uint8_t, 9> check_input{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
static_assert(relnav::crc32(check_input) == 0xCBF43926U);

}  // namespace

TEST_GROUP(Crc32){};

TEST(Crc32, GoesOnWhereItStopped) {
  const std::span<const std::uint8_t> all(check_input);
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    const std::uint32_t first = relnav::crc32(all.first(cut));
    LONGS_EQUAL(0xCBF43926U, relnav::crc32(all.subspan(cut), first));
  }
}

TEST(Crc32, SeesEveryFlippedBit) {
  for (std::size_t bit = 0; bit < 8 * check_input.size(); ++bit) {
    auto damaged = check_input;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    CHECK(relnav::crc32(damaged) != 0xCBF43926U);
  }
}
