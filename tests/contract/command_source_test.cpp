#include <cstdint>
#include <vector>

#include "platform/host/scripted_command_source.hpp"
#include "tests/contract/command_source_contract.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::platform::host::ScriptedCommandSource;

class ScriptedCommandHarness {
 public:
  relnav::hal::CommandSource& source() { return source_; }
  void arrive(const std::vector<std::uint8_t>& packet) { CHECK_TRUE(source_.push_packet(packet) == Status::ok); }
  bool fail_next(Status status) { return source_.push_status(status) == Status::ok; }
  Time now() const { return {}; }
  Duration slack() const { return {0}; }

 private:
  ScriptedCommandSource source_;
};

}  // namespace

RELNAV_COMMAND_SOURCE_CONTRACT(ScriptedCommandSourceContract, ScriptedCommandHarness)

TEST_GROUP(ScriptedCommandSource){};

TEST(ScriptedCommandSource, ScriptIsBounded) {
  ScriptedCommandSource source(1);
  const std::vector<std::uint8_t> packet{1};
  CHECK_TRUE(source.push_packet({}) == Status::invalid_argument);
  CHECK_TRUE(source.push_status(Status::ok) == Status::invalid_argument);
  CHECK_TRUE(source.push_packet(packet) == Status::ok);
  CHECK_TRUE(source.push_packet(packet) == Status::no_capacity);
  CHECK_TRUE(source.push_status(Status::io_error) == Status::no_capacity);
  LONGS_EQUAL(1, source.script_left());
}
