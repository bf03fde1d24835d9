#include "platform/linux/system_calls.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace relnav::platform::linux {
namespace {

int or_errno(int result) { return result < 0 ? -errno : result; }

}  // namespace

int SystemCalls::open(const char* path, int flags) { return or_errno(::open(path, flags)); }

int SystemCalls::close(int fd) { return or_errno(::close(fd)); }

int SystemCalls::ioctl(int fd, unsigned long request, void* argument) {
  return or_errno(::ioctl(fd, request, argument));
}

int SystemCalls::poll(pollfd& file, Duration wait) {
  const timespec time{.tv_sec = static_cast<time_t>(wait.ns / 1'000'000'000),
                      .tv_nsec = static_cast<long>(wait.ns % 1'000'000'000)};
  return or_errno(::ppoll(&file, 1, &time, nullptr));
}

void* SystemCalls::map(std::size_t bytes, int fd, std::int64_t offset, int& error) {
  void* const address = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, fd, static_cast<off_t>(offset));
  if (address != MAP_FAILED) return address;
  error = -errno;
  return nullptr;
}

int SystemCalls::unmap(void* address, std::size_t bytes) { return or_errno(::munmap(address, bytes)); }

}  // namespace relnav::platform::linux
