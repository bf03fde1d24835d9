#include "hil/replay/telemetry_link.hpp"

#include <algorithm>

#include "platform/files/input_error.hpp"

namespace relnav::hil {

UdpAddress parse_udp_url(const std::string& url) {
  if (const auto address = udp_address_in(url)) return *address;
  throw InputError(url, 0, "is no UDP address", "udp://HOST:PORT, port 1 to 65535");
}

void TelemetryLink::open(const std::string& file, Listener listener) {
  path_ = file;
  listener_ = std::move(listener);
  if (file_.open(file.c_str()) != Status::ok)
    throw InputError(file, 0, "cannot be created", "a writable output folder");
  for (const auto& packet : early_) static_cast<void>(send(packet));
  early_.clear();
}

void TelemetryLink::add_udp(const std::string& url) {
  const UdpAddress address = parse_udp_url(url);
  const Status status = udp_.open(address.host.c_str(), address.port);
  if (status != Status::ok)
    throw InputError(url, 0, std::string("cannot be reached: ") + to_string(status), "a host and port that resolve");
  has_udp_ = true;
}

Status TelemetryLink::send(std::span<const std::uint8_t> packet) {
  if (path_.empty()) {
    if (packet.empty() || packet.size() > max_packet_bytes()) return Status::invalid_argument;
    early_.emplace_back(packet.begin(), packet.end());
    return Status::ok;
  }
  const Status status = file_.send(packet);
  if (status == Status::ok && listener_) listener_(packet);
  if ((status == Status::no_capacity || status == Status::io_error) && problem_.empty()) {
    problem_ =
        InputError(path_, 0, std::string("cannot be written: ") + to_string(status), "room and permission to write")
            .what();
  }
  if (has_udp_) static_cast<void>(udp_.send(packet));  // a listener that is not there does not stop the run
  return status;
}

std::uint32_t TelemetryLink::max_packet_bytes() const {
  return has_udp_ ? std::min(file_.max_packet_bytes(), udp_.max_packet_bytes()) : file_.max_packet_bytes();
}

}  // namespace relnav::hil
