#pragma once
#include <string>

#include "fsw/base/status.hpp"

namespace relnav::platform::linux {

/// Finds the character device of the GPIO chip that `wanted` names: a path (it has a slash), the kernel's name (gpiochip2) or
/// the label of the hardware. Numbers move from boot to boot: a bare number is refused. `path` is the device; on any error
/// it is unchanged and `problem` says what is wrong in one line.
/// no_data: no such chip (yet); ambiguous: several chips have that label; unsupported: not a GPIO chip; io_error: no permission.
Status find_gpio_chip(const std::string& wanted, std::string& path, std::string& problem);

}  // namespace relnav::platform::linux
