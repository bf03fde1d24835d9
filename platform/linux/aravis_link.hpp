#pragma once
#include <cstdint>
#include <string>

#include "fsw/base/status.hpp"

namespace relnav::platform::linux {

/// Whether a GigE Vision camera answers at an IPv4 address, and by which of our own addresses it is reached. Asks it by itself:
/// Aravis would take seconds to find out that nobody is there. no_data: no answer within 0.3 s.
Status find_gige_camera(const std::string& address, std::string& our_address);

/// Whether `text` is an IPv4 address.
[[nodiscard]] bool is_ipv4_address(const std::string& text);

/// Gives this process' datagram socket at `port` its receive buffer, as far as the system allows. Aravis does so only when the first frame is there, which
/// costs that frame where it is large.
Status set_receive_buffer(std::uint16_t port, std::uint32_t bytes);

}  // namespace relnav::platform::linux
