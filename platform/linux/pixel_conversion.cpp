#include "platform/linux/pixel_conversion.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cstring>

namespace relnav::platform::linux {
namespace {

struct FormatFacts {
  RawFormat format;
  const char* name;
  std::uint32_t fourcc;
  int bits;            ///< significant
  int bits_in_memory;  ///< a pixel, in the driver's buffer
  bool is_mono;
};

constexpr std::array facts{
    FormatFacts{RawFormat::grey8, "grey8", V4L2_PIX_FMT_GREY, 8, 8, true},
    FormatFacts{RawFormat::y10, "y10", V4L2_PIX_FMT_Y10, 10, 16, true},
    FormatFacts{RawFormat::y12, "y12", V4L2_PIX_FMT_Y12, 12, 16, true},
    FormatFacts{RawFormat::y16, "y16", V4L2_PIX_FMT_Y16, 16, 16, true},
    FormatFacts{RawFormat::y10p, "y10p", 0, 10, 10, false},
    FormatFacts{RawFormat::y12p, "y12p", 0, 12, 12, false},
    FormatFacts{RawFormat::yuyv, "yuyv", V4L2_PIX_FMT_YUYV, 8, 16, false},
    FormatFacts{RawFormat::bayer_rggb8, "bayer_rggb8", V4L2_PIX_FMT_SRGGB8, 8, 8, false},
    FormatFacts{RawFormat::bayer_grbg8, "bayer_grbg8", V4L2_PIX_FMT_SGRBG8, 8, 8, false},
    FormatFacts{RawFormat::bayer_gbrg8, "bayer_gbrg8", V4L2_PIX_FMT_SGBRG8, 8, 8, false},
    FormatFacts{RawFormat::bayer_bggr8, "bayer_bggr8", V4L2_PIX_FMT_SBGGR8, 8, 8, false},
};
static_assert(facts.size() == std::size(all_formats));

const FormatFacts& facts_of(RawFormat format) {
  static_assert([] {
    for (std::size_t i = 0; i < facts.size(); ++i) {
      if (static_cast<std::size_t>(facts[i].format) != i) return false;
    }
    return true;
  }());
  return facts[static_cast<std::size_t>(format)];
}

bool is_bayer(RawFormat format) { return format >= RawFormat::bayer_rggb8; }

/// Pixels of `bits` each, packed as one stream, lowest bit first.
void unpack_row(const std::uint8_t* packed, std::uint32_t width_px, std::uint32_t bits, std::uint8_t* mono) {
  const std::uint32_t mask = (1U << bits) - 1U;
  std::uint32_t window = 0;
  std::uint32_t filled = 0;
  for (std::uint32_t u = 0; u < width_px; ++u) {
    while (filled < bits) {
      window |= std::uint32_t{*packed++} << filled;
      filled += 8;
    }
    const std::uint32_t value = window & mask;
    mono[2 * u] = static_cast<std::uint8_t>(value & 0xFFU);
    mono[2 * u + 1] = static_cast<std::uint8_t>(value >> 8U);
    window >>= bits;
    filled -= bits;
  }
}

/// Luma of the bilinear demosaic is one filter of 3 x 3 for each kind of site; the weights of each add up to 1024.
struct LumaFilter {
  std::uint32_t centre;
  std::uint32_t horizontal;  ///< each of two
  std::uint32_t vertical;    ///< each of two
  std::uint32_t diagonal;    ///< each of four
};
constexpr std::uint32_t red = 77;
constexpr std::uint32_t green = 150;
constexpr std::uint32_t blue = 29;
constexpr LumaFilter at_red{4 * red, green, green, blue};
constexpr LumaFilter at_blue{4 * blue, green, green, red};
constexpr LumaFilter at_green_in_red_row{4 * green, 2 * red, 2 * blue, 0};
constexpr LumaFilter at_green_in_blue_row{4 * green, 2 * blue, 2 * red, 0};

/// Of the pixels [v % 2][u % 2].
std::array<std::array<LumaFilter, 2>, 2> luma_filters(RawFormat format) {
  using Row = std::array<LumaFilter, 2>;
  switch (format) {
    case RawFormat::bayer_grbg8: return {Row{at_green_in_red_row, at_red}, Row{at_blue, at_green_in_blue_row}};
    case RawFormat::bayer_gbrg8: return {Row{at_green_in_blue_row, at_blue}, Row{at_red, at_green_in_red_row}};
    case RawFormat::bayer_bggr8: return {Row{at_blue, at_green_in_blue_row}, Row{at_green_in_red_row, at_red}};
    default: return {Row{at_red, at_green_in_red_row}, Row{at_green_in_blue_row, at_blue}};
  }
}

void bayer_to_luma(const RawImage& image, std::uint8_t* mono) {
  const auto filters = luma_filters(image.format);
  const std::uint32_t width = image.width_px;
  const std::uint32_t height = image.height_px;
  const auto row = [&](std::uint32_t v) { return image.bytes.data() + std::size_t{v} * image.stride_bytes; };
  for (std::uint32_t v = 0; v < height; ++v) {
    const std::uint8_t* here = row(v);
    const std::uint8_t* above = row(v == 0 ? 1 : v - 1);
    const std::uint8_t* below = row(v + 1 == height ? height - 2 : v + 1);
    for (std::uint32_t u = 0; u < width; ++u) {
      const std::uint32_t left = u == 0 ? 1 : u - 1;
      const std::uint32_t right = u + 1 == width ? width - 2 : u + 1;
      const LumaFilter& filter = filters[v % 2][u % 2];
      const std::uint32_t sum =
          filter.centre * here[u] + filter.horizontal * (std::uint32_t{here[left]} + here[right]) +
          filter.vertical * (std::uint32_t{above[u]} + below[u]) +
          filter.diagonal * (std::uint32_t{above[left]} + above[right] + below[left] + below[right]);
      *mono++ = static_cast<std::uint8_t>((sum + 512U) >> 10U);
    }
  }
}

}  // namespace

const char* name_of(RawFormat format) { return facts_of(format).name; }

std::optional<RawFormat> format_named(std::string_view name) {
  for (const FormatFacts& fact : facts) {
    if (name == fact.name) return fact.format;
  }
  return std::nullopt;
}

std::uint32_t fourcc_of(RawFormat format) { return facts_of(format).fourcc; }

std::optional<RawFormat> format_of_fourcc(std::uint32_t fourcc) {
  for (const FormatFacts& fact : facts) {
    if (fact.fourcc != 0 && fourcc == fact.fourcc) return fact.format;
  }
  return std::nullopt;
}

hal::PixelFormat mono_format(RawFormat format) {
  return facts_of(format).bits > 8 ? hal::PixelFormat::mono16 : hal::PixelFormat::mono8;
}

int significant_bits(RawFormat format) { return facts_of(format).bits; }

bool is_mono(RawFormat format) { return facts_of(format).is_mono; }

std::uint64_t row_bytes(RawFormat format, std::uint32_t width_px) {
  return (std::uint64_t{width_px} * static_cast<std::uint32_t>(facts_of(format).bits_in_memory) + 7U) / 8U;
}

std::uint64_t row_bytes(hal::PixelFormat format, std::uint32_t width_px) {
  return std::uint64_t{width_px} * (format == hal::PixelFormat::mono16 ? 2U : 1U);
}

Status check_layout(const RawImage& image) {
  if (image.width_px == 0 || image.height_px == 0) return Status::invalid_argument;
  if (image.format == RawFormat::yuyv && image.width_px % 2 != 0) return Status::invalid_argument;
  if (is_bayer(image.format) && (image.width_px < 2 || image.height_px < 2)) return Status::invalid_argument;
  const std::uint64_t row = row_bytes(image.format, image.width_px);
  if (image.stride_bytes < row) return Status::invalid_argument;
  const std::uint64_t needed =
      (image.height_px - 1ULL) * image.stride_bytes + row;  // the last row may end with its pixels
  return image.bytes.size() < needed ? Status::incomplete : Status::ok;
}

Status convert(const RawImage& image, std::span<std::uint8_t> mono) {
  const Status layout = check_layout(image);
  if (layout != Status::ok) return layout;
  const auto mono_row = static_cast<std::size_t>(row_bytes(mono_format(image.format), image.width_px));
  if (mono.size() / mono_row < image.height_px) return Status::no_capacity;
  if (is_bayer(image.format)) {
    bayer_to_luma(image, mono.data());
    return Status::ok;
  }
  const std::uint8_t* from = image.bytes.data();
  std::uint8_t* to = mono.data();
  for (std::uint32_t v = 0; v < image.height_px; ++v, from += image.stride_bytes, to += mono_row) {
    switch (image.format) {
      case RawFormat::y10p:
      case RawFormat::y12p:
        unpack_row(from, image.width_px, static_cast<std::uint32_t>(facts_of(image.format).bits), to);
        break;
      case RawFormat::yuyv:
        for (std::uint32_t u = 0; u < image.width_px; ++u) to[u] = from[2 * std::size_t{u}];
        break;
      default: std::memcpy(to, from, mono_row); break;
    }
  }
  return Status::ok;
}

}  // namespace relnav::platform::linux
