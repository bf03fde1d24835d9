#pragma once
#include <cstdint>
#include <fstream>
#include <string>

namespace relnav::test {

/// The outside of the lines that make_lines() of hil/vm/guest/guest.sh has made in the guest: what is at the other end of the wire.
/// Names are asked for each time: a chip that comes back may have another number.
class SimulatedLines {
 public:
  static constexpr const char* label = "relnav";

  /// Level that the line has, whoever drives it.
  [[nodiscard]] bool level(std::uint32_t offset) const { return read(line(offset) + "value") == "1"; }
  /// What an input sees.
  [[nodiscard]] bool drive(std::uint32_t offset, bool level) const {
    return write(line(offset) + "pull", level ? "pull-up" : "pull-down");
  }
  /// False: the chip vanishes, also for those who hold lines of it.
  [[nodiscard]] bool set_alive(bool alive) const { return write(config() + "live", alive ? "1" : "0"); }

 private:
  static std::string config() { return std::string("/sys/kernel/config/gpio-sim/") + label + "/"; }
  static std::string line(std::uint32_t offset) {
    return "/sys/devices/platform/" + read(config() + "dev_name") + "/" + read(config() + "bank0/chip_name") +
           "/sim_gpio" + std::to_string(offset) + "/";
  }
  static std::string read(const std::string& path) {
    std::string text;
    std::ifstream(path) >> text;
    return text;
  }
  static bool write(const std::string& path, const char* text) {
    std::ofstream file(path);
    file << text << std::flush;
    return file.good();
  }
};

}  // namespace relnav::test
