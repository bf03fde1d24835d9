#include <cstdio>
#include <exception>

#include "hil/tool/commands.hpp"

int main(int argc, char** argv) {
  using namespace relnav::hil;
  CLI::App app{"relnav: vision-based relative navigation, replayed and judged on a PC"};
  app.set_version_flag("--version", RELNAV_VERSION);
  app.require_subcommand(1);
  int exit_status = exit_done;
  add_replay_command(app, exit_status);
  add_pack_command(app, exit_status);
  add_evaluate_command(app, exit_status);
  add_scenario_command(app, exit_status);
  add_solve_command(app, exit_status);
  add_capture_command(app, exit_status);
  add_export_command(app, exit_status);
  add_serve_command(app, exit_status);
  add_tlm_command(app, exit_status);
#ifdef RELNAV_HAS_SIMULATION
  add_sim_command(app, exit_status);
  add_montecarlo_command(app, exit_status);
#endif
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "relnav: %s (see relnav --help)\n", error.what());
    return exit_unusable;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "relnav: %s\n", error.what());
    return exit_unusable;
  }
  return exit_status;
}
