// The whole chain keeps the contract of hal::Camera: StreamCamera, the driver on Aravis, the network, a served camera.
#include "platform/host/steady_clock.hpp"
#include "platform/linux/aravis_driver.hpp"
#include "platform/linux/stream_camera.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include "tests/contract/camera_contract.hpp"  // last: it redefines new

namespace {

using namespace relnav;
using namespace relnav::platform::linux;

/// The server sends exactly the frames that are offered, while somebody streams.
class GigeHarness {
 public:
  GigeHarness() : server_(network_then_place(), false, {}) { server_.plug(source_.shape()); }
  ~GigeHarness() { static_cast<void>(camera_.stop()); }
  hal::Camera& camera() { return camera_; }
  bool offer_frame() { return offer(0); }
  bool offer_damaged_frame() { return offer(100); }
  bool lose_device() {
    server_.unplug();
    return true;
  }
  void restore_device() {
    server_.plug(source_.shape());
    std::this_thread::sleep_for(std::chrono::nanoseconds(camera_.until_next_attempt().ns));
  }
  Duration wait() const { return {2'000'000'000}; }
  Time now() { return clock_.now(); }
  Duration slack() const { return {200'000'000}; }  // other processes want the machine, too

 private:
  static hil::GigeServer::Place network_then_place() {
    enter_own_network();
    return {served_address, served_serial};
  }
  static CameraSettings settings() {
    CameraSettings settings = settings_for(320, 240);
    settings.packet_bytes = 1000;  // some 80 a frame: the damaged one does not come through by luck
    settings.original_stamps = false;
    return settings;
  }
  static StreamOptions options() {
    StreamOptions options;
    options.first_frame_timeout = options.frame_timeout;  // less than wait(): a loss is noticed in it
    return options;
  }
  bool offer(std::uint32_t packets_lost_per_mille) {
    if (!camera_.is_streaming()) return true;  // a camera sends nothing then
    const auto image = source_.image(number_);
    hil::ServedFrame frame;
    frame.image = image.get();
    frame.stamp = clock_.now();
    frame.number = number_++;
    frame.packets_lost_per_mille = packets_lost_per_mille;
    return server_.write(frame, Duration{2'000'000'000});
  }

  CountedFrames source_{320, 240, 1000, 50.0};
  std::uint64_t number_ = 0;
  hil::GigeServer server_;
  platform::host::SteadyClock clock_;
  AravisDriver driver_;
  StreamCamera camera_{driver_, clock_, settings(), options()};
};

}  // namespace

RELNAV_CAMERA_CONTRACT(GigeCamera, GigeHarness)
