#pragma once
/// The receiving end of the notify protocol: a datagram socket, named by a path or in the abstract room.
#include <CppUTest/TestHarness.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

namespace relnav::test {

class ServiceManager {
 public:
  /// `address` as in NOTIFY_SOCKET.
  explicit ServiceManager(const std::string& address) : address_(address), socket_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    std::memcpy(name.sun_path, address.data(), address.size());
    if (address[0] == '@') {
      name.sun_path[0] = '\0';
    } else {
      ::unlink(address.c_str());
    }
    const auto bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size());
    CHECK_TRUE(::bind(socket_, reinterpret_cast<const sockaddr*>(&name), bytes) == 0);
  }
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;
  ~ServiceManager() {
    ::close(socket_);
    if (address_[0] != '@') ::unlink(address_.c_str());
  }
  /// Addresses that no other process of the machine uses.
  static std::string abstract_address() { return "@relnav-test-" + std::to_string(::getpid()); }
  static std::string path_address() { return "/tmp/relnav-test-" + std::to_string(::getpid()) + ".sock"; }

  const char* address() const { return address_.c_str(); }
  std::vector<std::string> received() {
    std::vector<std::string> messages;
    char buffer[4096];
    for (ssize_t size = 0; (size = ::recv(socket_, buffer, sizeof(buffer), MSG_DONTWAIT)) >= 0;)
      messages.emplace_back(buffer, static_cast<std::size_t>(size));
    return messages;
  }

 private:
  std::string address_;
  int socket_;
};

}  // namespace relnav::test
