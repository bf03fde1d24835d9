#pragma once
#include <CLI/CLI.hpp>

namespace relnav::hil {

/// Each adds one subcommand; its callback stores the exit status.
void add_capture_command(CLI::App& app, int& exit_status);
void add_evaluate_command(CLI::App& app, int& exit_status);
void add_export_command(CLI::App& app, int& exit_status);
void add_montecarlo_command(CLI::App& app, int& exit_status);
void add_pack_command(CLI::App& app, int& exit_status);
void add_replay_command(CLI::App& app, int& exit_status);
void add_solve_command(CLI::App& app, int& exit_status);
void add_scenario_command(CLI::App& app, int& exit_status);
void add_sim_command(CLI::App& app, int& exit_status);
void add_serve_command(CLI::App& app, int& exit_status);
void add_tlm_command(CLI::App& app, int& exit_status);

inline constexpr int exit_done = 0;
inline constexpr int exit_fault = 1;     ///< ran, but the run ended in a fault
inline constexpr int exit_unusable = 2;  ///< unusable arguments or input

}  // namespace relnav::hil
