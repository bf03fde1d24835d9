/// From reset to main(): memory, FPU, guards, the program's own stack. Compiled without floating-point registers: up to the
/// check nobody knows whether there are any.
#include <cstddef>
#include <cstdint>

#include "platform/mps2/registers.hpp"
#include "platform/mps2/safe_state.hpp"
#include "platform/mps2/semihosting.hpp"
#include "platform/mps2/stack.hpp"

// The linker script's.
extern "C" {
extern std::uint32_t __data_load[], __data_start[], __data_end[], __bss_start[], __bss_end[];
extern std::uint32_t __stack_bottom[], __stack_top[], __guard_start[], __guard_size[], __handler_stack_top[];
extern void (*const __preinit_array_start[])();
extern void (*const __preinit_array_end[])();
extern void (*const __init_array_start[])();
extern void (*const __init_array_end[])();

int program(int argc, const char** argv) asm("main");
[[noreturn]] void exit(int status);
[[noreturn]] void reset_handler();
[[noreturn]] void start_program();
[[noreturn]] void fault_handler();
void systick_handler();
[[gnu::weak]] void systick_handler() { fault_handler(); }

// What the C library wants around static objects, which here are never destroyed.
void* __dso_handle = nullptr;
void _init() {}
void _fini() {}
}

namespace relnav::platform::mps2 {
namespace {

struct VectorTable {
  std::uint32_t* stack;
  void (*handlers[15])();
};

[[gnu::section(".vectors"), gnu::used]] const VectorTable vector_table{
    __handler_stack_top,
    {reset_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, nullptr, nullptr,
     nullptr, nullptr, fault_handler, fault_handler, nullptr, fault_handler, systick_handler}};

void fill(std::uint32_t* begin, const std::uint32_t* end, std::uint32_t value) {
  while (begin != end) *begin++ = value;
}

void prepare_memory() {
  const std::uint32_t* from = __data_load;
  for (std::uint32_t* to = __data_start; to != __data_end; ++to) *to = *from++;
  fill(__bss_start, __bss_end, 0);
  fill(__stack_bottom, __stack_top, stack_paint);
}

void call_all(void (*const* begin)(), void (*const* end)()) {
  for (; begin != end; ++begin) (*begin)();
}

/// The image's own kind of FPU is there, and switched on.
bool switch_fpu_on() {
#ifdef __ARM_FP
  constexpr std::uint32_t full_access = 0xFU << 20U;
  constexpr std::uint32_t double_precision = 0x2U << 8U;
  CoprocessorAccess::set(full_access);
  synchronise();
  return (CoprocessorAccess::read() & full_access) == full_access &&
         (FloatFeatures::read() & 0xF00U) == double_precision;
#else
  return true;
#endif
}

std::uint32_t address_of(const std::uint32_t* symbol) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(symbol));
}

void protect(std::uint32_t region, std::uint32_t base, std::uint32_t log2_bytes, std::uint32_t access) {
  MpuNumber::write(region);
  MpuBase::write(base);
  MpuAttributes::write(access | ((log2_bytes - 1U) << 1U) | 1U);
}

/// The guard under the stack, and code that cannot be written: a null pointer ends at once.
void set_guards() {
  constexpr std::uint32_t no_access = 1U << 28U;  // nor execution
  constexpr std::uint32_t read_only = 6U << 24U;
  constexpr std::uint32_t cached = 1U << 17U;
  if (MpuType::read() == 0) return;
  protect(0, 0, 22, read_only | cached);
  protect(1, address_of(__guard_start), 12, no_access);
  MpuControl::write(5);  // on; elsewhere the default map
  synchronise();
}

void switch_faults_on() {
  constexpr std::uint32_t memory_bus_usage = 7U << 16U;
  constexpr std::uint32_t trap_division_by_zero = 1U << 4U;
  HandlerControl::set(memory_bus_usage);
  Configuration::set(trap_division_by_zero);
}

}  // namespace
}  // namespace relnav::platform::mps2

void reset_handler() {
  using namespace relnav::platform::mps2;
  prepare_memory();
  if (!switch_fpu_on()) enter_safe_state({.cause = SafeCause::no_fpu});
  set_guards();
  switch_faults_on();
  // The program has a stack of its own: when that is full there still is one for the handlers.
  asm volatile(
      "msr psp, %0\n"
      "movs r0, #2\n"
      "msr control, r0\n"
      "isb\n"
      "b start_program" ::"r"(__stack_top)
      : "r0", "memory");
  __builtin_unreachable();
}

void start_program() {
  using namespace relnav::platform::mps2;
  call_all(__preinit_array_start, __preinit_array_end);
  call_all(__init_array_start, __init_array_end);
  constexpr std::size_t most_words = 16;
  static char line[1024];
  static const char* words[most_words + 1];
  exit(program(static_cast<int>(read_command_line(line, {words, most_words})), words));
}
