#pragma once
#include <cstddef>
#include <cstdint>

#include "fsw/base/time.hpp"

struct pollfd;

namespace relnav::platform::linux {

/// The system calls that a device node needs, as the system has them; a test plays a device by overriding all of them. A
/// negative result is -errno, so that no errno is left lying about. Interrupted calls (EINTR) are the caller's to repeat.
class SystemCalls {
 public:
  virtual ~SystemCalls() = default;
  virtual int open(const char* path, int flags);
  virtual int close(int fd);
  virtual int ioctl(int fd, unsigned long request, void* argument);
  /// Of one file, for at most `wait`.
  virtual int poll(pollfd& file, Duration wait);
  /// Shared, for reading. Null: `error` is -errno.
  virtual void* map(std::size_t bytes, int fd, std::int64_t offset, int& error);
  virtual int unmap(void* address, std::size_t bytes);
};

}  // namespace relnav::platform::linux
