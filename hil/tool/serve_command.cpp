#include <cstdio>
#include <memory>

#include "hil/io/dataset.hpp"
#include "hil/serve/frame_player.hpp"
#include "hil/serve/v4l2_sink.hpp"
#include "hil/tool/commands.hpp"
#include "hil/tool/interrupt.hpp"
#include "hil/tool/notes.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#ifdef RELNAV_HAS_GIGE
#include "hil/serve/gige_server.hpp"
#endif

namespace relnav::hil {
namespace {

struct ServeOptions {
  std::string dataset;
  int camera = 0;
  std::string gige;
  std::string v4l2;
  std::string trigger_file;
  std::string rate = "real";
  std::vector<std::string> faults;
  bool loop = false;
};

PlayerSettings player_settings(const ServeOptions& o) {
  PlayerSettings settings;
  settings.loop = o.loop;
  for (const std::string& fault : o.faults) settings.faults.push_back(parse_fault(fault));
  if (o.rate == "lockstep") {
    settings.speed = 0.0;
  } else if (o.rate != "real") {
    const auto factor = parse_double(o.rate);
    if (!factor || !(*factor >= 1e-3 && *factor <= 1e3))
      throw InputError("--rate " + in_quotes(o.rate), 0, "is no rate",
                       "real, lockstep, or a factor from 0.001 to 1000 on the captured rate");
    settings.speed = *factor;
  }
  return settings;
}

std::unique_ptr<FrameSink> make_sink(const ServeOptions& o, bool lock_step) {
  if (o.gige.empty() == o.v4l2.empty())
    throw InputError("relnav serve", 0,
                     "is told " + std::string(o.gige.empty() ? "no place" : "two places") + " for the camera",
                     "--gige ADDRESS or --v4l2 DEVICE");
  if (!o.v4l2.empty()) {
    if (lock_step && o.trigger_file.empty())
      throw InputError("--rate lockstep", 0,
                       "needs a trigger here: a loopback device does not tell when a frame is wanted",
                       "--trigger-file PATH");
    return std::make_unique<V4l2Sink>(o.v4l2, o.trigger_file);
  }
  if (!o.trigger_file.empty())
    throw InputError("--trigger-file", 0, "is for --v4l2: a GigE Vision camera is triggered by software",
                     "no trigger file");
#ifdef RELNAV_HAS_GIGE
  return std::make_unique<GigeServer>(GigeServer::parse_place(o.gige), lock_step, [](const std::string& line) {
    std::fprintf(stderr, "relnav: %s\n", line.c_str());
  });
#else
  throw InputError("--gige", 0, "this relnav was built without Aravis", "a build where pkg-config finds aravis-0.8");
#endif
}

int serve(const ServeOptions& o) {
  const PlayerSettings settings = player_settings(o);
  const auto sink = make_sink(o, settings.speed <= 0.0);
  CapturedSource source(find_camera(o.dataset, o.camera).images);
  print_notes(source.notes());
  catch_interrupts();
  const auto ready = [&] {
    const FrameShape shape = source.shape();
    std::printf("serving %zu frames, %u x %u pixels of %u bits, at %s\n", source.count(), shape.width_px,
                shape.height_px, 8 * shape.bytes_per_pixel, (o.gige + o.v4l2).c_str());
    std::fflush(stdout);
  };
  const PlayedFrames played = FramePlayer(source, settings).play(*sink, interrupted, ready);
  std::printf("%llu frames sent, %llu lost by faults, %llu not taken in time\n",
              static_cast<unsigned long long>(played.sent), static_cast<unsigned long long>(played.lost),
              static_cast<unsigned long long>(played.unseen));
  return exit_done;
}

}  // namespace

void add_serve_command(CLI::App& app, int& exit_status) {
  const auto o = std::make_shared<ServeOptions>();
  CLI::App* command = app.add_subcommand("serve", "Captured frames as a camera that others see");
  command
      ->add_option("--dataset", o->dataset,
                   "Folder in the EuRoC layout (mav0/camN/{data.csv,data/}) or with camN.rnc; or FILE.rnc")
      ->required();
  command->add_option("--camera", o->camera, "N of camN [0]")->check(CLI::Range(0, 9));
  command->add_option("--gige", o->gige, "ADDRESS[,SERIAL]: a GigE Vision camera at this IPv4 address of this machine");
  command->add_option("--v4l2", o->v4l2, "DEVICE: a V4L2 camera, by this device of v4l2loopback");
  command->add_option("--trigger-file", o->trigger_file, "With --v4l2: a pipe with one line for each trigger");
  command->add_option("--rate", o->rate,
                      "real, lockstep (one frame a trigger), or a factor on the captured rate [real]");
  command->add_option("--fault", o->faults, fault_syntax);
  command->add_flag("--loop", o->loop, "From the start again at the end");
  command->callback([o, &exit_status] { exit_status = serve(*o); });
}

}  // namespace relnav::hil
