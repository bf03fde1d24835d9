#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "platform/host/scripted_packet_link.hpp"
#include "platform/posix/file_packet_link.hpp"
#include "platform/posix/udp_packet_link.hpp"
#include "tests/contract/packet_link_contract.hpp"

namespace {

using relnav::Status;
using relnav::platform::host::ScriptedPacketLink;
using relnav::platform::posix::FilePacketLink;
using relnav::platform::posix::UdpPacketLink;
using Packets = std::vector<std::vector<std::uint8_t>>;

class ScriptedLinkHarness {
 public:
  relnav::hal::PacketLink& link() { return link_; }
  void refuse_next() { CHECK_TRUE(link_.push_answer(Status::no_capacity) == Status::ok); }
  Packets arrived() {
    Packets packets;
    for (std::size_t i = 0; i < link_.size(); ++i) {
      const auto bytes = link_.packet(i);
      packets.emplace_back(bytes.begin(), bytes.end());
    }
    link_.clear();
    return packets;
  }

 private:
  ScriptedPacketLink link_{32, 1400};
};

/// A file of its own, gone with the harness.
class TemporaryFile {
 public:
  TemporaryFile() {
    const int file = mkstemp(path_.data());
    CHECK_TRUE(file >= 0);
    close(file);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { unlink(path_.c_str()); }
  const char* path() const { return path_.c_str(); }
  std::vector<std::uint8_t> content() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  std::string path_ = "/tmp/relnav_link_XXXXXX";
};

/// A file does not keep the bounds of packets by itself; each send() is seen here as one growth of the file.
class FileLinkHarness {
 public:
  FileLinkHarness() {
    CHECK_TRUE(link_.open(file_.path()) == Status::ok);
    getrlimit(RLIMIT_FSIZE, &limit_before_);
    handler_before_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  FileLinkHarness(const FileLinkHarness&) = delete;
  FileLinkHarness& operator=(const FileLinkHarness&) = delete;
  ~FileLinkHarness() {
    setrlimit(RLIMIT_FSIZE, &limit_before_);
    std::signal(SIGXFSZ, handler_before_);
  }
  relnav::hal::PacketLink& link() {
    note_growth();
    return observer_;
  }
  /// A limit on the size of files lets half of the packet in: the rest must be taken back.
  void refuse_next() { refuse_ = true; }
  Packets arrived() {
    note_growth();
    const auto content = file_.content();
    Packets packets;
    std::size_t at = seen_;
    for (const std::size_t end : ends_) {
      packets.emplace_back(content.begin() + static_cast<std::ptrdiff_t>(at),
                           content.begin() + static_cast<std::ptrdiff_t>(end));
      at = end;
    }
    ends_.clear();
    seen_ = at;
    return packets;
  }

 private:
  class Observer final : public relnav::hal::PacketLink {
   public:
    explicit Observer(FileLinkHarness& harness) : harness_(harness) {}
    Status send(std::span<const std::uint8_t> packet) override {
      harness_.note_growth();
      if (harness_.refuse_) {
        rlimit limit = harness_.limit_before_;
        limit.rlim_cur = harness_.file_.content().size() + packet.size() / 2;
        setrlimit(RLIMIT_FSIZE, &limit);
      }
      const Status status = harness_.link_.send(packet);
      if (harness_.refuse_) setrlimit(RLIMIT_FSIZE, &harness_.limit_before_);
      harness_.refuse_ = false;
      return status;
    }
    std::uint32_t max_packet_bytes() const override { return harness_.link_.max_packet_bytes(); }

   private:
    FileLinkHarness& harness_;
  };

  void note_growth() {
    const std::size_t size = file_.content().size();
    if (size != (ends_.empty() ? seen_ : ends_.back())) ends_.push_back(size);
  }

  TemporaryFile file_;
  FilePacketLink link_;
  Observer observer_{*this};
  rlimit limit_before_{};
  void (*handler_before_)(int) = SIG_DFL;
  bool refuse_ = false;
  std::size_t seen_ = 0;
  std::vector<std::size_t> ends_;
};

/// Listens on a free port of the loopback interface.
class UdpListener {
 public:
  UdpListener() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    CHECK_TRUE(bind(socket_, reinterpret_cast<const sockaddr*>(&address_), sizeof(address_)) == 0);
    socklen_t size = sizeof(address_);
    CHECK_TRUE(getsockname(socket_, reinterpret_cast<sockaddr*>(&address_), &size) == 0);
  }
  UdpListener(const UdpListener&) = delete;
  UdpListener& operator=(const UdpListener&) = delete;
  ~UdpListener() { close(socket_); }
  std::uint16_t port() const { return ntohs(address_.sin_port); }
  Packets received() {
    Packets packets;
    pollfd poll_entry{socket_, POLLIN, 0};
    while (poll(&poll_entry, 1, 20) == 1) {
      std::vector<std::uint8_t> packet(65536);
      const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
      if (size < 0) break;
      packet.resize(static_cast<std::size_t>(size));
      packets.push_back(packet);
    }
    return packets;
  }

