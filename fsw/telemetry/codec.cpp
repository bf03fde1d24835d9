#include "fsw/telemetry/codec.hpp"

#include <limits>
#include <tuple>
#include <type_traits>

#include "fsw/base/crc16.hpp"
#include "fsw/base/panic.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::telemetry {

namespace {

void put(PacketWriter& writer, std::uint8_t value) { writer.u8(value); }
void put(PacketWriter& writer, std::uint16_t value) { writer.u16(value); }
void put(PacketWriter& writer, std::uint32_t value) { writer.u32(value); }
void put(PacketWriter& writer, std::uint64_t value) { writer.u64(value); }
void put(PacketWriter& writer, std::int32_t value) { writer.i32(value); }
void put(PacketWriter& writer, std::int64_t value) { writer.i64(value); }
void put(PacketWriter& writer, float value) { writer.f32(value); }
void put(PacketWriter& writer, double value) { writer.f64(value); }
template <typename T, std::size_t N>
void put(PacketWriter& writer, const std::array<T, N>& values) {
  for (const T& value : values) put(writer, value);
}

void take(PacketReader& reader, std::uint8_t& value) { value = reader.u8(); }
void take(PacketReader& reader, std::uint16_t& value) { value = reader.u16(); }
void take(PacketReader& reader, std::uint32_t& value) { value = reader.u32(); }
void take(PacketReader& reader, std::uint64_t& value) { value = reader.u64(); }
void take(PacketReader& reader, std::int32_t& value) { value = reader.i32(); }
void take(PacketReader& reader, std::int64_t& value) { value = reader.i64(); }
void take(PacketReader& reader, float& value) { value = reader.f32(); }
void take(PacketReader& reader, double& value) { value = reader.f64(); }
template <typename T, std::size_t N>
void take(PacketReader& reader, std::array<T, N>& values) {
  for (T& value : values) take(reader, value);
}

template <typename T>
[[nodiscard]] bool all_finite(const T& value) {
  if constexpr (std::is_floating_point_v<T>) {
    return is_finite(value);
  } else {
    return true;
  }
}
template <typename T, std::size_t N>
[[nodiscard]] bool all_finite(const std::array<T, N>& values) {
  for (const T& value : values) {
    if (!all_finite(value)) return false;
  }
  return true;
}

template <typename Fields, typename Value>
void put_fields(PacketWriter& writer, const Fields& fields, const Value& value) {
  std::apply([&](const auto&... f) { (put(writer, value.*(f.member)), ...); }, fields);
}
template <typename Fields, typename Value>
void take_fields(PacketReader& reader, const Fields& fields, Value& value) {
  std::apply([&](const auto&... f) { (take(reader, value.*(f.member)), ...); }, fields);
}
template <typename Fields, typename Value>
[[nodiscard]] bool finite_fields(const Fields& fields, const Value& value) {
  bool finite = true;
  std::apply([&](const auto&... f) { ((finite = finite && all_finite(value.*(f.member))), ...); }, fields);
  return finite;
}

template <typename Packet>
struct Traits;
template <>
struct Traits<RelStatePacket> {
  static constexpr PacketId id = PacketId::rel_state;
  static constexpr const auto& fields = rel_state_fields;
};
template <>
struct Traits<FeaturesPacket> {
  static constexpr PacketId id = PacketId::features;
  static constexpr const auto& fields = features_fields;
};
template <>
struct Traits<HealthPacket> {
  static constexpr PacketId id = PacketId::health;
  static constexpr const auto& fields = health_fields;
};
template <>
struct Traits<EventPacket> {
  static constexpr PacketId id = PacketId::event;
  static constexpr const auto& fields = event_fields;
};
template <>
struct Traits<TimePacket> {
  static constexpr PacketId id = PacketId::time;
  static constexpr const auto& fields = time_fields;
};
template <>
struct Traits<CommandAckPacket> {
  static constexpr PacketId id = PacketId::command_ack;
  static constexpr const auto& fields = command_ack_fields;
};
template <>
struct Traits<PongPacket> {
  static constexpr PacketId id = PacketId::pong;
  static constexpr const auto& fields = pong_fields;
};

template <typename Packet>
inline constexpr bool has_entries = requires(const Packet& packet) {
  packet.entries;
};

/// CUC 4+2: seconds and 1/65536 s of TAI since 1958, rounded down.
struct Cuc {
  std::uint32_t seconds = 0;
  std::uint16_t fraction = 0;
};

Expected<Cuc> to_cuc(std::uint64_t time_ns, std::int64_t epoch_offset_ns) {
  constexpr std::uint64_t second_ns = 1'000'000'000ULL;
  constexpr std::int64_t time_max = std::numeric_limits<std::int64_t>::max();
  if (time_ns > static_cast<std::uint64_t>(time_max)) return Status::outside_domain;
  const auto time = static_cast<std::int64_t>(time_ns);
  if (epoch_offset_ns > 0 && time > time_max - epoch_offset_ns) return Status::outside_domain;
  const std::int64_t tai = time + epoch_offset_ns;
  if (tai < 0) return Status::outside_domain;
  const std::uint64_t seconds = static_cast<std::uint64_t>(tai) / second_ns;
  const std::uint64_t rest_ns = static_cast<std::uint64_t>(tai) % second_ns;
  if (seconds > std::numeric_limits<std::uint32_t>::max()) return Status::outside_domain;
  return Cuc{static_cast<std::uint32_t>(seconds), static_cast<std::uint16_t>((rest_ns << 16U) / second_ns)};
}

template <typename Packet>
[[nodiscard]] bool finite_packet(const Packet& packet) {
  if (!finite_fields(Traits<Packet>::fields, packet)) return false;
  if constexpr (has_entries<Packet>) {
    for (const auto& entry : packet.entries) {
      if (!finite_fields(feature_entry_fields, entry)) return false;
    }
  }
  return true;
}

template <typename Packet>
Expected<std::size_t> encode_packet(const Packet& packet, std::uint8_t subtype, PacketContext& context,
                                    std::span<std::uint8_t> buffer) {
  constexpr PacketId id = Traits<Packet>::id;
  const PacketDefinition& definition = definition_of(id);
  const PacketConfig& config = context.config();

  std::size_t entries = 0;
  if constexpr (has_entries<Packet>) entries = packet.entries.size();
  const std::size_t size = packet_size(definition, entries);
  if (buffer.size() < size) return Status::no_capacity;
  if (!finite_packet(packet)) return Status::not_finite;
  const Expected<Cuc> cuc = to_cuc(packet.time_ns, config.epoch_offset_ns);
  if (!cuc) return cuc.status();

  PacketWriter writer(buffer.first(size));
  // Version 0, telemetry, secondary header present; then stand-alone packet.
  writer.u16(static_cast<std::uint16_t>(0x0800U | ((config.apid_base + definition.apid_offset) & 0x07FFU)));
  writer.u16(static_cast<std::uint16_t>(0xC000U | context.sequence_count(id)));
  writer.u16(static_cast<std::uint16_t>(size - primary_header_bytes - 1U));
  writer.u8(static_cast<std::uint8_t>(0x20U | config.time_reference_status));
  writer.u8(definition.service);
  writer.u8(subtype);
  writer.u16(context.message_count(id, subtype));
  writer.u16(config.destination_id);
  writer.u32(cuc.value().seconds);
  writer.u16(cuc.value().fraction);
  if (definition.structure_id != 0) writer.u16(definition.structure_id);
  put_fields(writer, Traits<Packet>::fields, packet);
  if constexpr (has_entries<Packet>) {
    writer.u16(static_cast<std::uint16_t>(entries));
    for (const auto& entry : packet.entries) put_fields(writer, feature_entry_fields, entry);
  }
  writer.u16(crc16(writer.written()));
  RELNAV_ASSERT(writer.status() == Status::ok && writer.size() == size);
  context.advance(id, subtype);
  return size;
}

template <typename Packet>
Status decode_packet(std::span<const std::uint8_t> bytes, const PacketConfig& config, Packet& packet) {
  const Expected<OpenedPacket> opened = open_packet(bytes, config);
  if (!opened) return opened.status();
  if (opened.value().definition->id != Traits<Packet>::id) return Status::invalid_argument;

  Packet read;
  PacketReader reader(opened.value().body);
  take_fields(reader, Traits<Packet>::fields, read);
  if constexpr (has_entries<Packet>) {
    static_cast<void>(reader.u16());
    for (std::uint16_t i = 0; i < opened.value().entries; ++i) {
      FeatureEntry entry;
      take_fields(reader, feature_entry_fields, entry);
      const Status pushed = read.entries.push_back(entry);
      if (pushed != Status::ok) return pushed;
    }
  }
  if (reader.status() != Status::ok) return reader.status();
  if (!finite_packet(read)) return Status::not_finite;
  if constexpr (Traits<Packet>::id == PacketId::event) {
    const EventDefinition* event = find_event(read.event_id);
    if (event == nullptr) return Status::unsupported;
    if (opened.value().header.subtype != static_cast<std::uint8_t>(event->severity)) return Status::invalid_argument;
  }
  if constexpr (Traits<Packet>::id == PacketId::command_ack) {
    if (!is_command_stage(read.stage) || opened.value().header.subtype != read.stage) return Status::invalid_argument;
  }
  if constexpr (Traits<Packet>::id == PacketId::features) {
    if (read.part >= read.parts) return Status::invalid_argument;
  }
  packet = read;
  return Status::ok;
}

}  // namespace

