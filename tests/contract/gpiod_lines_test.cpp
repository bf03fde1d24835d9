#include "platform/linux/gpiod_lines.hpp"

#include "platform/linux/monotonic_clock.hpp"
#include "tests/contract/gpio_lines_contract.hpp"
#include "tests/support/fake_gpio_backend.hpp"

namespace {

using relnav::Duration;
using relnav::Status;

class GpiodLinesHarness {
 public:
  GpiodLinesHarness() { CHECK_TRUE(lines_.open_path("fake") == Status::ok); }
  relnav::hal::GpioLines& lines() { return lines_; }
  std::uint32_t line_a() const { return 3; }
  std::uint32_t line_b() const { return 7; }
  std::uint32_t no_line() const { return 8; }
  bool level(std::uint32_t offset) const { return backend_.level(offset); }
  bool drive(std::uint32_t offset, bool level) {
    backend_.drive(offset, level, now());
    return true;
  }
  std::size_t unread_edges() const { return 16; }
  bool lose_device() {
    backend_.unplug();
    return true;
  }
  void restore_device() { backend_.plug(); }
  Duration wait() const { return {200'000'000}; }
  relnav::Time now() { return clock_.now(); }
  Duration slack() const { return {50'000'000}; }

 private:
  relnav::platform::linux::MonotonicClock clock_;
  relnav::test::FakeGpioBackend backend_{8};
  relnav::platform::linux::GpiodLines lines_{backend_};
};

}  // namespace

RELNAV_GPIO_LINES_CONTRACT(GpiodLinesContract, GpiodLinesHarness)
