#pragma once
#include <cstdint>

namespace relnav::platform::mps2 {

/// Why the program gave up. The numbers are part of the exit status.
enum class SafeCause : std::uint8_t {
  no_fpu = 1,            ///< none, or not the double-precision one that the image is built for
  stack_overflow = 2,    ///< the guard under the stack was touched
  processor_fault = 3,   ///< any other fault, or an interrupt that nobody asked for
  broken_invariant = 4,  ///< panic(): a bug of ours
};

[[nodiscard]] const char* to_string(SafeCause cause);

struct SafeStateEntry {
  SafeCause cause = SafeCause::processor_fault;
  std::uint32_t where = 0;   ///< address of the code, 0: not known; broken_invariant: the line
  std::uint32_t detail = 0;  ///< of a fault: the configurable fault status register
  const char* file = "";     ///< broken_invariant
  const char* what = "";     ///< broken_invariant
};

/// Called once on the way into the safe state, to tell the ground. May run in a handler on its small stack.
using SafeStateHook = void (*)(const SafeStateEntry&);
void set_safe_state_hook(SafeStateHook hook);

inline constexpr int safe_state_exit = 100;  ///< exit status: this plus the cause

/// Interrupts off, a line on the console, the hook, and the end: on this board an exit status, on a flight board the place
/// where the processor waits, without kicking, for the watchdog.
[[noreturn]] void enter_safe_state(const SafeStateEntry& entry);

}  // namespace relnav::platform::mps2
