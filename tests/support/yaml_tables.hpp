#pragma once
#include <yaml-cpp/yaml.h>

namespace relnav::test {

/// yaml-cpp makes its tables when they are first asked for: before all tests, or the first one to meet such a text seems to leak.
inline const bool has_yaml_tables = YAML::Load("a: {b: [1, 'c', \"d\", .inf, ~]}\ne: |\n  f\n# g\n").IsMap();

}  // namespace relnav::test
