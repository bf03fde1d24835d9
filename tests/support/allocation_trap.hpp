#pragma once
#include <cstddef>

namespace relnav::test {

/// Watches the heap use of the calling thread for as long as it lives: malloc, calloc, realloc, the aligned forms, free of
/// a non-null pointer, and everything built on them (operator new, the C and C++ libraries, CppUTest itself).
/// Link with relnav_add_allocation_trap(target) from tests/CMakeLists.txt.
///
/// A failing CHECK allocates its message: read the counters into locals, let the trap go, then check.
/// Traps do not nest. Under AddressSanitizer the sanitizer's own hooks are used; realloc counts there as what it does.
class AllocationTrap {
 public:
  enum class Reaction {
    count,  ///< carry on and count
    abort,  ///< say what happened on stderr and abort at once: a debugger or a core file then shows the caller
  };
  explicit AllocationTrap(Reaction reaction = Reaction::count);
  ~AllocationTrap();
  AllocationTrap(const AllocationTrap&) = delete;
  AllocationTrap& operator=(const AllocationTrap&) = delete;

  [[nodiscard]] std::size_t allocations() const;
  [[nodiscard]] std::size_t releases() const;
  /// Size of the first allocation, bytes; 0 when there was none.
  [[nodiscard]] std::size_t first_size() const;
};

}  // namespace relnav::test
