#include "hil/replay/target_pack.hpp"

#include <array>
#include <fstream>
#include <stdexcept>

#include "fsw/app/config_image.hpp"
#include "hil/io/raw_container.hpp"
#include "platform/files/input_error.hpp"
#include "platform/host/steady_clock.hpp"

namespace relnav::hil {

void pack_config(const app::FlightLoopConfig& config, const std::string& path) {
  std::array<std::uint8_t, app::max_config_image_bytes> image{};
  std::size_t size = 0;
  if (app::write_config_image(config, image, size) != Status::ok)
    throw std::logic_error("the configuration has no room");
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(size));
  file.flush();
  if (!file) throw InputError(path, 0, "cannot be written", "room and permission to write");
}

void pack_frames(const std::vector<ImageEntry>& images, const CameraIntrinsics& camera, Depth depth,
                 const std::string& path) {
  platform::host::SteadyClock clock;
  ReplayCamera source(images, static_cast<std::uint32_t>(camera.width_px), static_cast<std::uint32_t>(camera.height_px),
                      clock, Pace::max, depth);
  RawContainerWriter container(path);
  if (source.start() != Status::ok) throw std::logic_error("a replay camera always starts");
  while (!source.exhausted()) {
    hal::Frame frame;
    if (source.acquire({}, frame) != Status::ok) throw std::runtime_error(source.problem());
    container.add(frame);
    static_cast<void>(source.release(frame));
  }
  container.finish();
}

}  // namespace relnav::hil
