#include <cstdio>
#include <memory>

#include "hil/telemetry/packet_text.hpp"
#include "hil/telemetry/udp_receiver.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

struct TlmOptions {
  std::string source;
  bool json = false;
};

void print(std::span<const std::uint8_t> packet, bool json) {
  const telemetry::PacketConfig config;
  std::puts((json ? packet_json(packet, config) : packet_text(packet, config)).c_str());
}

int decode_file(const TlmOptions& options) {
  const std::string text = read_text(options.source);
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  std::size_t at = 0;
  while (at < bytes.size()) {
    // Version 0, telemetry, with secondary header: anything else is no stream of packets, or its framing is lost.
    if ((bytes[at] & 0xF8U) != 0x08U) {
      throw InputError(options.source, 0, format_text("byte %zu: no telemetry packet begins here", at),
                       "CCSDS Space Packets, one after the other");
    }
    const auto length = telemetry::framed_length(bytes.subspan(at));
    if (!length) {
      throw InputError(
          options.source, 0,
          format_text("byte %zu: %s, %zu bytes are left", at, to_string(length.status()), bytes.size() - at),
          "a whole CCSDS packet");
    }
    print(bytes.subspan(at, length.value()), options.json);
    at += length.value();
  }
  return exit_done;
}

int decode_udp(const TlmOptions& options) {
  UdpReceiver receiver(options.source);
  catch_interrupts();
  constexpr int wait_ms = 200;
  while (!interrupted()) {
    const auto packet = receiver.receive(wait_ms);
    if (packet.empty()) continue;
    print(packet, options.json);
    std::fflush(stdout);
  }
  return exit_done;
}

}  // namespace

void add_tlm_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<TlmOptions>();
  CLI::App* tlm = app.add_subcommand("tlm", "Telemetry packets");
  tlm->require_subcommand(1);
  CLI::App* decode = tlm->add_subcommand("decode", "Packets to text, one line each; from UDP until interrupted");
  decode->add_option("source", options->source, "File of packets, or udp://HOST:PORT to listen on")->required();
  decode->add_flag("--json", options->json, "One JSON object a line");
  decode->callback([options, &exit_status] {
    exit_status = options->source.rfind("udp://", 0) == 0 ? decode_udp(*options) : decode_file(*options);
  });
}

}  // namespace relnav::hil
