// The flight loop under telecommands.
#include <memory>

#include "fsw/telemetry/telecommand.hpp"
#include "tests/unit/app/loop_bench.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace {

using namespace relnav;
using app::Mode;
using telemetry::CommandStage;
using telemetry::EventId;
using telemetry::TelecommandId;
using test::LoopBench;
using test::period_ns;
using test::RenderedBox;

constexpr std::int64_t second = 1'000'000'000;
constexpr std::uint32_t pps = 2;

}  // namespace

TEST_GROUP(FlightCommands) {
  std::unique_ptr<LoopBench> owned = std::make_unique<LoopBench>(false, true);
  LoopBench& bench = *owned;
  std::uint16_t sequence = 100;

  void setup() override {
    bench.clock.set_tick({0});
    bench.clock.jump_to(Time{5 * second});
    CHECK_TRUE(bench.loop.configure(bench.config) == Status::ok);
  }
  void teardown() override { LONGS_EQUAL(0, bench.undecodable()); }

  std::vector<std::uint8_t> bytes_of(TelecommandId id, std::uint32_t argument = 0) {
    std::vector<std::uint8_t> bytes(telemetry::max_telecommand_bytes);
    const auto size = telemetry::encode_telecommand(id, argument, ++sequence, bench.config.packets, bytes);
    bytes.resize(size.value());
    return bytes;
  }
  void send(const std::vector<std::uint8_t>& bytes) { CHECK_TRUE(bench.commands.push_packet(bytes) == Status::ok); }
  const app::StepReport& command(TelecommandId id, std::uint32_t argument = 0) {
    send(bytes_of(id, argument));
    return bench.step();
  }
  std::vector<telemetry::CommandAckPacket> acks() const { return bench.packets<telemetry::CommandAckPacket>(); }
  void check_ack(std::size_t index, CommandStage stage, Status code) {
    const auto all = acks();
    CHECK_TRUE(index < all.size());
    LONGS_EQUAL(static_cast<long>(stage), all[index].stage);
    LONGS_EQUAL(static_cast<long>(code), all[index].code);
  }
  /// Of the latest command: accepted, then this.
  void check_outcome(CommandStage stage, Status code) {
    const auto all = acks();
    CHECK_TRUE(all.size() >= 2);
    check_ack(all.size() - 2, CommandStage::accepted, Status::ok);
    check_ack(all.size() - 1, stage, code);
    LONGS_EQUAL(0xC000 | sequence, all.back().request_sequence);
    LONGS_EQUAL(0x1900, all.back().request_packet_id);
  }
  void reach_track() {
    const RenderedBox target(5);
    for (std::uint32_t i = 0; i < 15 && bench.loop.mode() != Mode::track; ++i) {
      CHECK_TRUE(bench.feed(target.render(0.1 * i, i), i * period_ns, i).status == Status::ok);
    }
    CHECK_TRUE(bench.loop.mode() == Mode::track);
  }
  void pulse(std::int64_t time_ns) {
    CHECK_TRUE(bench.lines.drive(pps, true, Time{time_ns}) == Status::ok);
    CHECK_TRUE(bench.lines.drive(pps, false, Time{time_ns + 1000}) == Status::ok);
    bench.clock.jump_to(Time{time_ns + 5'000'000});
    static_cast<void>(bench.step());
  }
  void with_pulse_line() {
    bench.config.lines.pulse = pps;
    CHECK_TRUE(bench.loop.configure(bench.config) == Status::ok);
  }
};

TEST(FlightCommands, PingIsAnswered) {
  command(TelecommandId::ping);
  const auto pongs = bench.packets<telemetry::PongPacket>();
  LONGS_EQUAL(1, pongs.size());
  LONGS_EQUAL(5 * second, pongs[0].time_ns);
  LONGS_EQUAL(2, acks().size());
  check_outcome(CommandStage::done, Status::ok);
  LONGS_EQUAL(17, acks()[1].service);
  LONGS_EQUAL(1, acks()[1].subtype);
  LONGS_EQUAL(5 * second, acks()[1].time_ns);
  LONGS_EQUAL(0, bench.events(EventId::command_refused).size());
}

TEST(FlightCommands, StartAndStop) {
  command(TelecommandId::start);
  CHECK_TRUE(bench.loop.mode() == Mode::acquire);
  CHECK_TRUE(bench.camera.streaming());
  check_outcome(CommandStage::done, Status::ok);
  command(TelecommandId::start);
  check_outcome(CommandStage::failed, Status::invalid_argument);
  LONGS_EQUAL(1, bench.events(EventId::command_refused).size());
  command(TelecommandId::stop);
  CHECK_TRUE(bench.loop.mode() == Mode::standby);
  CHECK_FALSE(bench.camera.streaming());
  check_outcome(CommandStage::done, Status::ok);
  bench.camera.fail_starts(Status::io_error);
  command(TelecommandId::start);
  check_outcome(CommandStage::failed, Status::io_error);
}

TEST(FlightCommands, RestartGivesTheEstimateUpAndTheFrameStays) {
  command(TelecommandId::restart);
  check_outcome(CommandStage::failed, Status::not_configured);  // not running
  command(TelecommandId::start);
  reach_track();
  const RenderedBox target(5);
  send(bytes_of(TelecommandId::restart));
  const auto& report = bench.feed(target.render(1.5, 15), 15 * period_ns, 15);
  CHECK_TRUE(report.status == Status::ok);
  CHECK_TRUE(report.state.t_CT.norm() > 1.0);
  CHECK_TRUE(report.mode == Mode::lost);
  check_outcome(CommandStage::done, Status::ok);
  LONGS_EQUAL(1, bench.events(EventId::filter_reset).size());
  CHECK_TRUE(bench.packets<telemetry::RelStatePacket>().back().mode == static_cast<int>(Mode::track));
  CHECK_TRUE(bench.feed(target.render(1.6, 16), 16 * period_ns, 16).mode == Mode::acquire);
  LONGS_EQUAL(1, bench.packets<telemetry::RelStatePacket>().back().reset_counter);
}

