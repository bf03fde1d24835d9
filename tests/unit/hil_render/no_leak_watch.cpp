// Embree, Assimp and our own patterns keep some things for good, which CppUTest takes for leaks of whatever test came first;
// LeakSanitizer tells the two apart (sanitizer build).
#include <CppUTest/TestHarness.h>

#include <CppUTest/MemoryLeakWarningPlugin.h>

namespace {

[[maybe_unused]] const bool is_off = [] {
  MemoryLeakWarningPlugin::turnOffNewDeleteOverloads();
  return true;
}();

}  // namespace
