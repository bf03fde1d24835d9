// From a camera to the disk.
#include <sys/resource.h>
#include <algorithm>
#include <csignal>
#include <thread>

#include "hil/capture/capture_run.hpp"
#include "hil/capture/frame_recorder.hpp"
#include "hil/io/raw_container_reader.hpp"
#include "tests/support/scratch.hpp"
#include "tests/support/scripted_driver.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::Scratch;
using relnav::test::ScriptedDriver;

namespace {

constexpr std::uint32_t side_px = 16;

}  // namespace

TEST_GROUP(Capture) {
  Scratch scratch;
  platform::host::ScriptedClock clock;
  ScriptedDriver driver{clock};
  std::string path = scratch.path("c.rnc");

  platform::linux::CameraSettings settings() {
    platform::linux::CameraSettings s;
    s.device = "played";
    s.width_px = s.height_px = side_px;
    s.format = "grey8";
    return s;
  }
  platform::linux::StreamOptions options(std::uint32_t leases) {
    platform::linux::StreamOptions o;
    o.policy = platform::linux::FramePolicy::every_frame;
    o.leases = leases;
    return o;
  }
  /// What the driver offers, recorded; `go_on` may offer more.
  CaptureOutcome record(std::uint64_t frames, std::size_t room,
                        const std::function<bool(const CaptureCounts&)>& go_on) {
    platform::linux::StreamCamera camera(driver, clock, settings(), options(static_cast<std::uint32_t>(room) + 1));
    CHECK(open_camera(camera, {}, [] { return true; }));
    RawContainerWriter writer(path);
    FrameRecorder recorder(writer, room);
    CaptureLimits limits;
    limits.frames = frames;
    limits.patience = {200'000'000};
    const CaptureOutcome outcome = run_capture(camera, recorder, limits, go_on);
    recorded = recorder.counts().recorded;
    CHECK_EQUAL(0, driver.loans());
    CHECK_EQUAL(0, driver.mistakes);
    if (!recorder.has_failed()) writer.finish();
    return outcome;
  }
  std::vector<std::uint32_t> sequences_in_file() {
    const RawContainerReader reader(path);
    std::vector<std::uint32_t> numbers;
    for (std::size_t k = 0; k < reader.frames().size(); ++k) {
      numbers.push_back(reader.frames()[k].header.sequence);
      CHECK(reader.has_good_pixels(k));
    }
    return numbers;
  }
  std::uint64_t recorded = 0;
};

TEST(Capture, EveryFrameIsAccountedFor) {
  bool begun = false;
  const CaptureOutcome outcome = record(6, 8, [&](const CaptureCounts&) {
    if (std::exchange(begun, true)) return true;
    driver.offer_good();  // 0
    driver.offer_good();  // 1
    driver.skip_sequence(3);
    driver.offer_good();     // 5
    driver.offer_damaged();  // 6
    driver.offer_good();     // 7
    driver.skip_sequence(1);
    driver.offer_good();  // 9
    driver.offer_good();  // 10
    driver.offer_good();  // 11: not wanted any more
    return true;
  });
  CHECK_TEXT(outcome.problem.empty(), outcome.problem.c_str());
  CHECK_EQUAL(6, outcome.counts.received);
  CHECK_EQUAL(4, outcome.counts.missing);
  CHECK_EQUAL(1, outcome.counts.incomplete);
  CHECK(outcome.counts.without_room.empty());
  CHECK_EQUAL(6, recorded);
  CHECK((sequences_in_file() == std::vector<std::uint32_t>{0, 1, 5, 7, 9, 10}));
}

TEST(Capture, AnInterruptKeepsWhatWasReceived) {
  const CaptureOutcome outcome = record(0, 8, [&](const CaptureCounts& counts) {
    driver.offer_good();
    return counts.received < 4;
  });
  CHECK(outcome.problem.empty());
  CHECK_EQUAL(4, recorded);
  CHECK((sequences_in_file() == std::vector<std::uint32_t>{0, 1, 2, 3}));
}

TEST(Capture, ALostCameraIsOpenedAgain) {
  int calls = 0;
  const CaptureOutcome outcome = record(4, 8, [&](const CaptureCounts&) {
    ++calls;
    if (calls == 2) driver.present = false;
    if (calls >= 5) driver.present = true;
    if (calls > 5) clock.advance({1'000'000'000});
    if (driver.is_open() && driver.waiting() == 0) driver.offer_good();
    return true;
  });
  CHECK_TEXT(outcome.problem.empty(), outcome.problem.c_str());
  CHECK_EQUAL(1, outcome.counts.camera_losses);
  CHECK_EQUAL(4, recorded);
}

TEST(Capture, ACameraThatStaysAwayEndsTheRunWithAReason) {
  const CaptureOutcome outcome = record(4, 8, [&](const CaptureCounts& counts) {
    driver.offer_good();
    if (counts.received == 2) driver.present = false;
    return true;
  });
  CHECK_MESSAGE_HOLDS(outcome.problem, "played");
  CHECK_EQUAL(2, recorded);
  CHECK_EQUAL(2, sequences_in_file().size());
}

TEST(Capture, FramesWithoutRoomAreCountedByNumber) {
  RawContainerWriter writer(path);
  std::vector<std::uint8_t> pixels(std::size_t{2048} * 2048, 7);
  hal::Frame frame;
  frame.pixels = pixels.data();
  frame.width_px = frame.height_px = frame.stride_bytes = 2048;
  std::vector<std::uint32_t> taken;
  {
    FrameRecorder recorder(writer, 2);
    for (frame.sequence = 0; frame.sequence < 40; ++frame.sequence)
      if (recorder.offer(frame, 0.0)) taken.push_back(frame.sequence);
    recorder.finish();
    CHECK(taken.size() >= 2 && taken.size() < 40);
    CHECK_EQUAL(taken.size(), recorder.counts().recorded);
    CHECK_EQUAL(2, recorder.counts().most_waiting);
    std::size_t back = 0;
    while (recorder.take_back()) ++back;
    CHECK_EQUAL(taken.size(), back);
    CHECK_FALSE(recorder.offer(frame, 0.0));  // it is finished
  }
  writer.finish();
  CHECK(sequences_in_file() == taken);
}

TEST(Capture, AFullDiskEndsTheRunAndKeepsTheRest) {
  const std::size_t frame_bytes = sizeof(hal::raw::FrameHeader) + side_px * side_px;
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit former{};
  ::getrlimit(RLIMIT_FSIZE, &former);
  rlimit limit = former;
  limit.rlim_cur = sizeof(hal::raw::FileHeader) + 5 * frame_bytes + 100;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const CaptureOutcome outcome = record(1000, 4, [&](const CaptureCounts&) {
    driver.offer_good();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return true;
  });
  ::setrlimit(RLIMIT_FSIZE, &former);
  std::signal(SIGXFSZ, handler);
  CHECK_MESSAGE_HOLDS(outcome.problem, "c.rnc: cannot be written: File too large");
  CHECK(outcome.counts.without_room.empty());
  CHECK_EQUAL(5, recorded);
  CHECK((sequences_in_file() == std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
}

TEST(Capture, NumbersAreListedAsRanges) {
  STRCMP_EQUAL("", ranges_text({}).c_str());
  STRCMP_EQUAL("3, 7-9, 20", ranges_text({3, 7, 8, 9, 20}).c_str());
  std::vector<std::uint32_t> odd;
  for (std::uint32_t k = 1; k < 100; k += 2) odd.push_back(k);
  STRCMP_EQUAL("1, 3, 5, 7, 9, 11, 13, 15, 17, 19, ...", ranges_text(odd).c_str());
}
