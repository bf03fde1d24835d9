#include "hil/serve/trigger_input.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

constexpr const char* a_pipe = "a pipe with a line for each trigger";
constexpr std::chrono::milliseconds pause{1};  // while nobody has the other end

}  // namespace

void TriggerInput::open() {
  if (path_.empty()) return;
  close();
  fd_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) throw InputError(path_, 0, std::string("cannot be opened: ") + std::strerror(errno), a_pipe);
  read_all();  // older triggers were for nobody
  pending_ = 0;
}

void TriggerInput::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

void TriggerInput::read_all() {
  char text[4096];
  for (;;) {
    const ssize_t got = ::read(fd_, text, sizeof text);
    if (got > 0) {
      pending_ += static_cast<std::uint64_t>(std::count(text, text + got, '\n'));
    } else if (got == 0 || errno == EAGAIN) {
      return;
    } else if (errno != EINTR) {
      throw InputError(path_, 0, std::string("cannot be read: ") + std::strerror(errno), a_pipe);
    }
  }
}

bool TriggerInput::wait(Duration wait) {
  if (path_.empty()) return true;
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::nanoseconds(wait.ns);
  for (;;) {
    if (pending_ == 0) read_all();
    if (pending_ > 0) {
      --pending_;
      return true;
    }
    const auto left = deadline - Clock::now();
    if (left <= left.zero()) return false;
    pollfd file{fd_, POLLIN, 0};
    (void)::poll(&file, 1, static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(left).count()));
    if ((file.revents & POLLHUP) != 0) std::this_thread::sleep_for(pause);
  }
}

}  // namespace relnav::hil
