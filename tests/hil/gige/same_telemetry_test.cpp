// A capture served by a GigE Vision camera in lock step gives the poses that its replay in process gives, to the last bit.
#include <algorithm>
#include <map>

#include "fsw/telemetry/ccsds.hpp"
#include "fsw/telemetry/packets.hpp"
#include "hil/io/euroc.hpp"
#include "hil/replay/flight_driver.hpp"
#include "hil/replay/replay_camera.hpp"
#include "platform/files/target_file.hpp"
#include "platform/host/steady_clock.hpp"
#include "platform/linux/aravis_driver.hpp"
#include "platform/linux/stream_camera.hpp"
#include "tests/hil/gige/served_camera.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;

namespace {

using Packet = std::vector<std::uint8_t>;

/// Keeps what was sent, by kind of packet.
class KeptPackets final : public hal::PacketLink {
 public:
  Status send(std::span<const std::uint8_t> packet) override {
    const unsigned apid = (packet[0] & 0x07U) << 8U | packet[1];
    kept_[apid - telemetry::default_apid_base].emplace_back(packet.begin(), packet.end());
    return Status::ok;
  }
  [[nodiscard]] std::uint32_t max_packet_bytes() const override { return telemetry::max_packet_bytes; }
  const std::vector<Packet>& of(telemetry::PacketId id) { return kept_[static_cast<unsigned>(id)]; }

 private:
  std::map<unsigned, std::vector<Packet>> kept_;
};

FlightSetup read_setup() {
  FlightSetup setup;
  setup.navigation = app::NavigationKind::coop_mono;
  setup.camera_file = RELNAV_SOURCE_DIR "/hil/captures/lights_mono/mav0/cam0/sensor.yaml";
  setup.camera = read_camera_file(setup.camera_file);
  setup.target_file = RELNAV_SOURCE_DIR "/hil/captures/lights_mono/target.yaml";
  setup.target = read_target_file(setup.target_file);
  return setup;
}

/// Read before the tests: yaml-cpp keeps memory, which CppUTest would call a leak.
const FlightSetup lights_mono_setup = read_setup();

/// Steps until `frames` have led to a REL_STATE packet.
void fly(hal::Camera& camera, std::size_t frames, KeptPackets& packets) {
  platform::host::SteadyClock clock;
  const auto loop = hil::make_flight_driver(flight_config_of(lights_mono_setup), lights_mono_setup.camera_file, clock,
                                            camera, nullptr, packets);
  CHECK_TRUE(loop->start() == Status::ok);
  constexpr int most_steps = 500;
  for (int i = 0; i < most_steps && packets.of(telemetry::PacketId::rel_state).size() < frames; ++i)
    static_cast<void>(loop->step());
}

}  // namespace

TEST_GROUP(SameTelemetry){void setup() override{enter_own_network();
}
}
;

TEST(SameTelemetry, LockStepOverGigeEqualsReplayInProcess) {
  hil::CapturedSource source(lights_mono);
  const hil::FrameShape shape = source.shape();
  platform::host::SteadyClock clock;

  KeptPackets replayed;
  hil::ReplayCamera replay(hil::read_image_list(lights_mono), shape.width_px, shape.height_px, clock, hil::Pace::max,
                           hil::Depth::as_filed);
  fly(replay, source.count(), replayed);

  hil::PlayerSettings play;
  play.speed = 0.0;
  play.loop = true;  // stays until it is finished
  ServedCamera served(source, play);
  KeptPackets received;
  {
    platform::linux::AravisDriver driver;
    platform::linux::CameraSettings settings = settings_for(shape.width_px, shape.height_px);
    settings.trigger = platform::linux::Trigger::software;
    settings.stamp_meaning = platform::linux::StampMeaning::mid_exposure;
    platform::linux::StreamOptions options;
    options.policy = platform::linux::FramePolicy::every_frame;
    CHECK_TRUE(open_soon(driver, settings) == Status::ok);  // wait for the server
    driver.close();
    platform::linux::StreamCamera camera(driver, clock, settings, options);
    fly(camera, source.count(), received);
    if (!camera.problem().empty()) std::printf("%s\n", camera.problem().c_str());
    CHECK_TRUE(camera.stop() == Status::ok);
  }

  for (const auto id : {telemetry::PacketId::rel_state, telemetry::PacketId::features, telemetry::PacketId::event}) {
    const std::vector<Packet>& expected = replayed.of(id);
    const std::vector<Packet>& got = received.of(id);
    CHECK_EQUAL(expected.size(), got.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (expected[i] == got[i]) continue;
      const auto at = std::mismatch(expected[i].begin(), expected[i].end(), got[i].begin(), got[i].end()).first;
      std::printf("packet %zu of kind %d differs from byte %zu of %zu on\n", i, static_cast<int>(id),
                  static_cast<std::size_t>(at - expected[i].begin()), expected[i].size());
      FAIL("telemetry differs");
    }
  }
  CHECK_EQUAL(source.count(), replayed.of(telemetry::PacketId::rel_state).size());
  CHECK_TRUE(!replayed.of(telemetry::PacketId::features).empty());
}
