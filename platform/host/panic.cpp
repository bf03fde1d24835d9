#include "fsw/base/panic.hpp"

#include <cstdio>
#include <cstdlib>

namespace relnav {

/// On a host: says where and aborts, so that a debugger or core dump shows the state.
void panic(const char* file, int line, const char* what) {
  std::fprintf(stderr, "%s:%d: broken invariant: %s\n", file, line, what);
  std::abort();
}

}  // namespace relnav
