/// Linked into flight images, where nobody may ask for heap memory: whoever does ends in the safe state.
#include <cstddef>

#include "fsw/base/panic.hpp"

struct _reent;
extern "C" void* __wrap__malloc_r(struct _reent*, std::size_t);

void* __wrap__malloc_r(struct _reent*, std::size_t) { relnav::panic(__FILE__, __LINE__, "memory from the heap"); }
