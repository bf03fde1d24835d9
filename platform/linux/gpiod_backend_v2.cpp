// libgpiod 2.x (Debian 13).
#include <fcntl.h>
#include <gpiod.h>

#include <algorithm>
#include <vector>

#include "platform/linux/gpio_backend.hpp"
#include "platform/linux/gpiod_status.hpp"

namespace relnav::platform::linux {
namespace {

template <auto free_object>
struct Freer {
  template <typename T>
  void operator()(T* object) const {
    free_object(object);
  }
};
template <typename T, auto free_object>
using Owned = std::unique_ptr<T, Freer<free_object>>;

using Chip = Owned<gpiod_chip, gpiod_chip_close>;
using ChipInfo = Owned<gpiod_chip_info, gpiod_chip_info_free>;
using LineInfo = Owned<gpiod_line_info, gpiod_line_info_free>;
using Settings = Owned<gpiod_line_settings, gpiod_line_settings_free>;
using LineConfig = Owned<gpiod_line_config, gpiod_line_config_free>;
using RequestConfig = Owned<gpiod_request_config, gpiod_request_config_free>;
using Request = Owned<gpiod_line_request, gpiod_line_request_release>;
using EventBuffer = Owned<gpiod_edge_event_buffer, gpiod_edge_event_buffer_free>;

class GpiodV2 final : public GpioBackend {
 public:
  Status open(const std::string& path) override {
    close();
    path_ = path;
    events_.reset(gpiod_edge_event_buffer_new(kernel_edges));
    chip_.reset(events_ ? gpiod_chip_open(path.c_str()) : nullptr);
    const ChipInfo info(chip_ ? gpiod_chip_get_info(chip_.get()) : nullptr);
    if (!info) {
      const int error = errno;
      problem_ = path + ": cannot be opened as a GPIO chip: " + std::strerror(error);
      close();
      return error == ENOENT ? Status::no_data : gpio_status(error);
    }
    requests_.resize(gpiod_chip_info_get_num_lines(info.get()));
    return Status::ok;
  }

  void close() override {
    requests_.clear();
    chip_.reset();
  }

  std::uint32_t line_count() const override { return static_cast<std::uint32_t>(requests_.size()); }

  std::string line_name(std::uint32_t offset) override {
    const LineInfo info(gpiod_chip_get_line_info(chip_.get(), offset));
    const char* const name = info ? gpiod_line_info_get_name(info.get()) : nullptr;
    return name == nullptr ? std::string() : std::string(name);
  }

  Status request_output(std::uint32_t offset, bool initial) override {
    const Settings settings(gpiod_line_settings_new());
    const bool set = settings && gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT) == 0 &&
                     gpiod_line_settings_set_output_value(settings.get(), value(initial)) == 0;
    return request(offset, set ? settings.get() : nullptr, "output");
  }

  Status request_input(std::uint32_t offset, hal::Edges edges) override {
    gpiod_line_edge edge = GPIOD_LINE_EDGE_NONE;
    switch (edges) {
      case hal::Edges::none: break;
      case hal::Edges::rising: edge = GPIOD_LINE_EDGE_RISING; break;
      case hal::Edges::falling: edge = GPIOD_LINE_EDGE_FALLING; break;
      case hal::Edges::both: edge = GPIOD_LINE_EDGE_BOTH; break;
    }
    const Settings settings(gpiod_line_settings_new());
    const bool set = settings && gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT) == 0 &&
                     gpiod_line_settings_set_edge_detection(settings.get(), edge) == 0 &&
                     gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC) == 0;
    const char* const use = edges == hal::Edges::none ? "input" : "input with edges";
    if (const Status status = request(offset, set ? settings.get() : nullptr, use); status != Status::ok) return status;
    if (edges == hal::Edges::none || ::fcntl(edge_descriptor(offset), F_SETFL, O_NONBLOCK) == 0) return Status::ok;
    problem_ = gpio_problem(path_, offset, line_name(offset), use, errno, {});
    release(offset);
    return Status::io_error;
  }

  void release(std::uint32_t offset) override { requests_[offset].reset(); }

  Status set(std::uint32_t offset, bool level) override {
    const int result = gpiod_line_request_set_value(requests_[offset].get(), offset, value(level));
    return result == 0 ? Status::ok : gpio_status(errno);
  }

  Status get(std::uint32_t offset, bool& level) override {
    const gpiod_line_value read = gpiod_line_request_get_value(requests_[offset].get(), offset);
    if (read == GPIOD_LINE_VALUE_ERROR) return gpio_status(errno);
    level = read == GPIOD_LINE_VALUE_ACTIVE;
    return Status::ok;
  }

  int edge_descriptor(std::uint32_t offset) const override {
    return gpiod_line_request_get_fd(requests_[offset].get());
  }

  Status read_edges(std::uint32_t offset, std::span<KernelEdge> edges, std::size_t& count) override {
    count = 0;
    const std::size_t room = std::min(edges.size(), kernel_edges);
    const int read = gpiod_line_request_read_edge_events(requests_[offset].get(), events_.get(), room);
    if (read < 0) return errno == EAGAIN || errno == EINTR ? Status::ok : gpio_status(errno);
    count = static_cast<std::size_t>(read);
    for (std::size_t i = 0; i < count; ++i) {
      gpiod_edge_event* const event = gpiod_edge_event_buffer_get_event(events_.get(), i);
      edges[i] = {gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
                  Time{static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event))},
                  static_cast<std::uint32_t>(gpiod_edge_event_get_line_seqno(event))};
    }
    return Status::ok;
  }

  std::size_t kept_edges() const override { return kernel_edges; }
  const std::string& problem() const override { return problem_; }

 private:
  static gpiod_line_value value(bool level) { return level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE; }

  /// `settings` null: they could not be made, errno says why.
  Status request(std::uint32_t offset, gpiod_line_settings* settings, const char* use) {
    const LineConfig lines(settings == nullptr ? nullptr : gpiod_line_config_new());
    const RequestConfig config(lines ? gpiod_request_config_new() : nullptr);
    if (config && gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings) == 0) {
      gpiod_request_config_set_consumer(config.get(), gpio_consumer);
      gpiod_request_config_set_event_buffer_size(config.get(), kernel_edges);
      requests_[offset].reset(gpiod_chip_request_lines(chip_.get(), config.get(), lines.get()));
      if (requests_[offset]) return Status::ok;
    }
    const int error = errno;
    const LineInfo info(error == EBUSY ? gpiod_chip_get_line_info(chip_.get(), offset) : nullptr);
    const char* const consumer = info ? gpiod_line_info_get_consumer(info.get()) : nullptr;
    problem_ = gpio_problem(path_, offset, line_name(offset), use, error, consumer == nullptr ? "" : consumer);
    return gpio_status(error);
  }

  std::string path_;
  std::string problem_;
  Chip chip_;
  std::vector<Request> requests_;
  EventBuffer events_;
};

}  // namespace

std::unique_ptr<GpioBackend> make_gpiod_backend() { return std::make_unique<GpiodV2>(); }

}  // namespace relnav::platform::linux
