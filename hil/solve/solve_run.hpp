#pragma once
#include <functional>
#include <string>
#include <vector>

#include "hal/packet_link.hpp"
#include "hil/io/observation_file.hpp"
#include "hil/replay/replay_run.hpp"
#include "hil/solve/epoch_solver.hpp"

namespace relnav::hil {

/// Solves every epoch, writes the run's growing files and telemetry. Epochs without a valid pose are events, no rows. Throws
/// InputError when the output cannot be written.
ReplayOutcome run_solve(const SolveSetup& setup, const CameraRig& rig, const TargetModel& target,
                        const std::string& observation_file, const std::vector<ObservationEpoch>& epochs,
                        hal::PacketLink& link, RunFiles& files, RunHistory& history, const ProgressListener& listener);

}  // namespace relnav::hil
