// Every implementation of hal::ExposureControl that needs no hardware.
#include <linux/videodev2.h>

#include "platform/host/scripted_exposure_control.hpp"
#include "platform/linux/stream_exposure.hpp"
#include "platform/linux/v4l2_driver.hpp"
#include "tests/support/scripted_driver.hpp"
#include "tests/support/scripted_video.hpp"

// After the rest: its macros replace new.
#include "tests/contract/exposure_control_contract.hpp"

namespace {

using namespace relnav;
using namespace relnav::platform::linux;

class ScriptedHarness {
 public:
  ScriptedHarness() {
    scripted_.state = Status::not_configured;
    scripted_.time_step = {10'000};
    scripted_.gain_step = 0.5;
  }
  hal::ExposureControl& control() { return scripted_; }
  Status start() { return scripted_.state = Status::ok; }
  bool lose_device() {
    scripted_.state = Status::device_lost;
    return true;
  }
  void restore_device() {}
  bool refuse_next() {
    scripted_.fail_sets(Status::io_error);
    return true;
  }
  Duration next_exposure() { return scripted_.applied().time; }
  hal::Exposure in_device() { return scripted_.applied(); }
  Time now() const { return {}; }
  Duration slack() const { return {0}; }

 private:
  platform::host::ScriptedExposureControl scripted_;
};

CameraSettings settings_of(const char* device, double rate_hz) {
  CameraSettings settings;
  settings.device = device;
  settings.width_px = 8;
  settings.height_px = 4;
  settings.rate_hz = rate_hz;
  return settings;
}

/// On a StreamCamera.
class StreamHarness {
 public:
  StreamHarness(CameraDriver& driver, platform::host::ScriptedClock& clock, CameraSettings settings, GainUnit unit)
      : clock_(clock), camera_(driver, clock, std::move(settings)), exposure_(camera_, unit) {}
  hal::ExposureControl& control() { return exposure_; }
  Status start() { return camera_.start(); }
  Time now() const { return clock_.peek(); }
  Duration slack() const { return {0}; }

 protected:
  bool see_loss() {
    hal::Frame frame;
    return camera_.acquire({}, frame) == Status::device_lost;
  }
  Duration take() {
    hal::Frame frame;
    CHECK_TRUE(camera_.acquire(Duration{1'000'000}, frame) == Status::ok);
    CHECK_TRUE(camera_.release(frame) == Status::ok);
    return frame.exposure;
  }
  platform::host::ScriptedClock& clock_;
  StreamCamera camera_;
  StreamExposure exposure_;
};

struct DriverParts {
  platform::host::ScriptedClock clock{Time{1'000'000'000}};
  test::ScriptedDriver driver{clock};
};

/// Gains of 0 to 40 units of half a decibel.
class DecibelHarness : private DriverParts, public StreamHarness {
 public:
  DecibelHarness()
      : StreamHarness(driver, DriverParts::clock, settings_of("scripted", 0.0), {GainUnit::Kind::decibel, 0.5}) {}
  bool lose_device() {
    driver.present = false;
    return see_loss();
  }
  void restore_device() {
    driver.present = true;
    clock_.advance(camera_.until_next_attempt());
  }
  bool refuse_next() {
    refuse_ = true;
    driver.adjust_answer = Status::io_error;
    return true;
  }
  Duration next_exposure() {
    clock_.advance(Duration{1000});
    driver.offer_good();
    return take();
  }
  hal::Exposure in_device() {
    if (refuse_) driver.adjust_answer = Status::ok;
    const test::ScriptedDriver::Shot shot = driver.shot();
    return {shot.image.exposure, std::pow(10.0, shot.image.gain * 0.5 / 20.0)};
  }

 private:
  bool refuse_ = false;
};

struct VideoParts {
  platform::host::ScriptedClock clock{Time{1'000'000'000}};
  test::ScriptedVideo device{clock};
  V4l2Driver driver{device, clock};
};

/// A UVC camera at 15 Hz: exposures in steps of 100 us, gains of 0 to 255, both of which it sets itself until told otherwise.
class UvcHarness : private VideoParts, public StreamHarness {
 public:
  UvcHarness()
      : StreamHarness(driver, VideoParts::clock, settings_of("/dev/video0", 15.0), {GainUnit::Kind::linear, 0.25}) {
    device.controls = {{V4L2_CID_EXPOSURE_AUTO, {3, 0, 3}},
                       {V4L2_CID_EXPOSURE_ABSOLUTE, {50, 3, 10'000}},
                       {V4L2_CID_AUTOGAIN, {1, 0, 1}},
                       {V4L2_CID_GAIN, {16, 0, 255}}};
  }
  ~UvcHarness() {
    CHECK_TRUE(camera_.stop() == Status::ok);
    LONGS_EQUAL(0, device.mistakes);
  }
  bool lose_device() {
    device.present = false;
    clock_.advance(Duration{10'000'000'000});
    return see_loss();
  }
  void restore_device() {
    device.present = true;
    // It has forgotten everything.
    device.controls[V4L2_CID_EXPOSURE_AUTO].value = 3;
    device.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value = 50;
    device.controls[V4L2_CID_GAIN].value = 16;
    clock_.advance(camera_.until_next_attempt());
  }
  bool refuse_next() {
    device.control_refusals[V4L2_CID_GAIN] = 1;  // with another exposure already in the camera
    return true;
  }
  Duration next_exposure() {
    clock_.advance(Duration{66'000'000});
    device.send();
    return take();
  }
  hal::Exposure in_device() {
    return {Duration{device.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value * std::int64_t{100'000}},
            0.25 * device.controls[V4L2_CID_GAIN].value};
  }
};

/// A machine-vision sensor without automatism and without gain; exposures in lines.
class LinesHarness : private VideoParts, public StreamHarness {
 public:
  LinesHarness() : StreamHarness(driver, VideoParts::clock, settings_of("/dev/video0", 0.0), {}) {
    device.controls = {{V4L2_CID_EXPOSURE, {100, 1, 4000}}, {V4L2_CID_HBLANK, {992, 0, 2000}}};
    device.pixel_rate_hz = 100'000'000;  // 10 us a line
  }
  ~LinesHarness() { CHECK_TRUE(camera_.stop() == Status::ok); }
  bool lose_device() {
    device.present = false;
    clock_.advance(Duration{10'000'000'000});
    return see_loss();
  }
  void restore_device() {
    device.present = true;
    device.controls[V4L2_CID_EXPOSURE].value = 100;
    clock_.advance(camera_.until_next_attempt());
  }
  bool refuse_next() {
    device.control_refusals[V4L2_CID_EXPOSURE] = 1;
    return true;
  }
  Duration next_exposure() {
    clock_.advance(Duration{66'000'000});
    device.send();
    return take();
  }
  hal::Exposure in_device() { return {Duration{device.controls[V4L2_CID_EXPOSURE].value * std::int64_t{10'000}}, 1.0}; }
};

}  // namespace

RELNAV_EXPOSURE_CONTROL_CONTRACT(ScriptedExposureContract, ScriptedHarness)
RELNAV_EXPOSURE_CONTROL_CONTRACT(StreamExposureContract, DecibelHarness)
RELNAV_EXPOSURE_CONTROL_CONTRACT(UvcExposureContract, UvcHarness)
RELNAV_EXPOSURE_CONTROL_CONTRACT(LinesExposureContract, LinesHarness)