Expected<std::size_t> encode(const RelStatePacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  const std::uint8_t subtype = definition_of(PacketId::rel_state).subtype_first;
  if (packet.q_CT[3] >= 0.0) return encode_packet(packet, subtype, context, buffer);
  RelStatePacket same_attitude = packet;
  for (double& component : same_attitude.q_CT) component = -component;
  return encode_packet(same_attitude, subtype, context, buffer);
}

Expected<std::size_t> encode(const FeaturesPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  if (packet.part >= packet.parts) return Status::invalid_argument;
  return encode_packet(packet, definition_of(PacketId::features).subtype_first, context, buffer);
}

Expected<std::size_t> encode(const HealthPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  return encode_packet(packet, definition_of(PacketId::health).subtype_first, context, buffer);
}

Expected<std::size_t> encode(const EventPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  const EventDefinition* event = find_event(packet.event_id);
  if (event == nullptr) return Status::invalid_argument;
  return encode_packet(packet, static_cast<std::uint8_t>(event->severity), context, buffer);
}

Expected<std::size_t> encode(const TimePacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  return encode_packet(packet, definition_of(PacketId::time).subtype_first, context, buffer);
}

Expected<std::size_t> encode(const CommandAckPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  if (!is_command_stage(packet.stage)) return Status::invalid_argument;
  return encode_packet(packet, packet.stage, context, buffer);
}