TEST(FlightCommands, HealthComesAtOnceInStandbyToo) {
  command(TelecommandId::health);
  LONGS_EQUAL(1, bench.packets<telemetry::HealthPacket>().size());
  LONGS_EQUAL(0, bench.packets<telemetry::HealthPacket>()[0].mode);
  check_outcome(CommandStage::done, Status::ok);
}

TEST(FlightCommands, TheNextPulseIsNamed) {
  with_pulse_line();
  pulse(6 * second);
  pulse(7 * second);
  bench.clock.jump_to(Time{8 * second + 100'000'000});
  command(TelecommandId::set_tai, 4'000'000'009);
  // An edge from before the command was read is not the next one, though it is read only now.
  CHECK_TRUE(bench.lines.drive(pps, true, Time{8 * second}) == Status::ok);
  CHECK_TRUE(bench.lines.drive(pps, false, Time{8 * second + 1000}) == Status::ok);
  static_cast<void>(bench.step());
  LONGS_EQUAL(1, acks().size());
  pulse(9 * second);
  check_outcome(CommandStage::done, Status::ok);
  const auto times = bench.packets<telemetry::TimePacket>();
  LONGS_EQUAL(4, times.size());
  LONGS_EQUAL(0, times[2].seconds_source);
  LONGS_EQUAL(1, times[3].seconds_source);
  CHECK_TRUE(times[3].tai_ns == 4'000'000'009'000'000'000ULL);
  pulse(10 * second);
  CHECK_TRUE(bench.packets<telemetry::TimePacket>().back().tai_ns == 4'000'000'010'000'000'000ULL);
  LONGS_EQUAL(2, acks().size());
}

TEST(FlightCommands, APulseThatDoesNotComeIsNotNamed) {
  with_pulse_line();
  pulse(6 * second);
  command(TelecommandId::set_tai, 4'000'000'007);
  bench.clock.jump_to(Time{8 * second + 5'000'000});
  static_cast<void>(bench.step());
  LONGS_EQUAL(1, acks().size());
  pulse(8 * second);  // it would have been the one at 7
  check_outcome(CommandStage::failed, Status::timeout);
  LONGS_EQUAL(0, bench.packets<telemetry::TimePacket>().back().seconds_source);

  command(TelecommandId::set_tai, 4'000'000'009);
  command(TelecommandId::set_tai, 4'000'000'009);
  check_outcome(CommandStage::failed, Status::no_capacity);
  bench.clock.jump_to(Time{11 * second});
  static_cast<void>(bench.step());
  check_ack(acks().size() - 1, CommandStage::failed, Status::timeout);
  LONGS_EQUAL(sequence - 1, acks().back().request_sequence & 0x3FFF);  // of the one that waited
}

TEST(FlightCommands, WithoutAPulseLineNoSecondIsNamed) {
  command(TelecommandId::set_tai, 1);
  check_outcome(CommandStage::failed, Status::not_configured);
}

TEST(FlightCommands, DamagedOnesAreRefusedAndHarmless) {
  auto bytes = bytes_of(TelecommandId::start);
  bytes[11] ^= 1U;  // stop, with the wrong checksum
  send(bytes);
  static_cast<void>(bench.step());
  CHECK_TRUE(bench.loop.mode() == Mode::standby);
  LONGS_EQUAL(1, acks().size());
  check_ack(0, CommandStage::refused, Status::crc_mismatch);
  LONGS_EQUAL(0, acks()[0].service);
  const auto events = bench.events(EventId::command_refused);
  LONGS_EQUAL(1, events.size());
  LONGS_EQUAL(static_cast<long>(Status::crc_mismatch), events[0].status);
  LONGS_EQUAL(sequence, events[0].args[2]);
  LONGS_EQUAL(1, events[0].args[3]);
}

TEST(FlightCommands, WhatIsNotForUsIsNotAnswered) {
  bench.config.packets.apid_base = 0x200;
  send(bytes_of(TelecommandId::start));
  bench.config.packets.apid_base = telemetry::default_apid_base;
  send({1, 2, 3});
  static_cast<void>(bench.step());
  LONGS_EQUAL(0, acks().size());
  CHECK_TRUE(bench.loop.mode() == Mode::standby);
  const auto events = bench.events(EventId::command_refused);
  LONGS_EQUAL(1, events.size());  // of the three bytes
  LONGS_EQUAL(static_cast<long>(Status::incomplete), events[0].status);
  LONGS_EQUAL(2, events[0].args[3]);  // both are counted
}

TEST(FlightCommands, FaultsOfTheSourceDoNotStopTheLoop) {
  CHECK_TRUE(bench.commands.push_status(Status::io_error) == Status::ok);
  send(std::vector<std::uint8_t>(300));  // longer than any
  send(bytes_of(TelecommandId::ping));
  static_cast<void>(bench.step());
  LONGS_EQUAL(1, bench.packets<telemetry::PongPacket>().size());
  LONGS_EQUAL(static_cast<long>(Status::io_error), bench.events(EventId::command_refused).at(0).status);
}

TEST(FlightCommands, AtMostFourAreServedInAStep) {
  for (int i = 0; i < 10; ++i) send(bytes_of(TelecommandId::ping));
  for (const std::size_t served : {4U, 8U, 10U, 10U}) {
    static_cast<void>(bench.step());
    LONGS_EQUAL(served, bench.packets<telemetry::PongPacket>().size());
  }
}
