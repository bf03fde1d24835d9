#include "platform/mps2/no_heap.hpp"

#include <cstddef>

#include "fsw/base/panic.hpp"

namespace {
bool is_forbidden = false;
}

void relnav::platform::mps2::forbid_heap() { is_forbidden = true; }

/// Stands before newlib's allocator (linker option --wrap), below malloc() and new.
struct _reent;
extern "C" void* __wrap__malloc_r(struct _reent*, std::size_t);

void* __wrap__malloc_r(struct _reent*, std::size_t) {
  if (is_forbidden) relnav::panic(__FILE__, __LINE__, "memory from the heap");
  return nullptr;
}
