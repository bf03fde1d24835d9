#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace relnav {

struct UdpAddress {
  std::string host;
  std::uint16_t port = 0;  ///< 1 to 65535
};

/// udp://HOST:PORT or udp://[IPV6]:PORT; nothing when `url` is neither.
[[nodiscard]] std::optional<UdpAddress> udp_address_in(const std::string& url);

}  // namespace relnav
