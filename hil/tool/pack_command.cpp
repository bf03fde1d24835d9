#include <cstdio>
#include <filesystem>
#include <memory>

#include "hil/replay/target_pack.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/flight_options.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

struct PackOptions {
  FlightOptions flight;
  std::string out;
};

int run(const PackOptions& o) {
  const FlightInput input = read_flight_input(o.flight);
  const app::FlightLoopConfig config = flight_config_of(input.setup);
  std::error_code error;
  std::filesystem::create_directories(o.out, error);
  if (error) throw InputError(o.out, 0, "cannot be created: " + error.message(), "a writable output folder");
  pack_config(config, o.out + "/setup.bin");
  pack_frames(input.images, config.camera, input.depth, o.out + "/frames0.rnc");
  if (config.navigation == app::NavigationKind::coop_stereo) {
    pack_frames(input.second_images, config.second.intrinsics, input.depth, o.out + "/frames1.rnc");
  }
  std::printf("%zu frames and the configuration in %s\n", input.images.size() + input.second_images.size(),
              o.out.c_str());
  return exit_done;
}

}  // namespace

void add_pack_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<PackOptions>();
  CLI::App* command = app.add_subcommand("pack", "Captured frames and configuration for a target without files");
  add_flight_options(*command, o->flight);
  command->add_option("--out", o->out, "Folder for setup.bin and frames*.rnc; existing ones are replaced")->required();
  command->callback([o, &exit_status] { exit_status = run(*o); });
}

}  // namespace relnav::hil
