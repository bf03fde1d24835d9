#pragma once
#include "hil/dynamics/motion_settings.hpp"
#include "platform/files/file_section.hpp"

namespace relnav::hil {

/// What the section `motion` of a scenario file may hold (docs/simulation-motion.md explains each).
[[nodiscard]] std::vector<std::string> motion_keys();

/// Reads it, made with motion_keys(); every contradiction and impossibility is named with its line (InputError), those
/// of the whole course of the legs too.
[[nodiscard]] MotionSettings read_motion(const FileSection& section);

}  // namespace relnav::hil
