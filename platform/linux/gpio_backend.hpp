#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/gpio_lines.hpp"

namespace relnav::platform::linux {

/// One edge as the kernel reports it. CLOCK_MONOTONIC.
struct KernelEdge {
  bool rising = false;
  Time time;
  std::uint32_t sequence =
      0;  ///< of this line since its request, from 1, lost edges counted; 0: the interface does not count
};

/// What GpiodLines needs of a GPIO library: one chip, each line requested by itself. Offsets are below line_count() and the calls
/// fit the line's use; the caller sees to that. No call blocks. After an error problem() says in one line what is wrong.
/// device_lost: the chip is gone; nothing but release() and close() comes next.
class GpioBackend {
 public:
  GpioBackend() = default;
  GpioBackend(const GpioBackend&) = delete;
  GpioBackend& operator=(const GpioBackend&) = delete;
  virtual ~GpioBackend() = default;

  /// `path` of the character device.
  virtual Status open(const std::string& path) = 0;
  virtual void close() = 0;
  [[nodiscard]] virtual std::uint32_t line_count() const = 0;
  /// Empty: the line has no name.
  [[nodiscard]] virtual std::string line_name(std::uint32_t offset) = 0;
  /// no_capacity: somebody else has the line.
  virtual Status request_output(std::uint32_t offset, bool initial) = 0;
  virtual Status request_input(std::uint32_t offset, hal::Edges edges) = 0;
  virtual void release(std::uint32_t offset) = 0;
  virtual Status set(std::uint32_t offset, bool level) = 0;
  virtual Status get(std::uint32_t offset, bool& level) = 0;
  /// Readable in the sense of poll() while edges wait. Only of an input with edges.
  [[nodiscard]] virtual int edge_descriptor(std::uint32_t offset) const = 0;
  /// Takes the oldest edges that wait, at most edges.size(); `count` may be 0.
  virtual Status read_edges(std::uint32_t offset, std::span<KernelEdge> edges, std::size_t& count) = 0;
  /// How many edges of one line the kernel keeps for a reader.
  [[nodiscard]] virtual std::size_t kept_edges() const = 0;
  [[nodiscard]] virtual const std::string& problem() const = 0;
};

/// libgpiod, API version 1 or 2 as it was there at configure time; without it a backend whose open() says so (unsupported).
[[nodiscard]] std::unique_ptr<GpioBackend> make_gpiod_backend();

}  // namespace relnav::platform::linux
