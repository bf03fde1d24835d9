#pragma once
#include <cerrno>
#include <cstring>
#include <string>

#include "fsw/base/status.hpp"

/// What both versions of libgpiod share: how they report errors.
namespace relnav::platform::linux {

inline constexpr const char* gpio_consumer = "relnav";
inline constexpr std::size_t kernel_edges = 16;  ///< of one line that the kernel keeps: its default

[[nodiscard]] inline Status gpio_status(int error) {
  switch (error) {
    case ENODEV:
    case ENXIO: return Status::device_lost;
    case EBUSY: return Status::no_capacity;
    case EINVAL: return Status::invalid_argument;
    case EOPNOTSUPP: return Status::unsupported;
    default: return Status::io_error;
  }
}

/// "/dev/gpiochip0, line 2 (STROBE): cannot be requested as output: Device or resource busy (by "leds")"
[[nodiscard]] inline std::string gpio_problem(const std::string& path, std::uint32_t offset, const std::string& name,
                                              const char* use, int error, const std::string& consumer) {
  std::string text = path + ", line " + std::to_string(offset);
  if (!name.empty()) text += " (" + name + ")";
  text += std::string(": cannot be requested as ") + use + ": " + std::strerror(error);
  if (error == EBUSY && !consumer.empty()) text += " (by \"" + consumer + "\")";
  return text;
}

}  // namespace relnav::platform::linux
