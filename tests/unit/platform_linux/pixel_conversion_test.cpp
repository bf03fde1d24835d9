// Raw pixels to mono: known patterns, strides of any length, buffers that end too early.
#include "platform/linux/pixel_conversion.hpp"

#include <linux/videodev2.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::platform::linux;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// Rows of `row` bytes each, with `gap` bytes of rubbish after each but the last.
Bytes with_gaps(const Bytes& rows, std::size_t row, std::size_t gap) {
  Bytes out;
  for (std::size_t at = 0; at < rows.size(); at += row) {
    if (at > 0) out.insert(out.end(), gap, 0xEE);
    out.insert(out.end(), rows.begin() + static_cast<std::ptrdiff_t>(at),
               rows.begin() + static_cast<std::ptrdiff_t>(at + row));
  }
  return out;
}

RawImage image_of(const Bytes& bytes, RawFormat format, std::uint32_t width_px, std::uint32_t height_px,
                  std::uint32_t stride_bytes) {
  RawImage image;
  image.bytes = bytes;
  image.format = format;
  image.width_px = width_px;
  image.height_px = height_px;
  image.stride_bytes = stride_bytes;
  return image;
}

Bytes converted(const RawImage& image) {
  Bytes mono(static_cast<std::size_t>(row_bytes(mono_format(image.format), image.width_px) * image.height_px), 0xAA);
  CHECK_TRUE(convert(image, mono) == Status::ok);
  return mono;
}

/// The same rows with and without gaps.
void check_pattern(RawFormat format, const Bytes& rows, std::uint32_t width_px, std::uint32_t height_px,
                   const Bytes& expected) {
  const auto row = static_cast<std::uint32_t>(rows.size() / height_px);
  for (const std::uint32_t gap : {0U, 1U, 3U, 7U}) {
    const Bytes bytes = with_gaps(rows, row, gap);
    CHECK_TRUE(converted(image_of(bytes, format, width_px, height_px, row + gap)) == expected);
  }
}

/// What the filters stand for, done the long way: three colours, then luma.
Bytes reference_luma(RawFormat format, const Bytes& raw, int width, int height) {
  const auto mirrored = [](int i, int n) { return i < 0 ? -i : (i >= n ? 2 * n - 2 - i : i); };
  const auto colour = [&](int u, int v) {  // 0 red, 1 green, 2 blue
    static const std::string layouts[] = {"RGGB", "GRBG", "GBRG", "BGGR"};
    const std::string& layout = layouts[static_cast<int>(format) - static_cast<int>(RawFormat::bayer_rggb8)];
    const char c = layout[static_cast<std::size_t>(2 * (v & 1) + (u & 1))];
    return c == 'R' ? 0 : (c == 'G' ? 1 : 2);
  };
  Bytes out;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      double rgb[3];
      for (int c = 0; c < 3; ++c) {
        double sum = 0.0;
        int count = 0;
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) {
            const bool centre = du == 0 && dv == 0;
            if (centre != (colour(u, v) == c)) continue;
            if (!centre && colour(u + du + 2, v + dv + 2) != c) continue;
            sum += raw[static_cast<std::size_t>(mirrored(v + dv, height) * width + mirrored(u + du, width))];
            ++count;
          }
        }
        rgb[c] = sum / count;
      }
      out.push_back(static_cast<std::uint8_t>((77.0 * rgb[0] + 150.0 * rgb[1] + 29.0 * rgb[2]) / 256.0 + 0.5));
    }
  }
  return out;
}

}  // namespace

TEST_GROUP(PixelConversion){};

TEST(PixelConversion, EveryFormatHasItsNameAndCode) {
  std::set<std::string> names;
  std::set<RawFormat> formats;
  for (const RawFormat format : all_formats) {
    names.insert(name_of(format));
    formats.insert(format);
    CHECK_TRUE(format_named(name_of(format)) == format);
    if (fourcc_of(format) != 0) CHECK_TRUE(format_of_fourcc(fourcc_of(format)) == format);
  }
  LONGS_EQUAL(11, names.size());
  LONGS_EQUAL(11, formats.size());
  CHECK_FALSE(format_named("GREY8").has_value());
  CHECK_FALSE(format_named("").has_value());
  CHECK_FALSE(format_of_fourcc(0).has_value());
  CHECK_FALSE(format_of_fourcc(V4L2_PIX_FMT_MJPEG).has_value());
  LONGS_EQUAL(V4L2_PIX_FMT_GREY, fourcc_of(RawFormat::grey8));
  LONGS_EQUAL(V4L2_PIX_FMT_YUYV, fourcc_of(RawFormat::yuyv));
  LONGS_EQUAL(V4L2_PIX_FMT_SGBRG8, fourcc_of(RawFormat::bayer_gbrg8));
  LONGS_EQUAL(0, fourcc_of(RawFormat::y10p));
}

