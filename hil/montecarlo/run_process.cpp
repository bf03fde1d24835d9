#include "hil/montecarlo/run_process.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace relnav::hil {
namespace {

constexpr int exit_not_started = 127;

// Between fork() and exec(): only what may be called after a fork.
[[noreturn]] void become(const char* program, char* const* arguments, int errors, pid_t parent) {
  ::setpgid(0, 0);
  // posix_spawn() has no way to ask for this.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(exit_not_started);  // it was killed before the line above
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDWR);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(nothing, STDOUT_FILENO);
  ::dup2(errors, STDERR_FILENO);
  ::execv(program, arguments);
  ::_exit(exit_not_started);
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

RunProcess::RunProcess(const std::string& program, const std::vector<std::string>& arguments)
    : errors_(::memfd_create("stderr", MFD_CLOEXEC)) {
  std::vector<char*> pointers;
  std::string name = "relnav";
  pointers.push_back(name.data());
  std::vector<std::string> copies = arguments;
  for (std::string& argument : copies) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error(std::string("no process for a run: ") + std::strerror(errno));
  if (pid_ == 0) become(program.c_str(), pointers.data(), errors_.get(), parent);
  ::setpgid(pid_, pid_);  // both sides: whoever is first
}

RunProcess::RunProcess(RunProcess&& other) noexcept
    : errors_(std::move(other.errors_)), pid_(std::exchange(other.pid_, -1)) {}

RunProcess::~RunProcess() {
  if (pid_ < 0) return;
  kill();
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::optional<ProcessEnd> RunProcess::poll() {
  int status = 0;
  rusage used{};
  if (::wait4(pid_, &status, WNOHANG, &used) != pid_) return std::nullopt;
  ::kill(-pid_, SIGKILL);  // what it may have left behind
  pid_ = -1;
  ProcessEnd end;
  end.cpu_s = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  if (WIFEXITED(status)) {
    end.exit_status = WEXITSTATUS(status);
  } else {
    end.signal = WTERMSIG(status);
  }
  return end;
}

void RunProcess::kill() const {
  if (pid_ > 0) ::kill(-pid_, SIGKILL);
}

std::string RunProcess::first_complaint() const {
  char text[1024];
  const ssize_t count = ::pread(errors_.get(), text, sizeof text, 0);
  const std::string all(text, count > 0 ? static_cast<std::size_t>(count) : 0);
  return all.substr(0, all.find('\n'));
}

}  // namespace relnav::hil
