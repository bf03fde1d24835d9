#include "fsw/app/final_event.hpp"

#include "platform/host/scripted_packet_link.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;

TEST_GROUP(FinalEvent) { platform::host::ScriptedPacketLink link{8}; };

TEST(FinalEvent, IsOnePacketThatDecodes) {
  const telemetry::PacketConfig packets;
  CHECK(app::send_final_event(link, packets, telemetry::EventId::safe_state_entered, Status::device_lost,
                              {4, -5, 0xFFFFFFFF, 0}) == Status::ok);
  LONGS_EQUAL(1, link.size());
  telemetry::EventPacket event;
  CHECK(telemetry::decode(link.packet(0), packets, event) == Status::ok);
  LONGS_EQUAL(static_cast<int>(telemetry::EventId::safe_state_entered), event.event_id);
  LONGS_EQUAL(static_cast<int>(Status::device_lost), event.status);
  LONGS_EQUAL(4, event.args[0]);
  LONGS_EQUAL(-5, event.args[1]);
  CHECK(event.args[2] == 0xFFFFFFFF);
}

TEST(FinalEvent, SaysWhenItCannotBeSent) {
  telemetry::PacketConfig packets;
  packets.apid_base = 0xFFFF;
  CHECK(app::send_final_event(link, packets, telemetry::EventId::safe_state_entered, Status::ok) != Status::ok);
  LONGS_EQUAL(0, link.size());
}
