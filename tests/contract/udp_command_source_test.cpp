#include "platform/posix/udp_command_source.hpp"

#include <chrono>
#include <thread>

#include "platform/host/steady_clock.hpp"
#include "platform/posix/udp_packet_link.hpp"
#include "tests/contract/command_source_contract.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::platform::posix::UdpCommandSource;
using relnav::platform::posix::UdpPacketLink;

class UdpCommandHarness {
 public:
  UdpCommandHarness() {
    CHECK_TRUE(source_.open("127.0.0.1", 0) == Status::ok);
    CHECK_TRUE(sender_.open("127.0.0.1", source_.port()) == Status::ok);
  }
  relnav::hal::CommandSource& source() { return source_; }
  /// On the loopback interface a datagram is there when sendto() returns.
  void arrive(const std::vector<std::uint8_t>& packet) { CHECK_TRUE(sender_.send(packet) == Status::ok); }
  bool fail_next(Status) { return false; }
  relnav::Time now() { return clock_.now(); }
  Duration slack() const { return {50'000'000}; }

 private:
  relnav::platform::host::SteadyClock clock_;
  UdpCommandSource source_;
  UdpPacketLink sender_;
};

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

}  // namespace

RELNAV_COMMAND_SOURCE_CONTRACT(UdpCommandSourceContract, UdpCommandHarness)

TEST_GROUP(UdpCommandSource) {
  UdpCommandSource source;
  std::array<std::uint8_t, 64> buffer{};
  std::size_t bytes = 0;
};

TEST(UdpCommandSource, NotConfiguredBeforeOpenAndAfterClose) {
  CHECK_TRUE(source.receive(buffer, bytes) == Status::not_configured);
  CHECK_TRUE(source.open("127.0.0.1", 0) == Status::ok);
  CHECK_TRUE(source.port() > 0);
  CHECK_TRUE(source.receive(buffer, bytes) == Status::no_data);
  source.close();
  CHECK_TRUE(source.receive(buffer, bytes) == Status::not_configured);
}

TEST(UdpCommandSource, APortInUseSaysSo) {
  CHECK_TRUE(source.open("127.0.0.1", 0) == Status::ok);
  UdpCommandSource second;
  CHECK_TRUE(second.open("127.0.0.1", source.port()) == Status::no_capacity);
  CHECK_TRUE(contains(second.problem(),
                      ("udp://127.0.0.1:" + std::to_string(source.port()) + ": the port is in use").c_str()));
  CHECK_TRUE(second.receive(buffer, bytes) == Status::not_configured);
}

TEST(UdpCommandSource, AddressesThatAreNoneSaySo) {
  CHECK_TRUE(source.open("256.1.1.1.1", 10025) == Status::invalid_argument);
  CHECK_TRUE(contains(source.problem(), "udp://256.1.1.1.1:10025: does not resolve"));
  CHECK_TRUE(source.open("192.0.2.1", 10025) == Status::unsupported);
  CHECK_TRUE(contains(source.problem(), "no address of this machine"));
}
