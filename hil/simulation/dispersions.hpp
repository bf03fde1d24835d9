#pragma once
#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <map>
#include <string>

namespace relnav::hil {

/// Applies section `dispersions` of a scenario to the scenario itself: each key names a number elsewhere in the file by its path
/// (`motion.target.rate_deg_s`, list elements as `...rate_deg_s.1`; a list without an index means each of its elements), the value
/// says what is added to it: `{normal: SIGMA}`, `{uniform: HALF_WIDTH}`; or what it is multiplied by: `{factor: SIGMA}` is
/// exp(SIGMA * normal); or, with `{choice: [...]}`, what it becomes. `probability: P` applies it in that share of the runs.
/// A key that is missing in the file counts as 0; whether there is such a key is for the scenario to say. What is drawn depends on seed and path alone, not on
/// the order in the file. Returns the new values by path. Throws InputError with the line.
std::map<std::string, double> disperse(const std::string& path, YAML::Node& root, std::uint64_t seed);

}  // namespace relnav::hil
