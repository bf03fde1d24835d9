#pragma once
#include <cstdint>

#include "fsw/telemetry/byte_stream.hpp"
#include "fsw/telemetry/codec.hpp"

namespace relnav::telemetry {

/// One number out of a packet.
struct FieldValue {
  FieldType type = FieldType::u8;
  std::uint64_t as_unsigned = 0;  ///< u8 to u64
  std::int64_t as_signed = 0;     ///< i16 to i64
  double as_double = 0.0;         ///< f32, f64
};

[[nodiscard]] constexpr FieldValue read_value(PacketReader& reader, FieldType type) {
  FieldValue value{.type = type};
  switch (type) {
    case FieldType::u8: value.as_unsigned = reader.u8(); break;
    case FieldType::u16: value.as_unsigned = reader.u16(); break;
    case FieldType::u32: value.as_unsigned = reader.u32(); break;
    case FieldType::u64: value.as_unsigned = reader.u64(); break;
    case FieldType::i16: value.as_signed = reader.i16(); break;
    case FieldType::i32: value.as_signed = reader.i32(); break;
    case FieldType::i64: value.as_signed = reader.i64(); break;
    case FieldType::f32: value.as_double = static_cast<double>(reader.f32()); break;
    case FieldType::f64: value.as_double = reader.f64(); break;
  }
  return value;
}

inline constexpr std::int32_t no_entry = -1;

/// Calls visit(const FieldDefinition&, std::int32_t entry, std::uint16_t element, const FieldValue&) for each number of the
/// packet, in wire order; `entry` is no_entry for the fixed fields. The entry count itself is packet.entries.
template <typename Visitor>
void for_each_field(const OpenedPacket& packet, Visitor&& visit) {
  PacketReader reader(packet.body);
  for (const FieldDefinition& field : packet.definition->fields) {
    for (std::uint16_t element = 0; element < field.count; ++element) {
      visit(field, no_entry, element, read_value(reader, field.type));
    }
  }
  if (packet.definition->entry_fields.empty()) return;
  static_cast<void>(reader.u16());
  for (std::int32_t entry = 0; entry < packet.entries; ++entry) {
    for (const FieldDefinition& field : packet.definition->entry_fields) {
      for (std::uint16_t element = 0; element < field.count; ++element) {
        visit(field, entry, element, read_value(reader, field.type));
      }
    }
  }
}

}  // namespace relnav::telemetry
