#include "platform/linux/gpio_chip.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

namespace relnav::platform::linux {
namespace {

constexpr const char* folder = "/dev/";

/// Name and label of the chip behind `path`; errno of what went wrong, else 0.
int chip_info(const std::string& path, std::string& name, std::string& label) {
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return errno;
  gpiochip_info info{};
  const int error = ::ioctl(file, GPIO_GET_CHIPINFO_IOCTL, &info) < 0 ? errno : 0;
  ::close(file);
  if (error != 0) return error == EINVAL || error == ENOSYS ? ENOTTY : error;  // the latter from an emulator
  name.assign(info.name, ::strnlen(info.name, sizeof(info.name)));
  label.assign(info.label, ::strnlen(info.label, sizeof(info.label)));
  return 0;
}

Status status_of(int error) {
  switch (error) {
    case 0: return Status::ok;
    case ENOENT:
    case ENXIO:
    case ENODEV: return Status::no_data;
    case ENOTTY: return Status::unsupported;
    default: return Status::io_error;
  }
}

std::string reason(int error) {
  if (error == ENOTTY) return "is not a GPIO chip";
  return std::string("cannot be opened: ") + std::strerror(error);
}

std::vector<std::string> chip_nodes() {
  std::vector<std::string> names;
  DIR* const listing = ::opendir(folder);
  if (listing == nullptr) return names;
  while (const dirent* const entry = ::readdir(listing)) {
    const std::string name = entry->d_name;
    if (name.rfind("gpiochip", 0) == 0) names.push_back(name);
  }
  ::closedir(listing);
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

Status find_gpio_chip(const std::string& wanted, std::string& path, std::string& problem) {
  if (wanted.empty() || wanted.find_first_not_of("0123456789") == std::string::npos) {
    problem =
        "GPIO chip \"" + wanted + "\": expected a path, a name such as gpiochip0 or a label, not a number, which moves";
    return Status::invalid_argument;
  }
  std::string name;
  std::string label;
  if (wanted.find('/') != std::string::npos) {
    const int error = chip_info(wanted, name, label);
    if (error == 0) {
      path = wanted;
    } else {
      problem = wanted + ": " + reason(error) + "; expected a GPIO chip";
    }
    return status_of(error);
  }

  std::string found;
  std::string seen;
  std::string closed;
  for (const std::string& node : chip_nodes()) {
    const int error = chip_info(folder + node, name, label);
    if (error != 0) {
      if (error == EACCES || error == EPERM) closed += (closed.empty() ? "" : ", ") + (folder + node);
      if (node == wanted) {
        problem = folder + node + ": " + reason(error) + "; expected a GPIO chip";
        return status_of(error);
      }
      continue;
    }
    if (node == wanted || name == wanted) {
      path = folder + node;
      return Status::ok;
    }
    seen += (seen.empty() ? "" : ", ") + name + " (" + label + ")";
    if (label != wanted) continue;
    if (!found.empty()) {
      problem = "GPIO chip \"" + wanted + "\": " + found + " and " + folder + node +
                " both have this label; name one of them by its path";
      return Status::ambiguous;
    }
    found = folder + node;
  }
  if (!found.empty()) {
    path = found;
    return Status::ok;
  }
  problem = "GPIO chip \"" + wanted + "\": none has this name or label; there " +
            (seen.empty() ? std::string("are none that can be opened") : "are " + seen) +
            (closed.empty() ? "" : "; no permission for " + closed);
  return closed.empty() ? Status::no_data : Status::io_error;
}

}  // namespace relnav::platform::linux
