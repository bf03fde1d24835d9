#include "fsw/app/command_service.hpp"

#include "fsw/app/saturating.hpp"

namespace relnav::app {

using telemetry::CommandStage;

void CommandService::configure(const telemetry::PacketConfig& packets) {
  packets_ = packets;
  refused_ = 0;
}

Status CommandService::next(telemetry::Telecommand& command) {
  command = telemetry::Telecommand();
  if (source_ == nullptr) return Status::no_data;
  std::size_t bytes = 0;
  Status status = source_->receive(buffer_, bytes);
  if (status == Status::no_data) return status;
  if (status == Status::ok) {
    status = telemetry::parse_telecommand(std::span<const std::uint8_t>(buffer_).first(bytes), packets_, command);
  }
  if (status == Status::ok) {
    acknowledge(command.request, CommandStage::accepted, Status::ok);
  } else {
    refuse(command, status);
  }
  return status;
}

void CommandService::refuse(const telemetry::Telecommand& command, Status reason) {
  increment(refused_);
  if (command.is_ours) acknowledge(command.request, CommandStage::refused, reason);
  if (command.is_ours || reason != Status::unsupported) report(command.request, reason);
}

void CommandService::finish(const telemetry::TelecommandRequest& request, Status outcome) {
  acknowledge(request, outcome == Status::ok ? CommandStage::done : CommandStage::failed, outcome);
  if (outcome == Status::ok) return;
  increment(refused_);
  report(request, outcome);
}

void CommandService::acknowledge(const telemetry::TelecommandRequest& request, CommandStage stage, Status code) {
  telemetry::CommandAckPacket p;
  p.request_packet_id = request.packet_id;
  p.request_sequence = request.sequence;
  p.stage = static_cast<std::uint8_t>(stage);
  p.code = static_cast<std::uint8_t>(code);
  p.service = request.service;
  p.subtype = request.subtype;
  p.time_ns = now_ns();
  telemetry_.send_command_ack(p);
}

void CommandService::report(const telemetry::TelecommandRequest& request, Status reason) {
  events_.report(telemetry::EventId::command_refused, reason,
                 {request.service, request.subtype, request.sequence & 0x3FFF, refused_});
}

void CommandService::pong() {
  telemetry::PongPacket p;
  p.time_ns = now_ns();
  telemetry_.send_pong(p);
}

}  // namespace relnav::app
