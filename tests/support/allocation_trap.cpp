#include "tests/support/allocation_trap.hpp"

#include <cerrno>
#include <cstdint>
#include <cstdlib>

#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__)
// Part of the sanitizer's runtime; Debian's gcc 12 comes without the header that declares it.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));
#endif

namespace relnav::test {
namespace {

// Plain thread-local data of the executable: reading it allocates nothing, and other threads are left alone.
struct Watch {
  bool armed = false;
  bool aborts = false;
  std::size_t allocations = 0;
  std::size_t releases = 0;
  std::size_t first_size = 0;
};
thread_local Watch watch;

void say_and_abort(const char* what, std::size_t length) {
  watch.armed = false;
  static_cast<void>(!write(STDERR_FILENO, what, length));
  std::abort();
}

void note_allocation(std::size_t size) {
  if (!watch.armed) return;
  if (watch.allocations++ == 0) watch.first_size = size;
  static constexpr char text[] = "allocation trap: heap memory was taken while the trap was armed\n";
  if (watch.aborts) say_and_abort(text, sizeof(text) - 1);
}

void note_release(const volatile void* pointer) {
  if (!watch.armed || pointer == nullptr) return;
  ++watch.releases;
  static constexpr char text[] = "allocation trap: heap memory was released while the trap was armed\n";
  if (watch.aborts) say_and_abort(text, sizeof(text) - 1);
}

#if defined(__SANITIZE_ADDRESS__)
void on_malloc(const volatile void*, std::size_t size) { note_allocation(size); }
void on_free(const volatile void* pointer) { note_release(pointer); }
const int hooks_installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
#endif

}  // namespace

AllocationTrap::AllocationTrap(Reaction reaction) {
  watch = Watch{};
  watch.aborts = reaction == Reaction::abort;
  watch.armed = true;
}
AllocationTrap::~AllocationTrap() { watch.armed = false; }
std::size_t AllocationTrap::allocations() const { return watch.allocations; }
std::size_t AllocationTrap::releases() const { return watch.releases; }
std::size_t AllocationTrap::first_size() const { return watch.first_size; }

}  // namespace relnav::test

#if !defined(__SANITIZE_ADDRESS__)
// The executable's own malloc family takes the place of glibc's for every library of the process. Not operator new:
// libCppUTest defines that one, on top of malloc.
using relnav::test::note_allocation;
using relnav::test::note_release;

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* pointer, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* pointer);

void* malloc(std::size_t size) {
  note_allocation(size);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  note_allocation(count * size);
  return __libc_calloc(count, size);
}
void* realloc(void* pointer, std::size_t size) {
  note_allocation(size);
  return __libc_realloc(pointer, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  note_allocation(size);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  void* const memory = memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *result = memory;
  return 0;
}
void free(void* pointer) {
  note_release(pointer);
  __libc_free(pointer);
}
}
#endif
