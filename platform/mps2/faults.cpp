#include <cstdint>

#include "platform/mps2/registers.hpp"
#include "platform/mps2/safe_state.hpp"

extern "C" {
extern std::uint32_t __guard_start[], __stack_bottom[];
[[noreturn]] void fault_handler();
}

namespace relnav::platform::mps2 {
namespace {

constexpr std::uint32_t stacking_failed = (1U << 4U) | (1U << 5U);  // of the frame, of the FPU's part
constexpr std::uint32_t address_valid = 1U << 7U;

bool is_stack_overflow(std::uint32_t status, std::uint32_t address) {
  if ((status & stacking_failed) != 0) return true;
  const auto guard = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(__guard_start));
  const auto above = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(__stack_bottom));
  return (status & address_valid) != 0 && address >= guard && address < above;
}

/// Where the program was: the seventh word that the processor put on its stack.
std::uint32_t interrupted_at() {
  const std::uint32_t* frame = nullptr;
  asm volatile("mrs %0, psp" : "=r"(frame));
  return frame[6];
}

}  // namespace
}  // namespace relnav::platform::mps2

/// Every fault, and every interrupt nobody asked for. On the handlers' stack.
void fault_handler() {
  using namespace relnav::platform::mps2;
  const std::uint32_t status = FaultStatus::read();
  const bool overflow = is_stack_overflow(status, MemoryFaultAddress::read());
  // Nobody returns from here, so the program's floating-point registers need not be kept; keeping them might fault anew.
  constexpr std::uint32_t lazy_save_pending = 1U;
  FloatContext::write(FloatContext::read() & ~lazy_save_pending);
  enter_safe_state({.cause = overflow ? SafeCause::stack_overflow : SafeCause::processor_fault,
                    .where = overflow ? 0U : interrupted_at(),
                    .detail = status});
}
