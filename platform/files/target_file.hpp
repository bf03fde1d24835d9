#pragma once
#include <string>

#include "fsw/geometry/target_model.hpp"

namespace relnav {

/// Target model in YAML: `frame`, optional `unit` (m, mm), `features: [{id, xyz, normal (optional)}, ...]`, optional
/// `lines: [[id, id], ...]`. Unknown keys are ignored. Normals are brought to unit length.
/// Throws InputError: ids repeat, fewer than 3 features or all on one line, more than there is room for, numbers missing
/// or not finite, a normal of length zero, a line with an unknown id or from a feature to itself.
[[nodiscard]] TargetModel read_target_file(const std::string& path);

/// The text of a target file in metres that reads back as this model.
[[nodiscard]] std::string target_file_text(const TargetModel& target);

}  // namespace relnav
