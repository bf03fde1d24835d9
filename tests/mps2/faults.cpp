/// Ends in the way it is told to, with the hook of a flight program: last packet into OUT, watchdog tripped.
///   test_mps2_faults CAUSE OUT
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "fsw/app/final_event.hpp"
#include "fsw/base/panic.hpp"
#include "platform/mps2/no_heap.hpp"
#include "platform/mps2/recording_watchdog.hpp"
#include "platform/mps2/safe_state.hpp"
#include "platform/mps2/semihosted_packet_link.hpp"
#include "platform/mps2/semihosting.hpp"

namespace {

using namespace relnav;
using namespace relnav::platform::mps2;

SemihostedPacketLink link;
RecordingWatchdog watchdog;

void tell_ground(const SafeStateEntry& entry) {
  static_cast<void>(watchdog.trip());
  static_cast<void>(app::send_final_event(link, {}, telemetry::EventId::safe_state_entered, Status::device_lost,
                                          {static_cast<std::int64_t>(entry.cause), entry.where, entry.detail}));
  write_console(watchdog.kick() == Status::ok ? "watchdog still takes kicks\n" : "watchdog takes no more kicks\n");
}

void tell_ground_and_fail(const SafeStateEntry& entry) {
  tell_ground(entry);
  panic(__FILE__, 1, "the hook fails itself");
}

/// A frame of half a KiB a call, with floating-point registers in use when the guard is met.
[[gnu::noinline]] double use_stack(double depth) {
  volatile double frame[64];
  frame[0] = depth;
  return depth < 1e6 ? use_stack(depth + 1.0) + frame[0] : 0.0;
}

volatile std::uint32_t zero = 0;

int fail(const char* cause) {
  const auto is = [cause](const char* name) { return std::strcmp(cause, name) == 0; };
  if (is("stack")) return static_cast<int>(use_stack(1.0));
  if (is("panic")) panic("faults.cpp", 42, "a test");
  if (is("assertion")) RELNAV_ASSERT(zero == 1U);
  if (is("null")) *reinterpret_cast<volatile std::uint32_t*>(zero) = 1U;
  if (is("instruction")) asm volatile("udf #0");
  if (is("division")) return static_cast<int>((zero + 7U) / zero);
  if (is("jump")) reinterpret_cast<void (*)()>(zero + 0xE0000001U)();
  if (is("heap")) return *static_cast<const char*>(std::malloc(8)) == '\0' ? 4 : 5;
  if (is("new")) return *new int(3);
  if (is("hook")) {
    set_safe_state_hook(tell_ground_and_fail);
    panic("faults.cpp", 43, "a test");
  }
  return 3;  // no such cause
}

}  // namespace

int main(int argc, char** argv) {
  forbid_heap();
  if (argc != 3 || link.open(argv[2]) != Status::ok) return 2;
  set_safe_state_hook(tell_ground);
  return fail(argv[1]);
}
