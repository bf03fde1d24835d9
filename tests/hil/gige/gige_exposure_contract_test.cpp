// The whole chain keeps the contract of hal::ExposureControl: the driver on Aravis, the network, a served camera that is told.
#include <cmath>

#include "platform/host/steady_clock.hpp"
#include "platform/linux/aravis_driver.hpp"
#include "platform/linux/stream_exposure.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include "tests/contract/exposure_control_contract.hpp"  // last: it redefines new

namespace {

using namespace relnav;
using namespace relnav::platform::linux;

class GigeExposureHarness {
 public:
  GigeExposureHarness() : server_(network_then_place(), false, {}) { server_.plug(source_.shape()); }
  ~GigeExposureHarness() { static_cast<void>(camera_.stop()); }
  hal::ExposureControl& control() { return exposure_; }
  Status start() { return camera_.start(); }
  bool lose_device() {
    server_.unplug();
    hal::Frame frame;
    Status status = Status::timeout;
    for (int i = 0; i < 20 && status != Status::device_lost; ++i) {
      status = camera_.acquire(Duration{500'000'000}, frame);
    }
    return status == Status::device_lost;
  }
  void restore_device() {
    server_.plug(source_.shape());
    std::this_thread::sleep_for(std::chrono::nanoseconds(camera_.until_next_attempt().ns));
  }
  bool refuse_next() { return false; }  // it takes everything
  Duration next_exposure() {
    // On the monotonic clock exposures begin when they begin: this one's is later than what was told before.
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    const auto image = source_.image(number_);
    hil::ServedFrame served;
    served.image = image.get();
    served.stamp = clock_.now();
    served.number = number_++;
    CHECK_TRUE(server_.write(served, Duration{2'000'000'000}));
    hal::Frame frame;
    CHECK_TRUE(camera_.acquire(Duration{2'000'000'000}, frame) == Status::ok);
    CHECK_TRUE(camera_.release(frame) == Status::ok);
    return frame.exposure;
  }
  hal::Exposure in_device() {
    return {Duration{std::int64_t{server_.exposure_us()} * 1000}, std::pow(10.0, server_.raw_gain() / 20.0)};
  }
  Time now() { return clock_.now(); }
  Duration slack() const { return {200'000'000}; }  // other processes want the machine, too

 private:
  static hil::GigeServer::Place network_then_place() {
    enter_own_network();
    return {served_address, served_serial};
  }
  static CameraSettings settings() {
    CameraSettings settings = settings_for(320, 240);
    settings.original_stamps = false;
    settings.rate_hz = 20.0;  // no exposure is longer than 50 ms
    return settings;
  }

  CountedFrames source_{320, 240, 1000, 20.0};
  std::uint64_t number_ = 0;
  hil::GigeServer server_;
  platform::host::SteadyClock clock_;
  AravisDriver driver_;
  StreamCamera camera_{driver_, clock_, settings(), StreamOptions()};
  StreamExposure exposure_{camera_, {GainUnit::Kind::decibel, 1.0}};
};

}  // namespace

RELNAV_EXPOSURE_CONTROL_CONTRACT(GigeExposureContract, GigeExposureHarness)
