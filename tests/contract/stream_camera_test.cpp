// StreamCamera keeps the contract of hal::Camera, whatever its driver can do.
#include "platform/linux/stream_camera.hpp"

#include "tests/contract/camera_contract.hpp"
#include "tests/support/scripted_driver.hpp"

namespace {

using namespace relnav;
using namespace relnav::platform::linux;

template <RawFormat format, FramePolicy policy, std::uint32_t loans, bool counts>
class Harness {
 public:
  Harness() {
    driver_.format = format;
    driver_.loans_allowed = loans;
    driver_.counts = counts;
    driver_.padding_bytes = 4;
  }
  hal::Camera& camera() { return camera_; }
  bool offer_frame() {
    clock_.advance(Duration{1000});
    driver_.offer_good();
    return true;
  }
  bool offer_damaged_frame() {
    driver_.offer_damaged();
    return true;
  }
  bool lose_device() {
    driver_.present = false;
    return true;
  }
  void restore_device() {
    driver_.present = true;
    clock_.advance(camera_.until_next_attempt());
  }
  Duration wait() const { return {1'000'000}; }
  Time now() const { return clock_.peek(); }
  Duration slack() const { return {0}; }

 private:
  static CameraSettings settings() {
    CameraSettings settings;
    settings.device = "scripted";
    settings.width_px = 6;
    settings.height_px = 4;
    return settings;
  }
  static StreamOptions options() {
    StreamOptions options;
    options.policy = policy;
    return options;
  }
  platform::host::ScriptedClock clock_{Time{1'000'000'000}};
  test::ScriptedDriver driver_{clock_};
  StreamCamera camera_{driver_, clock_, settings(), options()};
};

using Lending = Harness<RawFormat::y10, FramePolicy::newest, 6, true>;
using LendingAll = Harness<RawFormat::grey8, FramePolicy::every_frame, 6, true>;
using LendingFew = Harness<RawFormat::grey8, FramePolicy::newest, 2, false>;
using Converting = Harness<RawFormat::bayer_gbrg8, FramePolicy::every_frame, 1, false>;

}  // namespace

RELNAV_CAMERA_CONTRACT(StreamCameraLending, Lending)
RELNAV_CAMERA_CONTRACT(StreamCameraLendingAll, LendingAll)
RELNAV_CAMERA_CONTRACT(StreamCameraLendingFew, LendingFew)
RELNAV_CAMERA_CONTRACT(StreamCameraConverting, Converting)
