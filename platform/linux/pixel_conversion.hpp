#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "fsw/base/status.hpp"
#include "hal/frame.hpp"
#include "platform/linux/camera_driver.hpp"

namespace relnav::platform::linux {

/// The deepest first: the order in which a driver looks for a format when none is asked for.
inline constexpr RawFormat all_formats[] = {
    RawFormat::y16,         RawFormat::y12,         RawFormat::y12p,        RawFormat::y10,
    RawFormat::y10p,        RawFormat::grey8,       RawFormat::yuyv,        RawFormat::bayer_rggb8,
    RawFormat::bayer_grbg8, RawFormat::bayer_gbrg8, RawFormat::bayer_bggr8,
};

/// As the enumerator is spelt.
[[nodiscard]] const char* name_of(RawFormat format);
[[nodiscard]] std::optional<RawFormat> format_named(std::string_view name);

/// V4L2's code of a pixel format; 0: V4L2 has none (its own Y10P and Y12P order the bits in another way).
[[nodiscard]] std::uint32_t fourcc_of(RawFormat format);
[[nodiscard]] std::optional<RawFormat> format_of_fourcc(std::uint32_t fourcc);

/// What convert() makes of it: mono16 where more than 8 bits are significant, right-aligned, little-endian.
[[nodiscard]] hal::PixelFormat mono_format(RawFormat format);
[[nodiscard]] int significant_bits(RawFormat format);
/// The driver's buffer is a mono image as it stands.
[[nodiscard]] bool is_mono(RawFormat format);

/// Bytes that a row of pixels takes at least.
[[nodiscard]] std::uint64_t row_bytes(RawFormat format, std::uint32_t width_px);
[[nodiscard]] std::uint64_t row_bytes(hal::PixelFormat format, std::uint32_t width_px);

/// ok: all pixels lie inside of `image.bytes`. incomplete: the buffer ends before them; invalid_argument: a row does not fit the
/// stride, or the size is none of this format (zero, yuyv of odd width, Bayer of one row or column).
[[nodiscard]] Status check_layout(const RawImage& image);

/// Writes the mono image, rows without gaps, to the beginning of `mono`. y10p, y12p: each row begins with a byte of its own.
/// yuyv: its luma, in the camera's range. Bayer: luma of the bilinear demosaic, (77 R + 150 G + 29 B) / 256 rounded once, in
/// integers; the image is mirrored at its edges (without repeating them, which keeps the pattern), so an even surface keeps its
/// level everywhere.
/// Errors: as check_layout; no_capacity: `mono` is too small. Nothing is written then.
Status convert(const RawImage& image, std::span<std::uint8_t> mono);

}  // namespace relnav::platform::linux
