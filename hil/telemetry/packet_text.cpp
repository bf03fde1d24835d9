#include "hil/telemetry/packet_text.hpp"

#include <nlohmann/json.hpp>

#include "fsw/telemetry/visit.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

using telemetry::FieldDefinition;
using telemetry::FieldType;
using telemetry::FieldValue;
using telemetry::LabelKind;
using Json = nlohmann::ordered_json;

bool is_real(FieldType type) { return type == FieldType::f32 || type == FieldType::f64; }
bool is_signed(FieldType type) { return type == FieldType::i16 || type == FieldType::i32 || type == FieldType::i64; }

std::string flags_text(const telemetry::Labels& labels, std::uint64_t value) {
  std::string text;
  for (const telemetry::Label& label : labels.items) {
    if ((value & label.value) != 0) text += (text.empty() ? "" : "|") + std::string(label.name);
  }
  return text.empty() ? "none" : text;
}

std::string value_text(const FieldDefinition& field, const FieldValue& value) {
  if (field.labels.kind == LabelKind::flags) return flags_text(field.labels, value.as_unsigned);
  if (field.labels.kind == LabelKind::enumeration) {
    const char* name = telemetry::label_of(field.labels, value.as_unsigned);
    if (name != nullptr) return name;
  }
  if (is_real(field.type)) return format_text(field.type == FieldType::f32 ? "%.6g" : "%.9g", value.as_double);
  return is_signed(field.type) ? std::to_string(value.as_signed) : std::to_string(value.as_unsigned);
}

Json value_json(const FieldDefinition& field, const FieldValue& value) {
  if (field.labels.kind != LabelKind::none) {
    if (field.labels.kind == LabelKind::flags) {
      Json names = Json::array();
      for (const telemetry::Label& label : field.labels.items) {
        if ((value.as_unsigned & label.value) != 0) names.push_back(label.name);
      }
      return names;
    }
    const char* name = telemetry::label_of(field.labels, value.as_unsigned);
    if (name != nullptr) return name;
  }
  if (is_real(field.type)) return value.as_double;
  return is_signed(field.type) ? Json(value.as_signed) : Json(value.as_unsigned);
}

const char* severity_of(const telemetry::PacketHeader& header) {
  return to_string(static_cast<telemetry::Severity>(header.subtype));
}

// Of an event: the arguments with their meaning.
std::vector<std::pair<std::string, std::int64_t>> event_arguments(const telemetry::EventPacket& event) {
  std::vector<std::pair<std::string, std::int64_t>> arguments;
  const telemetry::EventDefinition* definition = telemetry::find_event(event.event_id);
  for (std::size_t i = 0; definition != nullptr && i < event.args.size(); ++i) {
    if (definition->args[i][0] != '\0') arguments.emplace_back(definition->args[i], event.args[i]);
  }
  return arguments;
}

}  // namespace

std::string packet_text(std::span<const std::uint8_t> bytes, const telemetry::PacketConfig& config) {
  const auto packet = telemetry::open_packet(bytes, config);
  if (!packet) return format_text("unreadable packet of %zu bytes: %s", bytes.size(), to_string(packet.status()));
  const telemetry::OpenedPacket& opened = packet.value();
  std::string text =
      format_text("%-9s apid=0x%03X seq=%u", opened.definition->name, static_cast<unsigned>(opened.header.apid),
                  static_cast<unsigned>(opened.header.sequence_count));
  telemetry::EventPacket event;
  const bool is_event =
      opened.definition->id == telemetry::PacketId::event && telemetry::decode(bytes, config, event) == Status::ok;
  if (is_event) text += std::string(" ") + severity_of(opened.header);
  std::int32_t entry_now = telemetry::no_entry;
  telemetry::for_each_field(
      opened, [&](const FieldDefinition& field, std::int32_t entry, std::uint16_t element, const FieldValue& value) {
        if (is_event && std::string_view(field.name) == "args") return;
        if (entry != entry_now) {
          text += format_text(" [%d]", entry);
          entry_now = entry;
        }
        if (element == 0) text += std::string(" ") + field.name + "=";
        text += (element == 0 ? "" : ",") + value_text(field, value);
      });
  if (is_event) {
    for (const auto& [name, value] : event_arguments(event)) text += " " + name + "=" + std::to_string(value);
  }
  return text;
}

std::string packet_json(std::span<const std::uint8_t> bytes, const telemetry::PacketConfig& config) {
  Json json;
  const auto packet = telemetry::open_packet(bytes, config);
  if (!packet) {
    json["packet"] = nullptr;
    json["bytes"] = bytes.size();
    json["error"] = to_string(packet.status());
    return json.dump();
  }
  const telemetry::OpenedPacket& opened = packet.value();
  json["packet"] = opened.definition->name;
  json["apid"] = opened.header.apid;
  json["sequence_count"] = opened.header.sequence_count;
  if (opened.definition->id == telemetry::PacketId::event) json["severity"] = severity_of(opened.header);
  Json entries = Json::array();
  telemetry::for_each_field(
      opened, [&](const FieldDefinition& field, std::int32_t entry, std::uint16_t element, const FieldValue& value) {
        if (entry != telemetry::no_entry && entries.size() <= static_cast<std::size_t>(entry))
          entries.push_back(Json::object());
        Json& target = entry == telemetry::no_entry ? json : entries.back();
        if (field.count == 1) {
          target[field.name] = value_json(field, value);
        } else {
          if (element == 0) target[field.name] = Json::array();
          target[field.name].push_back(value_json(field, value));
        }
      });
  if (!opened.definition->entry_fields.empty()) json["entries"] = entries;
  telemetry::EventPacket event;
  if (opened.definition->id == telemetry::PacketId::event && telemetry::decode(bytes, config, event) == Status::ok) {
    Json named = Json::object();
    for (const auto& [name, value] : event_arguments(event)) named[name] = value;
    json["args"] = named;
  }
  return json.dump();
}

std::string event_log_line(std::span<const std::uint8_t> bytes, const telemetry::PacketConfig& config) {
  const auto opened = telemetry::open_packet(bytes, config);
  telemetry::EventPacket event;
  if (!opened || opened.value().definition->id != telemetry::PacketId::event ||
      telemetry::decode(bytes, config, event) != Status::ok)
    return {};
  const telemetry::EventDefinition* definition = telemetry::find_event(event.event_id);
  std::string line = format_seconds(static_cast<std::int64_t>(event.time_ns)) +
                     format_text(" frame %u %-6s ", event.frame_sequence, severity_of(opened.value().header)) +
                     (definition != nullptr ? definition->name : std::to_string(event.event_id).c_str()) +
                     " status=" + to_string(static_cast<Status>(event.status));
  for (const auto& [name, value] : event_arguments(event)) line += " " + name + "=" + std::to_string(value);
  if (event.occurrence > 1) line += " occurrence=" + std::to_string(event.occurrence);
  if (event.suppressed > 0) line += " suppressed=" + std::to_string(event.suppressed);
  if (definition != nullptr) line += std::string("  # ") + definition->description;
  return line;
}

}  // namespace relnav::hil
