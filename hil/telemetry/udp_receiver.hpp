#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "hil/replay/telemetry_link.hpp"

namespace relnav::hil {

/// Datagrams arriving at a UDP address of this machine.
class UdpReceiver {
 public:
  /// Throws InputError when the address cannot be listened on.
  explicit UdpReceiver(const std::string& url);
  UdpReceiver(const UdpReceiver&) = delete;
  UdpReceiver& operator=(const UdpReceiver&) = delete;
  ~UdpReceiver();

  /// The next datagram; empty when nothing came within `wait_ms` or a signal interrupted.
  [[nodiscard]] std::span<const std::uint8_t> receive(int wait_ms);

 private:
  int socket_ = -1;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace relnav::hil
