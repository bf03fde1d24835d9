#pragma once

namespace relnav {

/// Called on a broken internal invariant (a bug of ours, never hardware or input). Does not return.
/// The core only declares it: each platform links its own (log and abort on a host, safe mode on a target).
[[noreturn]] void panic(const char* file, int line, const char* what);

}  // namespace relnav

/// Internal invariant. Always on: its cost is one predictable branch.
#define RELNAV_ASSERT(condition) ((condition) ? static_cast<void>(0) : ::relnav::panic(__FILE__, __LINE__, #condition))
