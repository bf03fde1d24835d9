#pragma once
#include <string>

#include "fsw/app/flight_config.hpp"

namespace relnav {

/// Overwrites the values named in a YAML file: sections `filter`, `front_end`, `cooperative`, `loop`; keys and meaning as the
/// members of NoncoopConfig, NavigatorConfig, CoopNavigatorConfig and FlightLoopConfig. Throws InputError on an unknown key and
/// on a value that the flight loop would refuse, by the motion that `config` names.
void read_flight_config(const std::string& path, app::FlightLoopConfig& config);

}  // namespace relnav