TEST(PixelConversion, DeepFormatsBecomeMono16) {
  for (const RawFormat format : all_formats) {
    const bool deep = significant_bits(format) > 8;
    CHECK_TRUE(mono_format(format) == (deep ? hal::PixelFormat::mono16 : hal::PixelFormat::mono8));
  }
  LONGS_EQUAL(10, significant_bits(RawFormat::y10));
  LONGS_EQUAL(12, significant_bits(RawFormat::y12p));
  LONGS_EQUAL(5, row_bytes(RawFormat::y10p, 4));
  LONGS_EQUAL(7, row_bytes(RawFormat::y10p, 5));  // 50 bits
  LONGS_EQUAL(5, row_bytes(RawFormat::y12p, 3));
}

TEST(PixelConversion, MonoIsCopiedRowByRow) {
  check_pattern(RawFormat::grey8, {1, 2, 3, 4, 5, 6}, 3, 2, {1, 2, 3, 4, 5, 6});
  check_pattern(RawFormat::y10, {0xFF, 0x03, 0x01, 0x00}, 1, 2, {0xFF, 0x03, 0x01, 0x00});
  check_pattern(RawFormat::y16, {0x34, 0x12, 0xFF, 0xFF}, 2, 1, {0x34, 0x12, 0xFF, 0xFF});
}

TEST(PixelConversion, PackedBitsAreUnpackedLowestFirst) {
  // 0x3FF, 0, 0x155, 0x2AA as one stream of bits, lowest first.
  check_pattern(RawFormat::y10p, {0xFF, 0x03, 0x50, 0x95, 0xAA}, 4, 1, {0xFF, 0x03, 0, 0, 0x55, 0x01, 0xAA, 0x02});
  // 0xABC, 0x123 in 3 bytes.
  check_pattern(RawFormat::y12p, {0xBC, 0x3A, 0x12}, 2, 1, {0xBC, 0x0A, 0x23, 0x01});
}

TEST(PixelConversion, PackedRowsBeginAtTheirStride) {
  // Widths that end within a byte; the reference puts single bits.
  for (const RawFormat format : {RawFormat::y10p, RawFormat::y12p}) {
    const auto bits = static_cast<std::uint32_t>(significant_bits(format));
    for (const std::uint32_t width : {1U, 3U, 5U, 7U}) {
      const auto row = static_cast<std::uint32_t>(row_bytes(format, width));
      Bytes rows(std::size_t{3} * row, 0);
      Bytes expected;
      for (std::uint32_t v = 0; v < 3; ++v) {
        for (std::uint32_t u = 0; u < width; ++u) {
          const std::uint32_t value = (1237U * (v * width + u) + 211U) & ((1U << bits) - 1U);
          for (std::uint32_t b = 0; b < bits; ++b) {
            const std::uint32_t at = u * bits + b;
            if (((value >> b) & 1U) != 0) rows[v * row + at / 8] |= static_cast<std::uint8_t>(1U << (at % 8));
          }
          expected.push_back(static_cast<std::uint8_t>(value & 0xFFU));
          expected.push_back(static_cast<std::uint8_t>(value >> 8U));
        }
      }
      check_pattern(format, rows, width, 3, expected);
    }
  }
}

TEST(PixelConversion, YuyvGivesItsLuma) {
  check_pattern(RawFormat::yuyv, {16, 128, 235, 127, 1, 0, 2, 255}, 2, 2, {16, 235, 1, 2});
  const Bytes bytes(6, 0);
  CHECK_TRUE(check_layout(image_of(bytes, RawFormat::yuyv, 3, 1, 6)) == Status::invalid_argument);
}

TEST(PixelConversion, BayerKeepsAnEvenLevel) {
  for (const RawFormat format :
       {RawFormat::bayer_rggb8, RawFormat::bayer_grbg8, RawFormat::bayer_gbrg8, RawFormat::bayer_bggr8}) {
    for (const std::uint8_t level : Bytes{0, 1, 77, 254, 255}) {
      check_pattern(format, Bytes(15, level), 5, 3, Bytes(15, level));
    }
  }
}

