#pragma once
#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hal/gpio_lines.hpp"
#include "platform/linux/gpio_backend.hpp"

namespace relnav::platform::linux {

/// Lines of one GPIO chip. Edges bear the kernel's stamps of CLOCK_MONOTONIC and are merged over the lines.
///
/// After loss of the chip (GPIO-10) the next request looks for it again, under the same name; lines requested before stay lost,
/// until they are released and requested anew.
/// GPIO-6: an edge that the kernel hands over later than a younger one of another line (its interrupt thread was late by more
/// than a whole call) still comes, out of order.
/// GPIO-8: version 1 of the API does not count edges. With it a kernel buffer found full (16 edges of one line unread) shows as
/// one lost edge, since some may have been; how many is not known.
class GpiodLines final : public hal::GpioLines {
 public:
  explicit GpiodLines(GpioBackend& backend) : backend_(backend) {}
  GpiodLines(const GpiodLines&) = delete;
  GpiodLines& operator=(const GpiodLines&) = delete;
  ~GpiodLines() { close(); }

  /// `chip`: path, name or label, see find_gpio_chip(). Closes what is open. On an error problem() says what is wrong.
  Status open(const std::string& chip);
  /// For a device whose path is known.
  Status open_path(const std::string& path);
  /// Releases every line: outputs go back to what the hardware does by itself.
  void close();
  /// Offset of the line that `line` names: its offset in decimal, or its name. invalid_argument: there is none; ambiguous:
  /// several lines have that name; not_configured before open().
  Status find_line(const std::string& line, std::uint32_t& offset);
  /// One line about the latest error of open(), find_line() or a request: chip, line, what is wrong, what was expected.
  [[nodiscard]] const std::string& problem() const { return problem_; }

  /// no_capacity also when another process has the line.
  Status request_output(std::uint32_t offset, bool initial) override;
  Status request_input(std::uint32_t offset, hal::Edges edges) override;
  Status release(std::uint32_t offset) override;
  Status set(std::uint32_t offset, bool level) override;
  Status get(std::uint32_t offset, bool& level) override;
  /// May return early, without an edge, when a signal arrives.
  Status wait_edge(Duration wait, hal::LineEdge& edge) override;

 private:
  enum class Use : std::uint8_t { none, input, output, lost };
  struct Line {
    Use use = Use::none;
    hal::Edges edges = hal::Edges::none;
    std::uint32_t sequence = 0;           ///< of the latest edge
    bool gap = false;                     ///< edges after it may have been lost
    std::vector<hal::LineEdge> unread{};  ///< a ring...
    std::size_t first = 0;                ///< ...and where its oldest edge is
    std::size_t count = 0;
  };

  Status open_backend();
  Status request(std::uint32_t offset, Use use, hal::Edges edges, bool initial);
  Status check_requested(std::uint32_t offset) const;
  Status lost();
  Status note(Status status);
  Status collect();
  Status collect_line(std::uint32_t offset);
  void append(std::uint32_t offset, const KernelEdge& edge);
  Line* oldest();
  bool take(Time before, hal::LineEdge& edge);
  void watch_lines();

  GpioBackend& backend_;
  std::string chip_;
  bool chip_is_path_ = false;
  std::string problem_;
  bool open_ = false;
  bool lost_ = false;
  std::vector<Line> lines_;
  std::vector<pollfd> watched_;               ///< inputs with edges...
  std::vector<std::uint32_t> watched_lines_;  ///< ...and which lines they are
  std::vector<KernelEdge> fresh_;             ///< what one read can bring
};

}  // namespace relnav::platform::linux