Expected<std::size_t> encode(const PongPacket& packet, PacketContext& context, std::span<std::uint8_t> buffer) {
  return encode_packet(packet, definition_of(PacketId::pong).subtype_first, context, buffer);
}

Expected<OpenedPacket> open_packet(std::span<const std::uint8_t> bytes, const PacketConfig& config) {
  OpenedPacket opened;
  const Status status = read_header(bytes, opened.header);
  if (status != Status::ok) return status;
  if (opened.header.apid < config.apid_base || opened.header.apid >= config.apid_base + packet_count) {
    return Status::unsupported;
  }
  const PacketDefinition& definition =
      packet_definitions[static_cast<std::size_t>(opened.header.apid - config.apid_base)];
  if (opened.header.service != definition.service || opened.header.subtype < definition.subtype_first ||
      opened.header.subtype > definition.subtype_last) {
    return Status::unsupported;
  }
  opened.definition = &definition;
  opened.body = bytes.subspan(primary_header_bytes + secondary_header_bytes);
  opened.body = opened.body.first(opened.body.size() - crc_bytes);
  if (definition.structure_id != 0) {
    PacketReader reader(opened.body);
    const std::uint16_t structure_id = reader.u16();
    if (reader.status() != Status::ok) return reader.status();
    if (structure_id != definition.structure_id) return Status::unsupported;
    opened.body = opened.body.subspan(2);
  }
  if (opened.body.size() < body_size(definition)) return Status::incomplete;
  if (!definition.entry_fields.empty()) {
    PacketReader reader(opened.body.subspan(size_of(definition.fields)));
    opened.entries = reader.u16();
    if (opened.entries > definition.max_entries) return Status::incomplete;
  }
  if (opened.body.size() != body_size(definition, opened.entries)) return Status::incomplete;
  return opened;
}

Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, RelStatePacket& packet) {
  return decode_packet(bytes, config, packet);
}
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, FeaturesPacket& packet) {
  return decode_packet(bytes, config, packet);
}
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, HealthPacket& packet) {
  return decode_packet(bytes, config, packet);
}
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, EventPacket& packet) {
  return decode_packet(bytes, config, packet);
}
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, TimePacket& packet) {
  return decode_packet(bytes, config, packet);
}
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, CommandAckPacket& packet) {
  return decode_packet(bytes, config, packet);
}
Status decode(std::span<const std::uint8_t> bytes, const PacketConfig& config, PongPacket& packet) {
  return decode_packet(bytes, config, packet);
}

std::int32_t to_px_256(double px) {
  if (!is_finite(px)) return 0;
  const double scaled = px * 256.0 + (px < 0.0 ? -0.5 : 0.5);
  if (scaled >= 2147483647.0) return std::numeric_limits<std::int32_t>::max();
  if (scaled <= -2147483648.0) return std::numeric_limits<std::int32_t>::min();
  return static_cast<std::int32_t>(scaled);
}

}  // namespace relnav::telemetry
