#include "platform/linux/serial_link.hpp"

#include <CppUTest/TestHarness.h>
#include <termios.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "platform/linux/monotonic_clock.hpp"
#include "tests/support/pseudo_terminal.hpp"

namespace {

using relnav::Status;
using relnav::platform::linux::SerialLink;
using relnav::test::PseudoTerminal;

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// Length in two bytes, number in two, and bytes that follow from them: 0x0A, 0x0D, 0x11, 0x13, 0x7F and the others too.
std::vector<std::uint8_t> numbered(std::size_t size, unsigned number) {
  std::vector<std::uint8_t> packet(size);
  for (std::size_t i = 0; i < size; ++i) packet[i] = static_cast<std::uint8_t>((i + number) & 0xFFU);
  packet[0] = static_cast<std::uint8_t>(size >> 8U);
  packet[1] = static_cast<std::uint8_t>(size & 0xFFU);
  packet[2] = static_cast<std::uint8_t>(number >> 8U);
  packet[3] = static_cast<std::uint8_t>(number & 0xFFU);
  return packet;
}

}  // namespace

TEST_GROUP(SerialLink) {
  PseudoTerminal terminal;
  SerialLink link;
  std::vector<std::uint8_t> packet{1, 2, 3};
};

TEST(SerialLink, NotConfiguredBeforeOpenAndAfterClose) {
  CHECK_TRUE(link.send(packet) == Status::not_configured);
  CHECK_TRUE(link.flush() == Status::not_configured);
  CHECK_TRUE(link.open(terminal.path(), 9600) == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::ok);
  link.close();
  CHECK_TRUE(link.send(packet) == Status::not_configured);
}

TEST(SerialLink, WhatIsNoSerialLineSaysSo) {
  CHECK_TRUE(link.open("/dev/null", 115200) == Status::unsupported);
  STRCMP_EQUAL("/dev/null: is not a serial line", link.problem().c_str());
  CHECK_TRUE(link.open("/dev/nothing", 115200) == Status::no_data);
  CHECK_TRUE(contains(link.problem(), "/dev/nothing: cannot be opened: No such file"));
  CHECK_TRUE(link.open(terminal.path(), 115201) == Status::invalid_argument);
  CHECK_TRUE(contains(link.problem(), "115201 baud is no standard rate"));
  CHECK_TRUE(link.send(packet) == Status::not_configured);
}

TEST(SerialLink, SetsTheRate) {
  CHECK_TRUE(link.open(terminal.path(), 57600) == Status::ok);
  const int file = ::open(terminal.path().c_str(), O_RDWR | O_NOCTTY);  // root may, in spite of the lock
  if (file < 0) return;
  termios settings{};
  CHECK_TRUE(::tcgetattr(file, &settings) == 0);
  ::close(file);
  CHECK_TRUE(::cfgetospeed(&settings) == B57600);
  CHECK_TRUE(::cfgetispeed(&settings) == B57600);
}

TEST(SerialLink, HangUpIsALostDeviceAndTheLineCanBeOpenedAnew) {
  CHECK_TRUE(link.open(terminal.path(), 115200) == Status::ok);
  terminal.hang_up();
  for (int i = 0; i < 3; ++i) CHECK_TRUE(link.send(packet) == Status::device_lost);
  PseudoTerminal other;
  CHECK_TRUE(link.open(other.path(), 115200) == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::ok);
  CHECK_TRUE(other.read(100, 1000) == packet);
}

/// Packets come faster than the reader takes them. Those that were taken arrive whole, in order; of the others nothing does.
TEST(SerialLink, SlowReaderGetsWholePacketsOrNone) {
  CHECK_TRUE(link.open(terminal.path(), 115200) == Status::ok);
  std::atomic<bool> sending{true};
  std::vector<std::uint8_t> stream;
  std::thread reader([&] {
    for (int misses = 0; misses < 20;) {
      const auto part = terminal.read(333, 10);
      stream.insert(stream.end(), part.begin(), part.end());
      if (part.empty() && !sending) ++misses;
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  });
  std::vector<std::vector<std::uint8_t>> taken;
  unsigned refused = 0;
  unsigned waited = 0;
  for (unsigned i = 0; i < 4000; ++i) {
    const auto next = numbered(10 + (i * 97U) % 1391U, i);
    const Status status = link.send(next);
    if (status == Status::ok) {
      taken.push_back(next);
    } else if (status == Status::no_capacity) {
      ++refused;
    } else {
      break;
    }
    waited += link.waiting_bytes() > 0 ? 1U : 0U;
    if (i % 16 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  Status status = Status::no_capacity;
  for (int i = 0; i < 5000 && status == Status::no_capacity; ++i) {
    status = link.flush();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  sending = false;
  reader.join();
  CHECK_TRUE(status == Status::ok);
  CHECK_TRUE(taken.size() > 10);
  CHECK_TRUE(refused > 10);
  CHECK_TRUE(waited > 10);  // packets were cut, or this test shows nothing
  std::size_t at = 0;
  for (const auto& expected : taken) {
    CHECK_TRUE(at + expected.size() <= stream.size());
    CHECK_TRUE(std::equal(expected.begin(), expected.end(), stream.begin() + static_cast<std::ptrdiff_t>(at)));
    at += expected.size();
  }
  LONGS_EQUAL(at, stream.size());
}

TEST(SerialLink, NobodyReadingDoesNotBlock) {
  CHECK_TRUE(link.open(terminal.path(), 115200) == Status::ok);
  relnav::platform::linux::MonotonicClock clock;
  const relnav::Time before = clock.now();
  std::size_t refused = 0;
  for (unsigned i = 0; i < 1000; ++i) refused += link.send(numbered(1400, i)) == Status::no_capacity ? 1U : 0U;
  CHECK_TRUE(refused > 900);
  CHECK_TRUE((clock.now() - before).ns < 2'000'000'000);
  link.close();  // and neither does this
  CHECK_TRUE((clock.now() - before).ns < 2'000'000'000);
}
