#include <nlohmann/json.hpp>
#include <vector>

#include "hil/replay/telemetry_link.hpp"
#include "hil/telemetry/packet_text.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

namespace {

template <typename Packet>
std::vector<std::uint8_t> encoded(const Packet& packet) {
  telemetry::PacketContext context;
  if (context.configure({}) != Status::ok) return {};
  std::vector<std::uint8_t> bytes(telemetry::max_packet_bytes);
  const auto size = telemetry::encode(packet, context, bytes);
  bytes.resize(size.value());
  return bytes;
}

telemetry::EventPacket size_event() {
  telemetry::EventPacket event;
  event.event_id = static_cast<std::uint16_t>(telemetry::EventId::frame_refused_size);
  event.occurrence = 2;
  event.status = static_cast<std::uint8_t>(Status::invalid_argument);
  event.time_ns = 100'500'000'000;
  event.frame_sequence = 5;
  event.args = {320, 240, 640, 480};
  return event;
}

}  // namespace

TEST_GROUP(PacketText){};

TEST(PacketText, StateIsReadable) {
  telemetry::RelStatePacket state;
  state.time_ns = 100'000'000'001;
  state.mode = 2;
  state.valid_flags = telemetry::valid::pose | telemetry::valid::rate;
  state.t_CT = {0.5, -0.25, 8.0};
  const std::string text = packet_text(encoded(state), {});
  for (const char* piece : {"REL_STATE", "time_ns=100000000001", "mode=TRACK", "valid_flags=pose|rate",
                            "t_CT=0.5,-0.25,8", "q_CT=0,0,0,1"}) {
    CHECK_MESSAGE_HOLDS(text, piece);
  }
  const auto json = nlohmann::json::parse(packet_json(encoded(state), {}));
  CHECK(json["packet"] == "REL_STATE");
  CHECK(json["time_ns"] == 100000000001);
  CHECK(json["t_CT"][1] == -0.25);
  CHECK_EQUAL(21U, json["pose_covariance"].size());
  CHECK(json["valid_flags"] == nlohmann::json({"pose", "rate"}));
}

TEST(PacketText, FlagsAreNamed) {
  telemetry::RelStatePacket state;
  state.valid_flags = telemetry::valid::pose | telemetry::valid::predicted;
  CHECK_MESSAGE_HOLDS(packet_text(encoded(state), {}), "valid_flags=pose|predicted ");
  telemetry::HealthPacket health;
  health.flags = telemetry::health::camera_streaming | telemetry::health::second_camera_streaming;
  CHECK_MESSAGE_HOLDS(packet_text(encoded(health), {}), "flags=camera_streaming|second_camera_streaming ");
}

TEST(PacketText, TimeAndAnswersToCommandsAreReadable) {
  telemetry::TimePacket time;
  time.tai_ns = 2'078'691'237'000'000'000;
  time.drift_ppb = -20'000;
  time.sync = static_cast<std::uint8_t>(telemetry::SyncStatus::locked);
  time.seconds_source = static_cast<std::uint8_t>(telemetry::SecondsSource::command);
  const std::string text = packet_text(encoded(time), {});
  for (const char* piece : {"TIME ", "apid=0x104", "tai_ns=2078691237000000000", "drift_ppb=-20000", "sync=locked",
                            "seconds_source=command"}) {
    CHECK_MESSAGE_HOLDS(text, piece);
  }
  telemetry::CommandAckPacket ack;
  ack.stage = static_cast<std::uint8_t>(telemetry::CommandStage::refused);
  ack.code = static_cast<std::uint8_t>(Status::crc_mismatch);
  ack.service = 17;
  CHECK_MESSAGE_HOLDS(packet_text(encoded(ack), {}), "stage=refused code=crc_mismatch service=17");
  CHECK(nlohmann::json::parse(packet_json(encoded(ack), {}))["stage"] == "refused");
  CHECK_MESSAGE_HOLDS(packet_text(encoded(telemetry::PongPacket{}), {}), "PONG ");
}

