#include "platform/files/udp_address.hpp"

#include <string_view>

#include "platform/files/text.hpp"

namespace relnav {

std::optional<UdpAddress> udp_address_in(const std::string& url) {
  const std::string scheme = "udp://";
  const std::size_t colon = url.rfind(':');
  if (url.rfind(scheme, 0) != 0 || colon == std::string::npos || colon < scheme.size()) return std::nullopt;
  UdpAddress address{url.substr(scheme.size(), colon - scheme.size()), 0};
  if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']') {
    address.host = address.host.substr(1, address.host.size() - 2);
  }
  const auto port = parse_int64(std::string_view(url).substr(colon + 1));
  if (address.host.empty() || !port || *port < 1 || *port > 65535) return std::nullopt;
  address.port = static_cast<std::uint16_t>(*port);
  return address;
}

}  // namespace relnav
