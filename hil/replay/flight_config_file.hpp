#pragma once
#include <string>

#include "fsw/app/flight_config.hpp"

namespace relnav::hil {

/// Overwrites the values named in a YAML file: sections `filter`, `front_end`, `loop`; keys and meaning as the members of
/// NoncoopConfig, NavigatorConfig and FlightLoopConfig. Throws InputError on an unknown key or a value that is no number.
void read_flight_config(const std::string& path, app::FlightLoopConfig& config);

}  // namespace relnav::hil
