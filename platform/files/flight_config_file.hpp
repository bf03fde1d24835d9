#pragma once
#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "fsw/app/flight_config.hpp"

namespace relnav {

/// Overwrites the values named in a YAML file: sections `filter`, `front_end`, `cooperative`, `exposure`, `loop`; keys and meaning as the
/// members of NoncoopConfig, NavigatorConfig, CoopNavigatorConfig and FlightLoopConfig. Throws InputError on an unknown key and
/// on a value that the flight loop would refuse, by the motion that `config` names.
void read_flight_config(const std::string& path, app::FlightLoopConfig& config);

/// The same sections within a larger file: keys of `root` that name none of them are somebody else's.
void read_flight_config(const std::string& path, const YAML::Node& root, app::FlightLoopConfig& config);

[[nodiscard]] std::vector<std::string> flight_config_sections();

}  // namespace relnav
