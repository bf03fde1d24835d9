/// Numbers on the wire and the tables that name them.
#include "fsw/telemetry/field.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <string>

#include "fsw/telemetry/packets.hpp"
#include "fsw/telemetry/visit.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav::telemetry;

TEST_GROUP(TelemetryField) {
  const std::array<std::uint8_t, 8> bytes{0xBF, 0xF8, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02};
  FieldValue read(FieldType type, std::size_t size) {
    PacketReader reader(bytes);
    const FieldValue value = read_value(reader, type);
    LONGS_EQUAL(bytes.size() - size, reader.remaining());
    LONGS_EQUAL(size, size_of(type));
    CHECK_TRUE(value.type == type);
    return value;
  }
};

TEST(TelemetryField, NumbersOfEveryTypeAreRead) {
  CHECK_TRUE(read(FieldType::u8, 1).as_unsigned == 0xBF);
  CHECK_TRUE(read(FieldType::u16, 2).as_unsigned == 0xBFF8);
  CHECK_TRUE(read(FieldType::u32, 4).as_unsigned == 0xBFF80000);
  CHECK_TRUE(read(FieldType::u64, 8).as_unsigned == 0xBFF8000000000002);
  CHECK_TRUE(read(FieldType::i16, 2).as_signed == -0x4008);
  CHECK_TRUE(read(FieldType::i32, 4).as_signed == -0x40080000);
  CHECK_TRUE(read(FieldType::i64, 8).as_signed == -0x4007FFFFFFFFFFFE);
  CHECK_TRUE(std::bit_cast<std::uint64_t>(read(FieldType::f32, 4).as_double) == std::bit_cast<std::uint64_t>(-1.9375));
  CHECK_TRUE(std::bit_cast<std::uint64_t>(read(FieldType::f64, 8).as_double) == 0xBFF8000000000002);
}

TEST(TelemetryField, TypesHaveTheNamesOfTheDocument) {
  const std::array<const char*, 9> names{"u8", "u16", "u32", "u64", "i16", "i32", "i64", "f32", "f64"};
  for (std::size_t i = 0; i < names.size(); ++i) STRCMP_EQUAL(names[i], to_string(static_cast<FieldType>(i)));
}

TEST(TelemetryField, ATypeThatIsNoneHasNoSizeAndNoValue) {
  const auto none = static_cast<FieldType>(99);
  STRCMP_EQUAL("unknown", to_string(none));
  const FieldValue value = read(none, 0);
  CHECK_TRUE(value.as_unsigned == 0 && value.as_signed == 0);
}

TEST(TelemetryField, SeveritiesHaveNames) {
  const std::array<const char*, 6> names{"UNKNOWN", "INFO", "LOW", "MEDIUM", "HIGH", "UNKNOWN"};
  for (std::size_t i = 0; i < names.size(); ++i) STRCMP_EQUAL(names[i], to_string(static_cast<Severity>(i)));
}

TEST(TelemetryField, LabelsNameValues) {
  const std::array<Label, 2> items{{{3, "three"}, {70000, "many"}}};
  const Labels labels{LabelKind::enumeration, "Count", items};
  STRCMP_EQUAL("three", label_of(labels, 3));
  STRCMP_EQUAL("many", label_of(labels, 70000));
  CHECK_TRUE(label_of(labels, 4) == nullptr);
  CHECK_TRUE(label_of(Labels{}, 3) == nullptr);
}

TEST(TelemetryField, DefinitionFollowsFromTheMember) {
  const auto definitions = definitions_of(rel_state_fields);
  LONGS_EQUAL(rel_state_field_definitions.size(), definitions.size());
  std::size_t found = 0;
  for (const FieldDefinition& d : definitions) {
    if (std::string(d.name) != "q_CT") continue;
    ++found;
    CHECK_TRUE(d.type == FieldType::f64);
    LONGS_EQUAL(4, d.count);
    LONGS_EQUAL(32, size_of(d));
  }
  LONGS_EQUAL(1, found);
}
