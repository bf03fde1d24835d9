#pragma once
#include <cstdint>

#include "fsw/app/telemetry_writer.hpp"

namespace relnav::app {

/// One EVENT packet straight to the link: for a program that cannot start its flight loop, or cannot go on. Needs nothing of the
/// loop's; the packet's counts begin at 0, as after a start. The link's answer, or not_finite and so on of telemetry::encode().
Status send_final_event(hal::PacketLink& link, const telemetry::PacketConfig& packets, telemetry::EventId id,
                        Status reason, const EventArgs& args = {});

}  // namespace relnav::app
