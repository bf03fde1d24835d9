#include "platform/mps2/safe_state.hpp"

#include "fsw/base/panic.hpp"
#include "platform/mps2/semihosting.hpp"

namespace relnav::platform::mps2 {
namespace {

SafeStateHook safe_state_hook = nullptr;
bool in_safe_state = false;

void describe(const SafeStateEntry& entry) {
  write_console("safe state: ");
  write_console(to_string(entry.cause));
  if (entry.cause == SafeCause::broken_invariant) {
    write_console(": ");
    write_console(entry.file);
    write_console(":");
    write_console(entry.where);
    write_console(": ");
    write_console(entry.what);
  } else if (entry.where != 0) {
    write_console(" at address ");
    write_console(entry.where);
    write_console(", fault status ");
    write_console(entry.detail);
  }
  write_console("\n");
}

}  // namespace

const char* to_string(SafeCause cause) {
  switch (cause) {
    case SafeCause::no_fpu: return "no double-precision FPU";
    case SafeCause::stack_overflow: return "stack overflow";
    case SafeCause::processor_fault: return "processor fault";
    case SafeCause::broken_invariant: return "broken invariant";
  }
  return "unknown";
}

void set_safe_state_hook(SafeStateHook hook) { safe_state_hook = hook; }

void enter_safe_state(const SafeStateEntry& entry) {
  asm volatile("cpsid i" ::: "memory");
  if (!in_safe_state) {  // else: the hook itself failed
    in_safe_state = true;
    describe(entry);
    if (safe_state_hook != nullptr) safe_state_hook(entry);
  }
  exit_to_host(safe_state_exit + static_cast<int>(entry.cause));
}

}  // namespace relnav::platform::mps2

void relnav::panic(const char* file, int line, const char* what) {
  using namespace platform::mps2;
  enter_safe_state({SafeCause::broken_invariant, static_cast<std::uint32_t>(line), 0, file, what});
}
