#include "platform/linux/aravis_link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

namespace relnav::platform::linux {
namespace {

constexpr std::uint16_t gvcp_port = 3956;
constexpr int tries = 3;
constexpr int wait_ms = 100;

/// Sends GVCP's discovery command on a connected socket; true when anything comes back.
bool answers(int socket) {
  // key, flags (an answer is required), command DISCOVERY (2), length 0, request 1
  constexpr std::array<std::uint8_t, 8> question{0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01};
  std::array<std::uint8_t, 600> answer{};
  for (int i = 0; i < tries; ++i) {
    if (::send(socket, question.data(), question.size(), 0) < 0) return false;
    pollfd entry{socket, POLLIN, 0};
    if (::poll(&entry, 1, wait_ms) <= 0) continue;
    return ::recv(socket, answer.data(), answer.size(), 0) > 0;  // refused: nobody has the port
  }
  return false;
}

}  // namespace

bool is_ipv4_address(const std::string& text) {
  in_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1;
}

Status find_gige_camera(const std::string& address, std::string& our_address) {
  sockaddr_in camera{};
  camera.sin_family = AF_INET;
  camera.sin_port = htons(gvcp_port);
  if (::inet_pton(AF_INET, address.c_str(), &camera.sin_addr) != 1) return Status::invalid_argument;
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return Status::io_error;
  sockaddr_in ours{};
  socklen_t size = sizeof ours;
  Status status = Status::no_data;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&camera), sizeof camera) == 0 && answers(socket) &&
      ::getsockname(socket, reinterpret_cast<sockaddr*>(&ours), &size) == 0) {
    std::array<char, INET_ADDRSTRLEN> text{};
    if (::inet_ntop(AF_INET, &ours.sin_addr, text.data(), text.size()) != nullptr) {
      our_address = text.data();
      status = Status::ok;
    }
  }
  ::close(socket);
  return status;
}

Status set_receive_buffer(std::uint16_t port, std::uint32_t bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return Status::io_error;
  constexpr rlim_t most = 4096;  // streams are opened early
  const int end = static_cast<int>(limit.rlim_cur < most ? limit.rlim_cur : most);
  const int size = static_cast<int>(bytes);
  for (int fd = 0; fd < end; ++fd) {
    int type = 0;
    socklen_t length = sizeof type;
    if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &length) != 0 || type != SOCK_DGRAM) continue;
    sockaddr_in bound{};
    length = sizeof bound;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &length) != 0) continue;
    if (bound.sin_family != AF_INET || ntohs(bound.sin_port) != port) continue;
    // The privileged may have more than net.core.rmem_max.
    if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &size, sizeof size) == 0) return Status::ok;
    return ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &size, sizeof size) == 0 ? Status::ok : Status::io_error;
  }
  return Status::no_data;
}

}  // namespace relnav::platform::linux
