#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "hil/io/image.hpp"
#include "tests/support/scratch.hpp"
#include "tests/unit/hil/hand_made_png.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::add_be32;
using relnav::test::add_chunk;
using relnav::test::make_png;
using relnav::test::message_of;
using relnav::test::Scratch;

TEST_GROUP(Png) {
  Scratch scratch;
  std::string grey_file() { return make_png(2, 2, 8, 0, std::string("\0\1\2\0\3\377", 6)); }
  std::string failure(const std::string& bytes) {
    const std::string path = scratch.write("i.png", bytes);
    return message_of([&] { static_cast<void>(read_png(path)); });
  }
};

TEST(Png, ReadsGrey8) {
  const Image image = read_png(scratch.write("i.png", grey_file()));
  CHECK_EQUAL(2U, image.width_px);
  CHECK_EQUAL(2U, image.height_px);
  CHECK_EQUAL(1U, image.bytes_per_pixel);
  CHECK(image.bytes == (std::vector<std::uint8_t>{1, 2, 3, 255}));
}

TEST(Png, ReadsGrey16InMachineOrder) {
  const Image image = read_png(scratch.write("i.png", make_png(2, 1, 16, 0, std::string("\0\x12\x34\xAB\xCD", 5))));
  CHECK_EQUAL(2U, image.bytes_per_pixel);
  std::uint16_t samples[2];
  std::memcpy(samples, image.bytes.data(), sizeof samples);
  CHECK_EQUAL(0x1234, samples[0]);
  CHECK_EQUAL(0xABCD, samples[1]);
}

TEST(Png, TurnsColourIntoGrey) {
  const Image image =
      read_png(scratch.write("i.png", make_png(3, 1, 8, 2, std::string("\0\377\0\0\0\377\0\0\0\377", 10))));
  CHECK(image.bytes == (std::vector<std::uint8_t>{76, 150, 29}));
}

TEST(Png, DropsTransparency) {
  const Image image = read_png(scratch.write("i.png", make_png(1, 1, 8, 6, std::string("\0\144\144\144\0", 5))));
  CHECK(image.bytes == (std::vector<std::uint8_t>{100}));
}

TEST(Png, WhatIsWrittenReadsBack) {
  const Image image{3, 2, 1, {0, 50, 100, 150, 200, 255}};
  const auto bytes = encode_png(image);
  const Image read = read_png(scratch.write("i.png", std::string(bytes.begin(), bytes.end())));
  CHECK(read.bytes == image.bytes);
  CHECK_EQUAL(3U, read.width_px);
}

TEST(Png, DamageAtEveryLengthIsAnError) {
  const std::string whole = grey_file();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    CHECK_MESSAGE_HOLDS(failure(whole.substr(0, length)), "i.png: ");
    CHECK_MESSAGE_HOLDS(failure(whole.substr(0, length)), "(expected a complete PNG image)");
  }
}

TEST(Png, DamagedPixelsAreAnError) {
  std::string bytes = grey_file();
  bytes[bytes.size() - 20] = static_cast<char>(bytes[bytes.size() - 20] ^ 0x55);
  CHECK_MESSAGE_HOLDS(failure(bytes), "damaged or truncated");
}

TEST(Png, MissingFileIsNamed) {
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_png(scratch.path("no.png"))); }),
                      "no.png: cannot be opened");
}

TEST(Png, HugeSizeIsRefused) {
  CHECK_MESSAGE_HOLDS(failure(make_png(2000000000, 2000000000, 8, 0, "")), "damaged or truncated");
}
