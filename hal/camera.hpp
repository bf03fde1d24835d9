#pragma once
#include "fsw/base/status.hpp"
#include "hal/frame.hpp"

namespace relnav::hal {

/// Source of frames. Contract (tests/contract/camera_contract.hpp runs each clause on every implementation):
/// CAM-1  acquire() before a successful start() returns not_configured.
/// CAM-2  acquire() on success fills a frame whose pixels stay valid and unchanged until its release(); on any other status
///        `frame` is unchanged.
/// CAM-3  acquire() never blocks longer than `wait`; with nothing to give it returns no_data or timeout.
/// CAM-4  At most max_leases() leases are out at once; one more acquire() returns no_capacity.
/// CAM-5  release() of a lease that is not out returns stale_handle and changes nothing.
/// CAM-6  A damaged or incomplete frame is never handed out: acquire() returns incomplete, and its sequence number is left out.
/// CAM-7  Sequence numbers of frames handed out between start() and stop() strictly increase; a gap means frames were lost.
/// CAM-8  After loss of the device acquire() returns device_lost until start() succeeds again.
/// CAM-9  stop() ends streaming: acquire() returns not_configured until the next start(); leases that are out stay valid until
///        released.
/// CAM-10 A frame handed out is well formed: pixels, width and height are not zero, a row fits its stride, `lease` names it among
///        the leases that are out.
class Camera {
 public:
  virtual Status start() = 0;
  virtual Status acquire(Duration wait, Frame& frame) = 0;
  virtual Status release(const Frame& frame) = 0;
  virtual Status stop() = 0;
  [[nodiscard]] virtual std::uint32_t max_leases() const = 0;

 protected:
  Camera() = default;
  Camera(const Camera&) = default;
  Camera& operator=(const Camera&) = default;
  ~Camera() = default;  // protected, non-virtual: objects have static storage and are never deleted through this
};

}  // namespace relnav::hal
