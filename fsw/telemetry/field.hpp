#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>

namespace relnav::telemetry {

/// How a number stands in a packet. Always big-endian; signed numbers in two's complement; floats IEEE 754.
enum class FieldType : std::uint8_t { u8, u16, u32, u64, i16, i32, i64, f32, f64 };

[[nodiscard]] constexpr std::size_t size_of(FieldType type) {
  switch (type) {
    case FieldType::u8: return 1;
    case FieldType::u16:
    case FieldType::i16: return 2;
    case FieldType::u32:
    case FieldType::i32:
    case FieldType::f32: return 4;
    case FieldType::u64:
    case FieldType::i64:
    case FieldType::f64: return 8;
  }
  return 0;
}

[[nodiscard]] constexpr const char* to_string(FieldType type) {
  switch (type) {
    case FieldType::u8: return "u8";
    case FieldType::u16: return "u16";
    case FieldType::u32: return "u32";
    case FieldType::u64: return "u64";
    case FieldType::i16: return "i16";
    case FieldType::i32: return "i32";
    case FieldType::i64: return "i64";
    case FieldType::f32: return "f32";
    case FieldType::f64: return "f64";
  }
  return "unknown";
}

/// Name of one value of a field.
struct Label {
  std::uint64_t value = 0;
  const char* name = "";
};

enum class LabelKind : std::uint8_t {
  none,         ///< the field is a number
  enumeration,  ///< a label names the whole value
  flags,        ///< a label names one bit; its value is the mask
};

struct Labels {
  LabelKind kind = LabelKind::none;
  const char* name = "";
  std::span<const Label> items;
};

/// Name of an enumeration's value; nullptr when it has none.
[[nodiscard]] constexpr const char* label_of(const Labels& labels, std::uint64_t value) {
  for (const Label& label : labels.items) {
    if (label.value == value) return label.name;
  }
  return nullptr;
}

/// One field of a packet, for whoever reads packets by the table.
struct FieldDefinition {
  const char* name = "";
  FieldType type = FieldType::u8;
  std::uint16_t count = 1;  ///< elements; 1 for a single number
  const char* unit = "";
  const char* description = "";
  Labels labels;
};

[[nodiscard]] constexpr std::size_t size_of(const FieldDefinition& field) { return size_of(field.type) * field.count; }

[[nodiscard]] constexpr std::size_t size_of(std::span<const FieldDefinition> fields) {
  std::size_t bytes = 0;
  for (const FieldDefinition& field : fields) bytes += size_of(field);
  return bytes;
}

/// A field together with the member of the value struct that holds it. Type and count follow from the member.
template <typename Packet, typename Member>
struct Field {
  Member Packet::*member;
  const char* name;
  const char* unit;
  const char* description;
  Labels labels;
};

template <typename Packet, typename Member>
[[nodiscard]] consteval Field<Packet, Member> field(Member Packet::*member, const char* name, const char* unit,
                                                    const char* description, const Labels& labels = {}) {
  return {member, name, unit, description, labels};
}

template <typename T>
struct WireType;
template <>
struct WireType<std::uint8_t> {
  static constexpr FieldType type = FieldType::u8;
};
template <>
struct WireType<std::uint16_t> {
  static constexpr FieldType type = FieldType::u16;
};
template <>
struct WireType<std::uint32_t> {
  static constexpr FieldType type = FieldType::u32;
};
template <>
struct WireType<std::uint64_t> {
  static constexpr FieldType type = FieldType::u64;
};
template <>
struct WireType<std::int16_t> {
  static constexpr FieldType type = FieldType::i16;
};
template <>
struct WireType<std::int32_t> {
  static constexpr FieldType type = FieldType::i32;
};
template <>
struct WireType<std::int64_t> {
  static constexpr FieldType type = FieldType::i64;
};
template <>
struct WireType<float> {
  static constexpr FieldType type = FieldType::f32;
};
template <>
struct WireType<double> {
  static constexpr FieldType type = FieldType::f64;
};

template <typename T>
struct WireShape {
  using Element = T;
  static constexpr std::uint16_t count = 1;
};
template <typename T, std::size_t N>
struct WireShape<std::array<T, N>> {
  using Element = T;
  static constexpr std::uint16_t count = N;
};

template <typename Packet, typename Member>
[[nodiscard]] constexpr FieldDefinition definition_of(const Field<Packet, Member>& f) {
  return {f.name,  WireType<typename WireShape<Member>::Element>::type, WireShape<Member>::count, f.unit, f.description,
          f.labels};
}

/// The fields of a tuple of Field as an array that needs no templates to be read.
template <typename... Fields>
[[nodiscard]] constexpr std::array<FieldDefinition, sizeof...(Fields)> definitions_of(
    const std::tuple<Fields...>& fields) {
  return std::apply([](const auto&... f) { return std::array<FieldDefinition, sizeof...(f)>{definition_of(f)...}; },
                    fields);
}

}  // namespace relnav::telemetry
