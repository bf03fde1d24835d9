#include "platform/linux/service_notifier.hpp"

#include <CppUTest/TestHarness.h>
#include <unistd.h>

#include "platform/host/scripted_clock.hpp"
#include "platform/linux/notify_watchdog.hpp"
#include "tests/support/service_manager.hpp"

namespace {

using relnav::Status;
using relnav::platform::linux::NotifyWatchdog;
using relnav::platform::linux::ServiceNotifier;
using relnav::test::ServiceManager;
using Messages = std::vector<std::string>;

}  // namespace

TEST_GROUP(ServiceNotifier) { ServiceNotifier notifier; };

TEST(ServiceNotifier, SpeaksTheProtocolToPathsAndAbstractNames) {
  for (const std::string& address : {ServiceManager::path_address(), ServiceManager::abstract_address()}) {
    ServiceManager manager(address);
    CHECK_TRUE(notifier.open(manager.address()) == Status::ok);
    CHECK_TRUE(notifier.has_manager());
    CHECK_TRUE(notifier.ready() == Status::ok);
    CHECK_TRUE(notifier.status("waiting for /dev/video0\nREADY=1") == Status::ok);
    CHECK_TRUE(notifier.watchdog() == Status::ok);
    CHECK_TRUE(notifier.trigger_watchdog() == Status::ok);
    CHECK_TRUE(notifier.stopping() == Status::ok);
    CHECK_TRUE(manager.received() == Messages({"READY=1", "STATUS=waiting for /dev/video0 READY=1", "WATCHDOG=1",
                                               "WATCHDOG=trigger", "STOPPING=1"}));
  }
}

TEST(ServiceNotifier, StatusIsCut) {
  ServiceManager manager(ServiceManager::abstract_address());
  CHECK_TRUE(notifier.open(manager.address()) == Status::ok);
  CHECK_TRUE(notifier.status(std::string(5000, 'x')) == Status::ok);
  CHECK_TRUE(manager.received() == Messages({"STATUS=" + std::string(200, 'x')}));
}

TEST(ServiceNotifier, WithoutAManagerNothingHappens) {
  CHECK_TRUE(notifier.ready() == Status::ok);
  CHECK_TRUE(notifier.open(nullptr) == Status::ok);
  CHECK_TRUE(notifier.open("") == Status::ok);
  CHECK_FALSE(notifier.has_manager());
  CHECK_TRUE(notifier.watchdog() == Status::ok);
}

TEST(ServiceNotifier, AddressesThatAreNoneSaySo) {
  CHECK_TRUE(notifier.open("run/notify") == Status::invalid_argument);
  CHECK_TRUE(notifier.problem().find("NOTIFY_SOCKET=run/notify: expected a path") == 0);
  CHECK_TRUE(notifier.open(("/" + std::string(107, 'x')).c_str()) == Status::invalid_argument);
  CHECK_TRUE(notifier.open(("/" + std::string(106, 'x')).c_str()) == Status::ok);
}

TEST(ServiceNotifier, AManagerThatIsGoneOrDoesNotReadIsNoHang) {
  {
    ServiceManager manager(ServiceManager::abstract_address());
    CHECK_TRUE(notifier.open(manager.address()) == Status::ok);
    Status status = Status::ok;
    for (int i = 0; i < 10000 && status == Status::ok; ++i) status = notifier.watchdog();
    CHECK_TRUE(status == Status::no_capacity);
  }
  CHECK_TRUE(notifier.watchdog() == Status::device_lost);
}

TEST(ServiceNotifier, WatchdogIntervalIsForThisProcessOnly) {
  const std::string self = std::to_string(::getpid());
  LONGS_EQUAL(2'000'000'000, ServiceNotifier::watchdog_interval("2000000", self.c_str()).ns);
  LONGS_EQUAL(2'000'000'000, ServiceNotifier::watchdog_interval("2000000", nullptr).ns);
  LONGS_EQUAL(0, ServiceNotifier::watchdog_interval("2000000", "1").ns);
  LONGS_EQUAL(0, ServiceNotifier::watchdog_interval(nullptr, self.c_str()).ns);
  for (const char* bad : {"", "0", "-5", "2s", "99999999999999999999", "9223372036854775807"})
    LONGS_EQUAL(0, ServiceNotifier::watchdog_interval(bad, nullptr).ns);
}

TEST_GROUP(NotifyWatchdog) {
  ServiceManager manager{ServiceManager::abstract_address()};
  ServiceNotifier notifier;
  relnav::platform::host::ScriptedClock clock{relnav::Time{5'000}};
  void setup() override { CHECK_TRUE(notifier.open(manager.address()) == Status::ok); }
};

TEST(NotifyWatchdog, TellsTheManagerAtMostEveryQuarter) {
  NotifyWatchdog watchdog(notifier, clock, {1000});
  for (int i = 0; i < 100; ++i) {
    CHECK_TRUE(watchdog.kick() == Status::ok);
    clock.advance({10});
  }
  LONGS_EQUAL(4, manager.received().size());  // at 0, 250, 500, 750
}

TEST(NotifyWatchdog, AKickThatTheManagerDidNotTakeIsSentAgain) {
  NotifyWatchdog watchdog(notifier, clock, {1000});
  while (notifier.status("full") == Status::ok) continue;
  CHECK_TRUE(watchdog.kick() == Status::no_capacity);
  static_cast<void>(manager.received());
  clock.advance({1});
  CHECK_TRUE(watchdog.kick() == Status::ok);
  CHECK_TRUE(manager.received() == Messages({"WATCHDOG=1"}));
}

TEST(NotifyWatchdog, ATripThatTheManagerDidNotTakeIsSentAgain) {
  NotifyWatchdog watchdog(notifier, clock, {1000});
  while (notifier.status("full") == Status::ok) continue;
  CHECK_TRUE(watchdog.trip() == Status::ok);
  static_cast<void>(manager.received());
  CHECK_TRUE(watchdog.kick() == Status::device_lost);
  CHECK_TRUE(watchdog.kick() == Status::device_lost);
  CHECK_TRUE(manager.received() == Messages({"WATCHDOG=trigger"}));
}

TEST(NotifyWatchdog, WithoutAnIntervalThereIsNoDeadline) {
  NotifyWatchdog watchdog(notifier, clock, {0});
  clock.advance({1'000'000'000'000});
  CHECK_TRUE(watchdog.kick() == Status::ok);
  LONGS_EQUAL(0, manager.received().size());
  CHECK_TRUE(watchdog.trip() == Status::ok);
  CHECK_TRUE(watchdog.kick() == Status::device_lost);
}
