// The contracts of hal/ (tests/contract) on the board's implementations. What passes between board and host are files.
#include <cstdio>
#include <vector>

#include "hal/raw_container.hpp"
#include "platform/mps2/recording_watchdog.hpp"
#include "platform/mps2/semihosted_camera.hpp"
#include "platform/mps2/semihosted_packet_link.hpp"
#include "platform/mps2/systick_clock.hpp"
#include "tests/contract/camera_contract.hpp"
#include "tests/contract/clock_contract.hpp"
#include "tests/contract/packet_link_contract.hpp"
#include "tests/contract/watchdog_contract.hpp"

namespace {

using namespace relnav;
using namespace relnav::platform::mps2;
using Bytes = std::vector<std::uint8_t>;

SystickClock systick;

void write_file(const char* path, const Bytes& bytes) {
  std::FILE* const file = std::fopen(path, "wb");
  CHECK_TRUE(file != nullptr);
  CHECK_TRUE(std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size());
  CHECK_TRUE(std::fclose(file) == 0);
}

template <typename Object>
void append(Bytes& bytes, const Object& object) {
  const auto* const begin = reinterpret_cast<const std::uint8_t*>(&object);
  bytes.insert(bytes.end(), begin, begin + sizeof object);
}

[[gnu::section(".frames")]] SemihostedCamera::Memory frames;

/// A container that grows with every frame offered.
class CameraHarness {
 public:
  CameraHarness() {
    systick.start();
    write();
  }
  hal::Camera& camera() { return camera_; }
  bool offer_frame() {
    offer(0);
    return true;
  }
  bool offer_damaged_frame() {
    offer(1);
    return true;
  }
  bool lose_device() { return false; }
  void restore_device() {}
  Duration wait() { return {}; }
  Time now() { return systick.now(); }
  Duration slack() { return {1'000'000'000}; }  // the emulator's clock is not the board's

 private:
  static constexpr const char* path = "mps2_contract.rnc";

  void offer(std::uint8_t damage) {
    const auto number = static_cast<std::uint8_t>(offsets_.size());
    Bytes pixels{number, 1, 2, 3, 4, static_cast<std::uint8_t>(5 * number)};
    hal::raw::FrameHeader header;
    header.sequence = number;
    header.width_px = 3;
    header.height_px = 2;
    header.pixel_bytes = 6;
    header.pixel_crc = crc32(pixels);
    header.crc = crc_of(header);
    pixels[3] ^= damage;
    offsets_.push_back(sizeof(hal::raw::FileHeader) + frames_.size());
    append(frames_, header);
    frames_.insert(frames_.end(), pixels.begin(), pixels.end());
    write();
  }
  void write() const {
    hal::raw::FileHeader header;
    header.frames = static_cast<std::uint32_t>(offsets_.size());
    header.index_offset = sizeof header + frames_.size();
    header.crc = crc_of(header);
    Bytes file;
    append(file, header);
    file.insert(file.end(), frames_.begin(), frames_.end());
    for (const std::uint64_t offset : offsets_) append(file, offset);
    write_file(path, file);
  }

  Bytes frames_;
  std::vector<std::uint64_t> offsets_;
  SemihostedCamera camera_{path, frames};
};

struct ClockHarness {
  ClockHarness() { systick.start(); }
  hal::Clock& clock() { return systick; }
  void pass_time() {
    const Time begin = systick.now();
    for (int i = 0; i < 1'000'000 && (systick.now() - begin).ns < 2000; ++i) {
    }
  }
};

/// A file does not keep the bounds of packets by itself; each send() is seen here as one growth of the file.
class LinkHarness {
 public:
  LinkHarness() {
    CHECK_TRUE(link_.open(path) == Status::ok);
    CHECK_TRUE(file_.open(path, HostFile::Access::read) == Status::ok);
  }
  hal::PacketLink& link() {
    note_growth();
    return link_;
  }
  std::vector<Bytes> arrived() {
    note_growth();
    std::vector<Bytes> packets;
    for (const std::uint32_t end : ends_) {
      Bytes packet(end - taken_);
      CHECK_TRUE(file_.read(taken_, packet) == Status::ok);
      packets.push_back(packet);
      taken_ = end;
    }
    ends_.clear();
    return packets;
  }

 private:
  static constexpr const char* path = "mps2_contract.bin";

  void note_growth() {
    const std::uint32_t last = ends_.empty() ? taken_ : ends_.back();
    if (file_.size() != last) ends_.push_back(file_.size());
  }

  SemihostedPacketLink link_;
  HostFile file_;
  std::vector<std::uint32_t> ends_;
  std::uint32_t taken_ = 0;
};

struct WatchdogHarness {
  RecordingWatchdog recording;
  hal::Watchdog& watchdog() { return recording; }
  [[nodiscard]] bool reacted() const { return recording.tripped(); }
  static Duration deadline() { return {1'000'000'000}; }
  static void pass(Duration) {}
};

}  // namespace

RELNAV_CAMERA_CONTRACT(SemihostedCameraContract, CameraHarness)
RELNAV_CLOCK_CONTRACT(SystickClockContract, ClockHarness)

// LNK-3 and LNK-6 need a link without room, which a host does not run out of.
RELNAV_PACKET_LINK_CONTRACT(SemihostedPacketLinkContract, LinkHarness)

// WDG-3 needs a deadline, which the emulator's watchdog does not have.
TEST_GROUP(RecordingWatchdogContract) { WatchdogHarness harness; };
RELNAV_CLAUSE(RecordingWatchdogContract, relnav::watchdog_contract, WDG_1_kicks_in_time_prevent_the_reaction)
RELNAV_CLAUSE(RecordingWatchdogContract, relnav::watchdog_contract, WDG_2_trip_reacts_at_once_and_kicks_are_refused)
RELNAV_CLAUSE(RecordingWatchdogContract, relnav::watchdog_contract, WDG_4_trip_may_be_repeated)
