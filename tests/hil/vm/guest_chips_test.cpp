// In the guest: which chip a name means. GPIO_CHIP is the device of the chip that make_lines has made; two others are called "twins".
#include <CppUTest/TestHarness.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "platform/linux/gpio_chip.hpp"
#include "platform/linux/gpiod_lines.hpp"

using relnav::Status;
using relnav::platform::linux::find_gpio_chip;

TEST_GROUP(GuestChips) {
  std::string device;
  std::string path = "unchanged";
  std::string problem;
  void setup() override {
    const char* const chip = std::getenv("GPIO_CHIP");
    CHECK_TRUE(chip != nullptr);
    device = chip;
  }
  bool says(const std::string& part) const { return problem.find(part) != std::string::npos; }
};

TEST(GuestChips, PathNameAndLabelMeanTheSame) {
  for (const std::string& name : {device, device.substr(sizeof("/dev/") - 1), std::string("relnav")}) {
    path = "unchanged";
    CHECK_TRUE(find_gpio_chip(name, path, problem) == Status::ok);
    STRCMP_EQUAL(device.c_str(), path.c_str());
  }
}

TEST(GuestChips, ALabelOfTwoChipsIsAmbiguous) {
  CHECK_TRUE(find_gpio_chip("twins", path, problem) == Status::ambiguous);
  CHECK_TRUE(says("\"twins\": /dev/gpiochip"));
  CHECK_TRUE(says("both have this label"));
  STRCMP_EQUAL("unchanged", path.c_str());
}

TEST(GuestChips, AnUnknownNameIsToldWhatThereIs) {
  CHECK_TRUE(find_gpio_chip("relnaw", path, problem) == Status::no_data);
  CHECK_TRUE(says(device.substr(sizeof("/dev/") - 1) + " (relnav)"));
  CHECK_TRUE(says("(twins)"));
}

TEST(GuestChips, WithoutPermissionItSaysSo) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (::setgid(65534) != 0 || ::setuid(65534) != 0) ::_exit(1);
    const bool by_label =
        find_gpio_chip("relnav", path, problem) == Status::io_error && says("no permission for") && says(device);
    const bool by_path = find_gpio_chip(device, path, problem) == Status::io_error &&
                         says(device + ": cannot be opened: Permission denied");
    ::_exit(by_label && by_path ? 0 : 2);
  }
  int status = -1;
  CHECK_TRUE(::waitpid(child, &status, 0) == child);
  CHECK_TRUE(WIFEXITED(status));
  LONGS_EQUAL(0, WEXITSTATUS(status));
}

TEST(GuestChips, ATakenLineNamesWhoHasIt) {
  const auto mine = relnav::platform::linux::make_gpiod_backend();
  const auto other = relnav::platform::linux::make_gpiod_backend();
  CHECK_TRUE(mine->open(device) == Status::ok);
  CHECK_TRUE(other->open(device) == Status::ok);
  CHECK_TRUE(other->request_output(0, false) == Status::ok);
  CHECK_TRUE(mine->request_output(0, false) == Status::no_capacity);
  const std::string expected =
      device + ", line 0 (STROBE): cannot be requested as output: Device or resource busy (by \"relnav\")";
  STRCMP_EQUAL(expected.c_str(), mine->problem().c_str());
}
