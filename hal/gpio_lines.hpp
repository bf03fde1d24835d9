#pragma once
#include <cstdint>

#include "fsw/base/status.hpp"
#include "hal/frame.hpp"

namespace relnav::hal {

/// Which edges of an input line are reported.
enum class Edges : std::uint8_t { none, rising, falling, both };

/// One change of an input line's level.
struct LineEdge {
  std::uint32_t offset = 0;  ///< line
  bool rising = false;
  Time time;  ///< when the level changed, by the driver, not when the edge was read
  ClockId clock = ClockId::monotonic;
  std::uint32_t sequence = 0;  ///< counts the edges of this line since its request, from 1; a gap means edges were lost
};

/// Digital lines, named by their offset on one chip. Contract (tests/contract/gpio_lines_contract.hpp):
/// GPIO-1  set(), get() and release() of a line that is not requested return not_configured and change nothing.
/// GPIO-2  A request of a line that does not exist returns invalid_argument; of one already requested, no_capacity.
/// GPIO-3  request_output() drives the line to `initial` before it returns; no other level is seen in between.
/// GPIO-4  set() of an output takes effect before it returns; get() then gives the same level. set() of an input returns
///         invalid_argument.
/// GPIO-5  get() reads the level on the line; on an error `level` is unchanged.
/// GPIO-6  wait_edge() gives the edges of all input lines in the order of their time stamps, each one once, and only those asked
///         for.
/// GPIO-7  wait_edge() never blocks longer than `wait`; without an edge it returns no_data or timeout and leaves `edge` unchanged.
/// GPIO-8  When edges are lost because nobody read them, the sequence of the next one shows the gap.
/// GPIO-9  A released line can be requested anew, in either direction; its unread edges are gone.
/// GPIO-10 After loss of the device every call but release() returns device_lost.
class GpioLines {
 public:
  virtual Status request_output(std::uint32_t offset, bool initial) = 0;
  virtual Status request_input(std::uint32_t offset, Edges edges) = 0;
  virtual Status release(std::uint32_t offset) = 0;
  virtual Status set(std::uint32_t offset, bool level) = 0;
  virtual Status get(std::uint32_t offset, bool& level) = 0;
  virtual Status wait_edge(Duration wait, LineEdge& edge) = 0;

 protected:
  GpioLines() = default;
  GpioLines(const GpioLines&) = default;
  GpioLines& operator=(const GpioLines&) = default;
  ~GpioLines() = default;
};

}  // namespace relnav::hal
