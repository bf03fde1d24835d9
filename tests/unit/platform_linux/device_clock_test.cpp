// Offset between a camera's clock and ours: jitter, drift, a clock that is set anew.
#include "platform/linux/device_clock.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "fsw/base/generator.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using platform::linux::DeviceClock;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// Largest and smallest error after `settled` frames at 30 Hz; the device's clock runs `drift_ppm` too slow, arrivals come
/// `least` to `least + jitter` after the stamp, rarely at once.
struct Errors {
  std::int64_t least_ns = 0;
  std::int64_t most_ns = 0;
};
Errors errors_with(std::int64_t drift_ppm, std::int64_t least_ns, std::int64_t jitter_ns) {
  DeviceClock clock(100);
  Generator generator(7);
  Errors errors{.least_ns = 1'000'000'000, .most_ns = -1'000'000'000};
  for (std::int64_t k = 0; k < 3000; ++k) {
    const std::int64_t true_ns = 5'000'000'000 + k * 33 * ms;
    const std::int64_t device_ns = 77'000'000'000 + (k * 33 * ms) / 1'000'000 * (1'000'000 - drift_ppm);
    const std::int64_t delay_ns =
        least_ns + static_cast<std::int64_t>(generator.next() % static_cast<std::uint64_t>(jitter_ns + 1));
    const std::int64_t error_ns = clock.to_monotonic(Time{device_ns}, Time{true_ns + delay_ns}).ns - true_ns;
    if (k < 300) continue;
    errors.least_ns = std::min(errors.least_ns, error_ns);
    errors.most_ns = std::max(errors.most_ns, error_ns);
  }
  return errors;
}

}  // namespace

TEST_GROUP(DeviceClock){};

TEST(DeviceClock, JitterOfArrivalsHardlyMovesTheStamps) {
  const Errors errors = errors_with(0, 2 * ms, 5 * ms);
  CHECK_TRUE(errors.least_ns >= 2 * ms);  // the shortest delay is not told from the offset
  CHECK_TRUE(errors.most_ns <= 2 * ms + 500'000);
}

TEST(DeviceClock, FollowsDriftUpToItsBound) {
  for (const std::int64_t drift : {-90, -50, 50, 90}) {
    const Errors errors = errors_with(drift, ms, 3 * ms);
    CHECK_TRUE(errors.least_ns >= ms - 500'000);
    CHECK_TRUE(errors.most_ns <= ms + 700'000);
  }
  // Beyond it a slow clock falls behind, and nothing hides that.
  CHECK_TRUE(errors_with(1000, ms, 3 * ms).least_ns < -50 * ms);
}

TEST(DeviceClock, ALateArrivalDoesNotMoveTheOffset) {
  DeviceClock clock;
  CHECK_TRUE(clock.to_monotonic(Time{0}, Time{100 * ms}) == Time{100 * ms});
  CHECK_TRUE(clock.to_monotonic(Time{10 * ms}, Time{190 * ms}) == Time{110 * ms + 9000});  // 100 ppm of 90 ms
  CHECK_TRUE(clock.to_monotonic(Time{20 * ms}, Time{120 * ms}) == Time{120 * ms});         // an earlier one does
}

TEST(DeviceClock, StartsOverWhenTheDeviceDoes) {
  DeviceClock clock;
  CHECK_TRUE(clock.to_monotonic(Time{900 * ms}, Time{1000 * ms}) == Time{1000 * ms});
  CHECK_TRUE(clock.to_monotonic(Time{5 * ms}, Time{1100 * ms}) == Time{1100 * ms});
  clock.forget();
  CHECK_TRUE(clock.to_monotonic(Time{6 * ms}, Time{5000 * ms}) == Time{5000 * ms});
}
