#pragma once
/// The tables of docs/telemetry-icd.md, made from the packet table.
#include <cstddef>
#include <ostream>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "fsw/telemetry/telecommand.hpp"

namespace icd_text {

using namespace relnav::telemetry;

inline constexpr const char* field_head = "| offset | field | type | unit | meaning |\n|---|---|---|---|---|\n";

inline void field_rows(std::ostream& out, std::span<const FieldDefinition> fields, std::size_t offset) {
  for (const FieldDefinition& field : fields) {
    out << "| " << offset << " | `" << field.name << "` | " << to_string(field.type);
    if (field.count > 1) out << " x " << field.count;
    out << " | " << field.unit << " | " << field.description;
    if (field.labels.kind != LabelKind::none) out << "; see " << field.labels.name;
    out << " |\n";
    offset += size_of(field);
  }
}

/// Adds the enumerations that are not there yet; events have a table of their own.
inline void collect(std::vector<Labels>& all, std::span<const FieldDefinition> fields) {
  for (const FieldDefinition& field : fields) {
    const std::string_view name = field.labels.name;
    bool known = field.labels.kind == LabelKind::none || name == labels::event.name;
    for (const Labels& labels : all) known = known || name == labels.name;
    if (!known) all.push_back(field.labels);
  }
}

inline void packet_rows(std::ostream& out) {
  out << "### Packets\n\n| packet | APID | service, subtype | structure id | bytes | sent "
         "|\n|---|---|---|---|---|---|\n";
  for (const PacketDefinition& p : packet_definitions) {
    out << "| " << p.name << " | base + " << p.apid_offset << " | " << int{p.service} << ", " << int{p.subtype_first};
    if (p.subtype_last != p.subtype_first) out << " to " << int{p.subtype_last};
    out << " | ";
    if (p.structure_id == 0) {
      out << "none";
    } else {
      out << p.structure_id;
    }
    out << " | " << packet_size(p);
    if (p.max_entries > 0) out << " + " << size_of(p.entry_fields) << " n, n <= " << p.max_entries;
    out << " | " << p.rate << " |\n";
  }
}

inline void packet_section(std::ostream& out, const PacketDefinition& p) {
  const std::size_t start = primary_header_bytes + secondary_header_bytes + (p.structure_id == 0 ? 0U : 2U);
  out << "\n### " << p.name << "\n\n" << field_head;
  field_rows(out, p.fields, start);
  if (p.entry_fields.empty()) return;
  const std::size_t count_at = start + size_of(p.fields);
  out << "| " << count_at << " | `n` | u16 |  | Entries that follow |\n";
  out << "\nEach of the n entries, offsets from its start; the first one starts at " << count_at + 2 << ":\n\n"
      << field_head;
  field_rows(out, p.entry_fields, 0);
}

inline void code_lists(std::ostream& out, std::span<const Labels> all) {
  out << "\n### Codes\n";
  for (const Labels& labels : all) {
    const bool flags = labels.kind == LabelKind::flags;
    out << "\n" << labels.name << (flags ? " (bits): " : ": ");
    const char* separator = "";
    for (const Label& label : labels.items) {
      out << separator;
      if (flags) out << "0x" << std::hex;
      out << label.value << std::dec << " " << label.name;
      separator = ", ";
    }
    out << ".\n";
  }
}

inline void event_rows(std::ostream& out) {
  out << "\n### Events\n\n| id | name | severity | meaning | args |\n|---|---|---|---|---|\n";
  for (const EventDefinition& e : event_definitions) {
    out << "| " << static_cast<int>(e.id) << " | `" << e.name << "` | " << to_string(e.severity) << " | "
        << e.description << " | ";
    const char* separator = "";
    for (const char* arg : e.args) {
      if (arg[0] == '\0') break;
      out << separator << arg;
      separator = ", ";
    }
    out << " |\n";
  }
}

inline void telecommand_rows(std::ostream& out) {
  out << "\n### Telecommands\n\n| name | service, subtype | data | bytes | what it does |\n|---|---|---|---|---|\n";
  for (const TelecommandDefinition& d : telecommand_definitions) {
    out << "| `" << d.name << "` | " << int{d.service} << ", " << int{d.subtype} << " | ";
    if (data_bytes(d) == 0) out << "none";
    if (d.function_id != 0) out << "u8 function id " << int{d.function_id};
    if (d.argument_bytes != 0) out << "u" << 8 * d.argument_bytes << " argument";
    out << " | " << telecommand_size(d) << " | " << d.description << " |\n";
  }
}

/// Everything between the two markers of the document.
inline std::string tables() {
  std::ostringstream out;
  packet_rows(out);
  std::vector<Labels> all;
  for (const PacketDefinition& p : packet_definitions) {
    packet_section(out, p);
    collect(all, p.fields);
    collect(all, p.entry_fields);
  }
  code_lists(out, all);
  event_rows(out);
  telecommand_rows(out);
  return out.str();
}

}  // namespace icd_text
