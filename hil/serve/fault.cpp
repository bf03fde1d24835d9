#include "hil/serve/fault.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

constexpr std::array fault_names{
    std::pair{"lost", FaultKind::lost},       std::pair{"frozen", FaultKind::frozen},
    std::pair{"torn", FaultKind::torn},       std::pair{"black", FaultKind::black},
    std::pair{"white", FaultKind::white},     std::pair{"time_jump", FaultKind::time_jump},
    std::pair{"packets", FaultKind::packets}, std::pair{"unplug", FaultKind::unplug},
};
constexpr double usual_packets_lost = 20.0;  // in a thousand

[[noreturn]] void refuse_fault(std::string_view text, const std::string& problem) {
  throw InputError("--fault " + in_quotes(text), 0, problem, fault_syntax);
}

}  // namespace

Fault parse_fault(std::string_view text) {
  const auto at = text.find('@');
  if (at == std::string_view::npos) refuse_fault(text, "has no @");
  Fault fault;
  bool known = false;
  for (const auto& [name, kind] : fault_names) {
    if (text.substr(0, at) != name) continue;
    fault.kind = kind;
    known = true;
  }
  if (!known) refuse_fault(text, "is of no known kind");
  const auto parts = split(text.substr(at + 1), ':');
  const auto frame = parse_int64(parts[0]);
  if (!frame || *frame < 0) refuse_fault(text, "begins at no frame");
  fault.frame = static_cast<std::uint64_t>(*frame);

  const bool has_amount_only = fault.kind == FaultKind::time_jump || fault.kind == FaultKind::unplug;
  const std::size_t most = fault.kind == FaultKind::packets ? 3 : 2;
  if (parts.size() > most || (has_amount_only && parts.size() < 2))
    refuse_fault(text, "has not as many parts as its kind");
  if (has_amount_only) {
    const auto amount = parse_double(parts[1]);
    if (!amount || !std::isfinite(*amount) || std::abs(*amount) > 1e9) refuse_fault(text, "has no usable amount");
    if (fault.kind == FaultKind::unplug && *amount <= 0.0) refuse_fault(text, "takes no time");
    fault.amount = *amount;
    return fault;
  }
  if (parts.size() > 1) {
    const auto count = parse_int64(parts[1]);
    if (!count || *count < 1) refuse_fault(text, "hits no frame");
    fault.count = static_cast<std::uint64_t>(*count);
  }
  if (fault.kind == FaultKind::packets) fault.amount = usual_packets_lost;
  if (parts.size() > 2) {
    const auto amount = parse_double(parts[2]);
    if (!amount || !(*amount > 0.0 && *amount <= 1000.0))
      refuse_fault(text, "loses not 1 to 1000 packets in a thousand");
    fault.amount = *amount;
  }
  return fault;
}

}  // namespace relnav::hil