 private:
  int socket_;
  sockaddr_in address_{};
};

class UdpLinkHarness {
 public:
  UdpLinkHarness() { CHECK_TRUE(link_.open("127.0.0.1", listener_.port()) == Status::ok); }
  relnav::hal::PacketLink& link() { return link_; }
  Packets arrived() { return listener_.received(); }

 private:
  UdpListener listener_;
  UdpPacketLink link_;
};

}  // namespace

RELNAV_PACKET_LINK_CONTRACT(ScriptedPacketLinkContract, ScriptedLinkHarness)
RELNAV_PACKET_LINK_REFUSAL_CONTRACT(ScriptedPacketLinkContract)
RELNAV_PACKET_LINK_CONTRACT(FilePacketLinkContract, FileLinkHarness)
RELNAV_PACKET_LINK_REFUSAL_CONTRACT(FilePacketLinkContract)
RELNAV_PACKET_LINK_CONTRACT(UdpPacketLinkContract, UdpLinkHarness)

TEST_GROUP(ScriptedPacketLink) {
  ScriptedPacketLink link{2, 8};
  std::vector<std::uint8_t> packet{1, 2, 3};
};

TEST(ScriptedPacketLink, AnswersByScriptThenTakesPacketsUpToItsBound) {
  CHECK_TRUE(link.push_answer(Status::io_error, 2) == Status::ok);
  CHECK_TRUE(link.push_answer(Status::ok) == Status::ok);
  CHECK_TRUE(link.push_answer(Status::device_lost) == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::io_error);
  CHECK_TRUE(link.send(packet) == Status::io_error);
  CHECK_TRUE(link.send(packet) == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::device_lost);
  CHECK_TRUE(link.send(packet) == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::no_capacity);
  LONGS_EQUAL(2, link.size());
  LONGS_EQUAL(4, link.refused());
}

TEST_GROUP(FilePacketLink) {
  TemporaryFile file;
  FilePacketLink link;
  std::vector<std::uint8_t> packet{1, 2, 3};
};

TEST(FilePacketLink, NotConfiguredBeforeOpenAndAfterClose) {
  CHECK_TRUE(link.send(packet) == Status::not_configured);
  CHECK_TRUE(link.open(file.path()) == Status::ok);
  CHECK_TRUE(link.close() == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::not_configured);
}

TEST(FilePacketLink, AppendsOrStartsAnew) {
  for (int i = 0; i < 2; ++i) {
    CHECK_TRUE(link.open(file.path(), FilePacketLink::Start::append) == Status::ok);
    CHECK_TRUE(link.send(packet) == Status::ok);
  }
  LONGS_EQUAL(6, file.content().size());
  CHECK_TRUE(link.open(file.path()) == Status::ok);
  LONGS_EQUAL(0, file.content().size());
}

TEST(FilePacketLink, PathThatCannotBeWritten) {
  CHECK_TRUE(link.open("/nonexistent/telemetry.bin") == Status::io_error);
  CHECK_TRUE(link.open("/") == Status::io_error);
}

TEST(FilePacketLink, FullDiskIsNoCapacity) {
  CHECK_TRUE(link.open("/dev/full") == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::no_capacity);
}

TEST_GROUP(UdpPacketLink) {
  UdpPacketLink link;
  std::vector<std::uint8_t> packet{1, 2, 3};
};

TEST(UdpPacketLink, NotConfiguredBeforeOpen) { CHECK_TRUE(link.send(packet) == Status::not_configured); }

TEST(UdpPacketLink, AddressesThatAreNone) {
  CHECK_TRUE(link.open("256.1.1.1.1", 10015) == Status::invalid_argument);
  CHECK_TRUE(link.open("127.0.0.1", 0) == Status::invalid_argument);
}

TEST(UdpPacketLink, NobodyListeningIsNotAnError) {
  std::uint16_t port = 0;
  { port = UdpListener().port(); }
  CHECK_TRUE(link.open("127.0.0.1", port) == Status::ok);
  for (int i = 0; i < 5; ++i) CHECK_TRUE(link.send(packet) == Status::ok);
}

TEST(UdpPacketLink, LocalhostReachesAListenerOnIpv4) {
  UdpListener listener;
  CHECK_TRUE(link.open("localhost", listener.port()) == Status::ok);
  CHECK_TRUE(link.send(packet) == Status::ok);
  LONGS_EQUAL(1, listener.received().size());
}
