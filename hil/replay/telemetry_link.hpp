#pragma once
#include <functional>
#include <string>
#include <vector>

#include "hal/packet_link.hpp"
#include "platform/files/udp_address.hpp"
#include "platform/posix/file_packet_link.hpp"
#include "platform/posix/udp_packet_link.hpp"

namespace relnav::hil {

/// Packets to a file and, if wanted, to a UDP address; a listener sees each packet as well.
class TelemetryLink final : public hal::PacketLink {
 public:
  using Listener = std::function<void(std::span<const std::uint8_t>)>;

  TelemetryLink() = default;
  /// Packets sent before are kept and written now. Throws InputError.
  void open(const std::string& file, Listener listener);
  /// `url` is udp://HOST:PORT. Throws InputError.
  void add_udp(const std::string& url);

  Status send(std::span<const std::uint8_t> packet) override;
  [[nodiscard]] std::uint32_t max_packet_bytes() const override;
  /// One line once a packet could not be written to the file; empty until then.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::string path_;
  std::vector<std::vector<std::uint8_t>> early_;
  platform::posix::FilePacketLink file_;
  platform::posix::UdpPacketLink udp_;
  bool has_udp_ = false;
  Listener listener_;
  std::string problem_;
};

/// udp://HOST:PORT or udp://[IPV6]:PORT. Throws InputError.
[[nodiscard]] UdpAddress parse_udp_url(const std::string& url);

}  // namespace relnav::hil