TEST(PacketText, FeaturesKeepTheirEntries) {
  telemetry::FeaturesPacket features;
  features.features_total = 2;
  CHECK(features.entries.push_back({3, 1, 256, -512, 0.5F, 3}) == Status::ok);
  CHECK(features.entries.push_back({4, 7, 0, 0, 0.0F, 1}) == Status::ok);
  CHECK_MESSAGE_HOLDS(
      packet_text(encoded(features), {}),
      "[0] slot=3 generation=1 u_px_256=256 v_px_256=-512 residual_px=0.5 use=low_innovation [1] slot=4");
  const auto json = nlohmann::json::parse(packet_json(encoded(features), {}));
  CHECK_EQUAL(2U, json["entries"].size());
  CHECK(json["entries"][1]["use"] == "not_found");
}

TEST(PacketText, EventArgumentsAreNamed) {
  const auto bytes = encoded(size_event());
  CHECK_MESSAGE_HOLDS(packet_text(bytes, {}),
                      "width_px=320 height_px=240 expected_width_px=640 expected_height_px=480");
  CHECK(nlohmann::json::parse(packet_json(bytes, {}))["args"]["expected_height_px"] == 480);
  const std::string line = event_log_line(bytes, {});
  for (const char* piece :
       {"100.500000000 frame 5 MEDIUM frame_refused_size status=invalid_argument width_px=320", "occurrence=2"}) {
    CHECK_MESSAGE_HOLDS(line, piece);
  }
  STRCMP_EQUAL("", event_log_line(encoded(telemetry::HealthPacket{}), {}).c_str());
}

TEST(PacketText, DamageIsSaid) {
  auto bytes = encoded(size_event());
  bytes[30] = static_cast<std::uint8_t>(bytes[30] ^ 1U);
  CHECK_MESSAGE_HOLDS(packet_text(bytes, {}), "unreadable packet of");
  CHECK_MESSAGE_HOLDS(packet_text(bytes, {}), "crc_mismatch");
  CHECK(nlohmann::json::parse(packet_json(bytes, {}))["error"] == "crc_mismatch");
  STRCMP_EQUAL("", event_log_line(bytes, {}).c_str());
}

TEST_GROUP(TelemetryOut) { Scratch scratch; };

TEST(TelemetryOut, PacketsGoToFileAndListener) {
  std::size_t heard = 0;
  const std::vector<std::uint8_t> packet{1, 2, 3};
  {
    TelemetryLink link;
    CHECK(link.send(packet) == Status::ok);  // before there is a file
    link.open(scratch.path("t.bin"), [&](std::span<const std::uint8_t> bytes) { heard += bytes.size(); });
    CHECK(link.send(packet) == Status::ok);
    CHECK(link.send({}) == Status::invalid_argument);
    STRCMP_EQUAL("", link.problem().c_str());
  }
  CHECK_EQUAL(6U, heard);
  CHECK_EQUAL(6U, std::filesystem::file_size(scratch.path("t.bin")));
}

TEST(TelemetryOut, FullDiskIsNamed) {
  TelemetryLink link;
  link.open("/dev/full", {});
  const std::vector<std::uint8_t> packet{1, 2, 3};
  CHECK(link.send(packet) != Status::ok);
  CHECK_MESSAGE_HOLDS(link.problem(), "/dev/full: cannot be written");
}

TEST(TelemetryOut, UdpAddressesAreReadOrRefused) {
  CHECK_EQUAL(5000, parse_udp_url("udp://127.0.0.1:5000").port);
  STRCMP_EQUAL("localhost", parse_udp_url("udp://localhost:1").host.c_str());
  STRCMP_EQUAL("::1", parse_udp_url("udp://[::1]:65535").host.c_str());
  for (const char* url : {"udp://h", "udp://:5", "tcp://h:5", "udp://h:0", "udp://h:65536", "udp://h:x", "h:5", ""}) {
    CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(parse_udp_url(url)); }), "expected udp://HOST:PORT");
  }
}
