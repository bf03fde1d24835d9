#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace relnav::platform::linux {

/// Tells a service manager how the program is (sd_notify(3), Type=notify): datagrams to the socket that it named in the
/// environment. A program started by hand has no such socket: every call is then ok and does nothing. No call blocks.
class ServiceNotifier {
 public:
  ServiceNotifier() = default;
  ServiceNotifier(const ServiceNotifier&) = delete;
  ServiceNotifier& operator=(const ServiceNotifier&) = delete;
  ~ServiceNotifier() { close(); }

  /// `address`: the value of NOTIFY_SOCKET, null or empty when it is not set. A path, or @ and a name of the abstract room.
  /// invalid_argument: neither; io_error: no socket. problem() then says what is wrong.
  Status open(const char* address);
  void close();
  [[nodiscard]] bool has_manager() const { return socket_ >= 0; }
  [[nodiscard]] const std::string& problem() const { return problem_; }

  Status ready() { return send("READY=1"); }
  Status stopping() { return send("STOPPING=1"); }
  Status watchdog() { return send("WATCHDOG=1"); }
  /// As if the watchdog's time had run out.
  Status trigger_watchdog() { return send("WATCHDOG=trigger"); }
  /// One line for people; cut at 200 bytes.
  Status status(std::string_view text);
  /// no_capacity: the manager does not read; device_lost: it is gone.
  Status send(std::string_view message);

  /// Interval in which the manager expects watchdog(), from the values of WATCHDOG_USEC and WATCHDOG_PID. 0: none, for this
  /// process.
  [[nodiscard]] static Duration watchdog_interval(const char* usec, const char* pid);

 private:
  static constexpr std::size_t max_address_bytes = 110;

  int socket_ = -1;
  alignas(8) unsigned char address_[max_address_bytes] = {};
  std::uint32_t address_bytes_ = 0;
  std::string problem_;
};

}  // namespace relnav::platform::linux
