#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace relnav::telemetry {

/// Finite by its bits: independent of compiler options for floating point.
[[nodiscard]] constexpr bool is_finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) != 0x7F800000U;
}
[[nodiscard]] constexpr bool is_finite(double value) {
  return (std::bit_cast<std::uint64_t>(value) & 0x7FF0000000000000ULL) != 0x7FF0000000000000ULL;
}

/// Writes big-endian numbers one after the other into a buffer of the caller.
/// A number that does not fit is not written, nor is any after it; status() is then no_capacity.
class PacketWriter {
 public:
  explicit constexpr PacketWriter(std::span<std::uint8_t> buffer) : buffer_(buffer) {}

  constexpr void u8(std::uint8_t value) { put(value, 1); }
  constexpr void u16(std::uint16_t value) { put(value, 2); }
  constexpr void u32(std::uint32_t value) { put(value, 4); }
  constexpr void u64(std::uint64_t value) { put(value, 8); }
  constexpr void i16(std::int16_t value) { put(static_cast<std::uint16_t>(value), 2); }
  constexpr void i32(std::int32_t value) { put(static_cast<std::uint32_t>(value), 4); }
  constexpr void i64(std::int64_t value) { put(static_cast<std::uint64_t>(value), 8); }
  constexpr void f32(float value) { put(std::bit_cast<std::uint32_t>(value), 4); }
  constexpr void f64(double value) { put(std::bit_cast<std::uint64_t>(value), 8); }

  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr Status status() const { return overrun_ ? Status::no_capacity : Status::ok; }
  [[nodiscard]] constexpr std::span<const std::uint8_t> written() const { return buffer_.first(size_); }

 private:
  constexpr void put(std::uint64_t bits, std::size_t bytes) {
    if (overrun_ || buffer_.size() - size_ < bytes) {
      overrun_ = true;
      return;
    }
    for (std::size_t i = bytes; i > 0; --i) {
      buffer_[size_++] = static_cast<std::uint8_t>((bits >> (8U * (i - 1U))) & 0xFFU);
    }
  }

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  bool overrun_ = false;
};

/// Reads what PacketWriter writes. Past the end every read gives 0 and status() is incomplete.
class PacketReader {
 public:
  explicit constexpr PacketReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] constexpr std::uint8_t u8() { return static_cast<std::uint8_t>(take(1)); }
  [[nodiscard]] constexpr std::uint16_t u16() { return static_cast<std::uint16_t>(take(2)); }
  [[nodiscard]] constexpr std::uint32_t u32() { return static_cast<std::uint32_t>(take(4)); }
  [[nodiscard]] constexpr std::uint64_t u64() { return take(8); }
  [[nodiscard]] constexpr std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  [[nodiscard]] constexpr std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  [[nodiscard]] constexpr std::int64_t i64() { return static_cast<std::int64_t>(u64()); }
  [[nodiscard]] constexpr float f32() { return std::bit_cast<float>(u32()); }
  [[nodiscard]] constexpr double f64() { return std::bit_cast<double>(u64()); }

  [[nodiscard]] constexpr std::size_t remaining() const { return bytes_.size() - position_; }
  [[nodiscard]] constexpr Status status() const { return underrun_ ? Status::incomplete : Status::ok; }

 private:
  constexpr std::uint64_t take(std::size_t bytes) {
    if (underrun_ || remaining() < bytes) {
      underrun_ = true;
      return 0;
    }
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      bits = (bits << 8U) | bytes_[position_++];
    }
    return bits;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool underrun_ = false;
};

}  // namespace relnav::telemetry
