#pragma once
/// A serial line whose far end is in the test's hands.
#include <CppUTest/TestHarness.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <vector>

namespace relnav::test {

class PseudoTerminal {
 public:
  PseudoTerminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    CHECK_TRUE(master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0);
    path_ = ::ptsname(master_);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  ~PseudoTerminal() { hang_up(); }

  const std::string& path() const { return path_; }
  void hang_up() {
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }
  /// What comes out at the far end, at most `most` bytes; empty: nothing for `wait_ms`.
  std::vector<std::uint8_t> read(std::size_t most, int wait_ms) {
    std::vector<std::uint8_t> bytes(most);
    pollfd entry{master_, POLLIN, 0};
    if (::poll(&entry, 1, wait_ms) <= 0) return {};
    const ssize_t size = ::read(master_, bytes.data(), bytes.size());
    bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return bytes;
  }

 private:
  int master_;
  std::string path_;
};

}  // namespace relnav::test