TEST(PixelConversion, BayerIsTheLumaOfTheBilinearDemosaic) {
  std::uint32_t state = 12345;
  for (const RawFormat format :
       {RawFormat::bayer_rggb8, RawFormat::bayer_grbg8, RawFormat::bayer_gbrg8, RawFormat::bayer_bggr8}) {
    for (const auto& [width, height] : {std::pair{2U, 2U}, std::pair{7U, 5U}, std::pair{8U, 6U}}) {
      Bytes raw(std::size_t{width} * height);
      for (std::uint8_t& value : raw) {
        state = state * 1664525U + 1013904223U;
        value = static_cast<std::uint8_t>(state >> 24U);
      }
      check_pattern(format, raw, width, height,
                    reference_luma(format, raw, static_cast<int>(width), static_cast<int>(height)));
    }
  }
}

TEST(PixelConversion, BayerColoursHaveTheirWeights) {
  // Full red alone, in every pattern: 77/256 of 255.
  const auto pure = [](RawFormat format, std::size_t site) {
    Bytes raw(16, 0);
    for (std::size_t v = site / 2; v < 4; v += 2) {
      for (std::size_t u = site % 2; u < 4; u += 2) raw[4 * v + u] = 255;
    }
    return converted(image_of(raw, format, 4, 4, 4));
  };
  CHECK_TRUE(pure(RawFormat::bayer_rggb8, 0) == Bytes(16, 77));
  CHECK_TRUE(pure(RawFormat::bayer_grbg8, 1) == Bytes(16, 77));
  CHECK_TRUE(pure(RawFormat::bayer_gbrg8, 2) == Bytes(16, 77));
  CHECK_TRUE(pure(RawFormat::bayer_bggr8, 3) == Bytes(16, 77));
  CHECK_TRUE(pure(RawFormat::bayer_bggr8, 0) == Bytes(16, 29));
}

TEST(PixelConversion, ABufferThatEndsTooEarlyIsIncomplete) {
  for (const RawFormat format : all_formats) {
    const auto row = static_cast<std::uint32_t>(row_bytes(format, 4));
    const std::uint32_t stride = row + 2;
    const std::size_t needed = std::size_t{2} * stride + row;
    // Of its own block, so that a sanitizer sees a read beyond its end.
    const auto exact = std::make_unique<std::uint8_t[]>(needed);
    std::memset(exact.get(), 0x55, needed);
    RawImage image = image_of({}, format, 4, 3, stride);
    image.bytes = {exact.get(), needed};
    Bytes mono(static_cast<std::size_t>(row_bytes(mono_format(format), 4) * 3));
    CHECK_TRUE(convert(image, mono) == Status::ok);
    const Bytes untouched(mono.size(), 0xAA);
    mono = untouched;
    const auto shorter = std::make_unique<std::uint8_t[]>(needed - 1);
    image.bytes = {shorter.get(), needed - 1};
    CHECK_TRUE(convert(image, mono) == Status::incomplete);
    image.bytes = {};
    CHECK_TRUE(convert(image, mono) == Status::incomplete);
    CHECK_TRUE(mono == untouched);
  }
}

TEST(PixelConversion, ImpossibleLayoutsAreRefused) {
  const Bytes bytes(64, 1);
  Bytes mono(16, 0xAA);
  CHECK_TRUE(convert(image_of(bytes, RawFormat::grey8, 0, 4, 4), mono) == Status::invalid_argument);
  CHECK_TRUE(convert(image_of(bytes, RawFormat::grey8, 4, 0, 4), mono) == Status::invalid_argument);
  CHECK_TRUE(convert(image_of(bytes, RawFormat::grey8, 4, 4, 3), mono) == Status::invalid_argument);
  CHECK_TRUE(convert(image_of(bytes, RawFormat::bayer_rggb8, 4, 1, 4), mono) == Status::invalid_argument);
  CHECK_TRUE(convert(image_of(bytes, RawFormat::y16, 4, 4, 8), mono) == Status::no_capacity);
  // Sizes whose product does not fit 32 bits.
  CHECK_TRUE(convert(image_of(bytes, RawFormat::y16, 0x80000000U, 0x80000000U, 0xFFFFFFFFU), mono) ==
             Status::invalid_argument);
  CHECK_TRUE(convert(image_of(bytes, RawFormat::grey8, 4, 0xFFFFFFFFU, 0xFFFFFFFFU), mono) == Status::incomplete);
  CHECK_TRUE(mono == Bytes(16, 0xAA));
}
