// libgpiod 1.x (Debian 12).
#include <fcntl.h>
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <vector>

#include "platform/linux/gpio_backend.hpp"
#include "platform/linux/gpiod_status.hpp"

namespace relnav::platform::linux {
namespace {

class GpiodV1 final : public GpioBackend {
 public:
  ~GpiodV1() override { close(); }

  Status open(const std::string& path) override {
    close();
    path_ = path;
    chip_ = gpiod_chip_open(path.c_str());
    if (chip_ == nullptr) {
      const int error = errno;
      problem_ = path + ": cannot be opened as a GPIO chip: " + std::strerror(error);
      return error == ENOENT ? Status::no_data : gpio_status(error);
    }
    lines_.assign(gpiod_chip_num_lines(chip_), nullptr);
    return Status::ok;
  }

  void close() override {
    if (chip_ != nullptr) gpiod_chip_close(chip_);  // releases the lines too
    chip_ = nullptr;
    lines_.clear();
  }

  std::uint32_t line_count() const override { return static_cast<std::uint32_t>(lines_.size()); }

  std::string line_name(std::uint32_t offset) override {
    gpiod_line* const line = gpiod_chip_get_line(chip_, offset);
    const char* const name = line == nullptr ? nullptr : gpiod_line_name(line);
    return name == nullptr ? std::string() : std::string(name);
  }

  Status request_output(std::uint32_t offset, bool initial) override {
    return request(offset, GPIOD_LINE_REQUEST_DIRECTION_OUTPUT, initial, "output");
  }

  Status request_input(std::uint32_t offset, hal::Edges edges) override {
    int type = GPIOD_LINE_REQUEST_DIRECTION_INPUT;
    switch (edges) {
      case hal::Edges::none: break;
      case hal::Edges::rising: type = GPIOD_LINE_REQUEST_EVENT_RISING_EDGE; break;
      case hal::Edges::falling: type = GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE; break;
      case hal::Edges::both: type = GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES; break;
    }
    const char* const use = edges == hal::Edges::none ? "input" : "input with edges";
    if (const Status status = request(offset, type, false, use); status != Status::ok) return status;
    if (edges == hal::Edges::none) return Status::ok;
    const int file = gpiod_line_event_get_fd(lines_[offset]);
    if (file >= 0 && ::fcntl(file, F_SETFL, O_NONBLOCK) == 0) return Status::ok;
    problem_ = gpio_problem(path_, offset, line_name(offset), use, errno, {});
    release(offset);
    return Status::io_error;
  }

  void release(std::uint32_t offset) override {
    if (lines_[offset] != nullptr) gpiod_line_release(lines_[offset]);
    lines_[offset] = nullptr;
  }

  Status set(std::uint32_t offset, bool level) override {
    return gpiod_line_set_value(lines_[offset], level ? 1 : 0) == 0 ? Status::ok : gpio_status(errno);
  }

  Status get(std::uint32_t offset, bool& level) override {
    const int value = gpiod_line_get_value(lines_[offset]);
    if (value < 0) return gpio_status(errno);
    level = value != 0;
    return Status::ok;
  }

  int edge_descriptor(std::uint32_t offset) const override { return gpiod_line_event_get_fd(lines_[offset]); }

  Status read_edges(std::uint32_t offset, std::span<KernelEdge> edges, std::size_t& count) override {
    std::array<gpiod_line_event, kernel_edges> events{};
    const std::size_t room = std::min(edges.size(), events.size());
    count = 0;
    const int read = gpiod_line_event_read_multiple(lines_[offset], events.data(), static_cast<unsigned>(room));
    if (read < 0) return errno == EAGAIN || errno == EINTR ? Status::ok : gpio_status(errno);
    count = static_cast<std::size_t>(read);
    for (std::size_t i = 0; i < count; ++i) {
      const gpiod_line_event& event = events[i];
      edges[i] = {event.event_type == GPIOD_LINE_EVENT_RISING_EDGE,
                  Time{std::int64_t{event.ts.tv_sec} * 1'000'000'000 + event.ts.tv_nsec}, 0};
    }
    return Status::ok;
  }

  std::size_t kept_edges() const override { return kernel_edges; }
  const std::string& problem() const override { return problem_; }

 private:
  Status request(std::uint32_t offset, int type, bool initial, const char* use) {
    gpiod_line_request_config config{};
    config.consumer = gpio_consumer;
    config.request_type = type;
    gpiod_line* const line = gpiod_chip_get_line(chip_, offset);
    if (line != nullptr && gpiod_line_request(line, &config, initial ? 1 : 0) == 0) {
      lines_[offset] = line;
      return Status::ok;
    }
    const int error = errno;
    const char* consumer = nullptr;
    if (line != nullptr && error == EBUSY && gpiod_line_update(line) == 0) consumer = gpiod_line_consumer(line);
    problem_ = gpio_problem(path_, offset, line_name(offset), use, error, consumer == nullptr ? "" : consumer);
    return gpio_status(error);
  }

  std::string path_;
  std::string problem_;
  gpiod_chip* chip_ = nullptr;
  std::vector<gpiod_line*> lines_;  ///< null: not requested
};

}  // namespace

std::unique_ptr<GpioBackend> make_gpiod_backend() { return std::make_unique<GpiodV1>(); }

}  // namespace relnav::platform::linux
