// Implementations of platform/linux, all but the GPIO lines.
#include <array>
#include <chrono>
#include <cstdint>
#include <thread>
#include <utility>
#include <vector>

#include "platform/host/scripted_camera.hpp"
#include "platform/host/scripted_clock.hpp"
#include "platform/host/scripted_gpio_lines.hpp"
#include "platform/linux/monotonic_clock.hpp"
#include "platform/linux/notify_watchdog.hpp"
#include "platform/linux/serial_link.hpp"
#include "platform/linux/strobed_camera.hpp"
#include "tests/contract/camera_contract.hpp"
#include "tests/contract/clock_contract.hpp"
#include "tests/contract/packet_link_contract.hpp"
#include "tests/contract/watchdog_contract.hpp"
#include "tests/support/pseudo_terminal.hpp"
#include "tests/support/service_manager.hpp"

namespace {

using relnav::Duration;
using relnav::Status;
using relnav::Time;
using relnav::platform::host::ScriptedCamera;
using relnav::platform::host::ScriptedClock;
using relnav::platform::host::ScriptedGpioLines;
using relnav::platform::linux::SerialLink;

struct MonotonicClockHarness {
  relnav::platform::linux::MonotonicClock monotonic;
  relnav::hal::Clock& clock() { return monotonic; }
  void pass_time() { std::this_thread::sleep_for(std::chrono::microseconds(2)); }
};

class StrobedCameraHarness {
 public:
  StrobedCameraHarness() {
    for (std::size_t i = 0; i < images_.size(); ++i) images_[i].fill(static_cast<std::uint8_t>(i));
    inner_.attach_clock(clock_);
    CHECK_TRUE(lines_.request_output(2, false) == Status::ok);
  }
  relnav::hal::Camera& camera() { return camera_; }
  bool offer_frame() {
    ++sequence_;
    return inner_.push_frame(images_[sequence_ % images_.size()], 4, 4, Time{1000 * std::int64_t{sequence_}},
                             sequence_) == Status::ok;
  }
  bool offer_damaged_frame() {
    ++sequence_;
    return inner_.push_status(Status::incomplete) == Status::ok;
  }
  bool lose_device() {
    inner_.fail_starts(Status::device_lost);
    return inner_.push_status(Status::device_lost) == Status::ok;
  }
  void restore_device() {}
  Duration wait() const { return {1'000'000}; }
  Time now() const { return clock_.peek(); }
  Duration slack() const { return {0}; }

 private:
  std::array<std::array<std::uint8_t, 16>, 64> images_{};
  ScriptedClock clock_;
  ScriptedCamera inner_{3, 64};
  ScriptedGpioLines lines_{8};
  relnav::platform::linux::StrobedCamera camera_{inner_, lines_, 2};
  std::uint32_t sequence_ = 0;
};

/// A stream of bytes has no bounds: what comes out after one send() and before the next is a packet.
class SerialLinkHarness {
 public:
  SerialLinkHarness() { CHECK_TRUE(link_.open(terminal_.path(), 115200) == Status::ok); }
  relnav::hal::PacketLink& link() { return observer_; }
  void refuse_next() { refuse_ = true; }
  std::vector<std::vector<std::uint8_t>> arrived() {
    const auto more = terminal_.read(4096, 20);
    if (!more.empty()) packets_.push_back(more);
    return std::exchange(packets_, {});
  }

 private:
  class Observer final : public relnav::hal::PacketLink {
   public:
    explicit Observer(SerialLinkHarness& harness) : harness_(harness) {}
    Status send(std::span<const std::uint8_t> packet) override {
      const std::size_t filler = std::exchange(harness_.refuse_, false) ? harness_.fill() : 0;
      const Status status = harness_.link_.send(packet);
      for (const std::uint8_t byte : harness_.read(filler)) LONGS_EQUAL(0xEE, byte);
      if (status == Status::ok) harness_.packets_.push_back(harness_.read(packet.size()));
      return status;
    }
    std::uint32_t max_packet_bytes() const override { return harness_.link_.max_packet_bytes(); }

   private:
    SerialLinkHarness& harness_;
  };

  /// Until nothing goes in any more, also not a moment later.
  std::size_t fill() {
    const std::vector<std::uint8_t> filler(1000, 0xEE);
    std::size_t bytes = 0;
    for (int refusals = 0; refusals < 5;) {
      if (link_.send(filler) == Status::ok) {
        bytes += filler.size();
        refusals = 0;
      } else {
        ++refusals;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    }
    return bytes;
  }
  std::vector<std::uint8_t> read(std::size_t size) {
    std::vector<std::uint8_t> bytes;
    for (int misses = 0; bytes.size() < size && misses < 100;) {
      const Status status = link_.flush();
      CHECK_TRUE(status == Status::ok || status == Status::no_capacity);
      const auto part = terminal_.read(size - bytes.size(), 10);
      if (part.empty()) ++misses;
      bytes.insert(bytes.end(), part.begin(), part.end());
    }
    return bytes;
  }

  relnav::test::PseudoTerminal terminal_;
  SerialLink link_;
  Observer observer_{*this};
  std::vector<std::vector<std::uint8_t>> packets_;
  bool refuse_ = false;
};

/// A service manager whose time is the test's.
class NotifyWatchdogHarness {
 public:
  NotifyWatchdogHarness() { CHECK_TRUE(notifier_.open(manager_.address()) == Status::ok); }
  relnav::hal::Watchdog& watchdog() { return watchdog_; }
  Duration deadline() const { return {1'000'000'000}; }
  bool reacted() {
    for (const std::string& message : manager_.received()) {
      if (message == "WATCHDOG=1" && !reacted_) heard_ = clock_.peek();
      if (message == "WATCHDOG=trigger") reacted_ = true;
    }
    if (clock_.peek() - heard_ > deadline()) reacted_ = true;
    return reacted_;
  }
  void pass(Duration length) {
    static_cast<void>(reacted());
    clock_.advance(length);
  }

 private:
  ScriptedClock clock_;
  relnav::test::ServiceManager manager_{relnav::test::ServiceManager::abstract_address()};
  relnav::platform::linux::ServiceNotifier notifier_;
  relnav::platform::linux::NotifyWatchdog watchdog_{notifier_, clock_, deadline()};
  Time heard_;
  bool reacted_ = false;
};

}  // namespace

RELNAV_CLOCK_CONTRACT(MonotonicClockContract, MonotonicClockHarness)
RELNAV_CAMERA_CONTRACT(StrobedCameraContract, StrobedCameraHarness)
RELNAV_PACKET_LINK_CONTRACT(SerialLinkContract, SerialLinkHarness)
RELNAV_PACKET_LINK_REFUSAL_CONTRACT(SerialLinkContract)
RELNAV_WATCHDOG_CONTRACT(NotifyWatchdogContract, NotifyWatchdogHarness)
