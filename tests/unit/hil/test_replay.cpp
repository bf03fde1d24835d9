#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "hil/io/image.hpp"
#include "hil/replay/replay_camera.hpp"
#include "hil/replay/replay_run.hpp"
#include "hil/replay/summary.hpp"
#include "hil/report/base64.hpp"
#include "hil/report/report.hpp"
#include "platform/files/text.hpp"
#include "tests/support/scratch.hpp"
#include "tests/unit/hil/fake_loop.hpp"
#include "tests/unit/hil/hand_made_png.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::FakeLoop;
using relnav::test::FakePairLoop;
using relnav::test::message_of;
using relnav::test::Scratch;

namespace {

constexpr std::uint32_t width = 8;
constexpr std::uint32_t height = 6;

class FixedClock final : public hal::Clock {
 public:
  Time time;
  [[nodiscard]] Time now() override { return time; }
  [[nodiscard]] hal::ClockId id() const override { return hal::ClockId::monotonic; }
};

std::string png_bytes(std::uint32_t w, std::uint32_t h, std::uint8_t level) {
  const auto bytes = encode_png({w, h, 1, std::vector<std::uint8_t>(std::size_t{w} * h, level)});
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace

TEST_GROUP(Replay) {
  Scratch scratch;
  FixedClock clock;
  RunHistory history;
  std::size_t shown = 0;

  /// Images at 0.1 s steps, of grey level 10, 11, ...
  std::vector<ImageEntry> images(int count) {
    std::vector<ImageEntry> entries;
    for (int i = 0; i < count; ++i) {
      const std::string name = "f" + std::to_string(i) + ".png";
      entries.push_back({Time{(i + 1) * 100'000'000LL},
                         scratch.write(name, png_bytes(width, height, static_cast<std::uint8_t>(10 + i))), i + 1});
    }
    return entries;
  }
  /// Two cameras, each with images of these rows (0.1 s a row); `files` of the first and the second have names of their own.
  std::vector<ImageEntry> rows_of(const std::string& name, std::initializer_list<int> rows) {
    std::vector<ImageEntry> entries;
    for (const int row : rows) {
      const std::string file = name + std::to_string(row) + ".png";
      entries.push_back({Time{(row + 1) * 100'000'000LL}, scratch.write(file, png_bytes(width, height, 50)), row + 1});
    }
    return entries;
  }
  ReplayOutcome run_pair(ReplayCamera & first, ReplayCamera & second) {
    FakePairLoop loop(first, second);
    RunFiles files(prepare_run_folder(scratch.path("out"), true));
    return run_replay(loop, {&first, &second}, &files, history,
                      [&](std::size_t done, std::size_t listed, const app::StepReport&) {
                        CHECK(done <= listed);
                        ++shown;
                        return true;
                      });
  }
  ReplayCamera camera_over(std::vector<ImageEntry> entries, Pace pace = Pace::max, Depth depth = Depth::eight_bits) {
    return ReplayCamera(std::move(entries), width, height, clock, pace, depth);
  }
  ReplayOutcome run(ReplayCamera & camera, FakeLoop & loop, std::size_t stop_after = 1000) {
    RunFiles files(prepare_run_folder(scratch.path("out"), true));
    return run_replay(loop, {&camera}, &files, history, [&](std::size_t done, std::size_t, const app::StepReport&) {
      ++shown;
      return done < stop_after;
    });
  }
  std::size_t lines(const std::string& name) { return read_lines(scratch.path("out/" + name)).size(); }
};

TEST(Replay, SixteenBitImagesStayThatOrLoseTheirLowerByte) {
  std::string rows;
  for (std::uint32_t v = 0; v < height; ++v) {
    rows.push_back('\0');
    for (std::uint32_t u = 0; u < width; ++u) rows += {static_cast<char>(v + 1), static_cast<char>(u)};
  }
  const std::vector<ImageEntry> entries{
      {Time{1}, scratch.write("deep.png", relnav::test::make_png(width, height, 16, 0, rows)), 1}};
  hal::Frame frame;
  ReplayCamera deep = camera_over(entries, Pace::max, Depth::as_filed);
  CHECK(deep.start() == Status::ok);
  CHECK(deep.acquire({}, frame) == Status::ok);
  CHECK(frame.format == hal::PixelFormat::mono16);
  CHECK_EQUAL(2 * width, frame.stride_bytes);
  std::uint16_t sample = 0;
  std::memcpy(&sample, frame.pixels + 2 * frame.stride_bytes + 2 * 5, sizeof sample);
  CHECK_EQUAL(0x0305, sample);

  ReplayCamera plain = camera_over(entries);
  CHECK(plain.start() == Status::ok);
  CHECK(plain.acquire({}, frame) == Status::ok);
  CHECK(frame.format == hal::PixelFormat::mono8);
  CHECK_EQUAL(width, frame.stride_bytes);
  CHECK_EQUAL(3, static_cast<int>(frame.pixels[2 * width + 5]));
}

TEST(Replay, CameraHandsOutFramesInOrderWithStampsOfTheList) {
  ReplayCamera camera = camera_over(images(3));
  hal::Frame frame;
  CHECK(camera.acquire(Duration{0}, frame) == Status::not_configured);
  CHECK(camera.start() == Status::ok);
  for (std::uint32_t i = 0; i < 3; ++i) {
    CHECK(camera.acquire(Duration{0}, frame) == Status::ok);
    CHECK_EQUAL(i, frame.sequence);
    CHECK_EQUAL((i + 1) * 100'000'000LL, frame.mid_exposure.ns);
    CHECK_EQUAL(10U + i, static_cast<unsigned>(frame.pixels[frame.stride_bytes * (height - 1) + width - 1]));
    CHECK(camera.release(frame) == Status::ok);
    CHECK(camera.release(frame) == Status::stale_handle);
  }
  CHECK(camera.exhausted());
  CHECK(camera.acquire(Duration{0}, frame) == Status::no_data);
}

TEST(Replay, CameraKeepsLeasedPixelsAndLimitsLeases) {
  ReplayCamera camera = camera_over(images(5));
  CHECK(camera.start() == Status::ok);
  std::vector<hal::Frame> held(camera.max_leases());
  for (hal::Frame& frame : held) CHECK(camera.acquire(Duration{0}, frame) == Status::ok);
  hal::Frame more;
  CHECK(camera.acquire(Duration{0}, more) == Status::no_capacity);
  CHECK(camera.release(held[1]) == Status::ok);
  CHECK(camera.acquire(Duration{0}, more) == Status::ok);
  CHECK_EQUAL(10U, static_cast<unsigned>(held[0].pixels[0]));
  CHECK_EQUAL(12U, static_cast<unsigned>(held[2].pixels[0]));
  CHECK_EQUAL(13U, static_cast<unsigned>(more.pixels[0]));
}

TEST(Replay, CameraWaitsForItsStampAtRealPace) {
  ReplayCamera camera = camera_over(images(2), Pace::real);
  CHECK(camera.start() == Status::ok);
  hal::Frame frame;
  CHECK(camera.acquire(Duration{0}, frame) == Status::ok);
  CHECK(camera.acquire(Duration{0}, frame) == Status::no_data);
  CHECK(camera.acquire(Duration{1000}, frame) == Status::timeout);
  clock.time.ns += 100'000'000;
  CHECK(camera.acquire(Duration{0}, frame) == Status::ok);
}

TEST(Replay, WritesARowPerFrameAndEndsWell) {
  ReplayCamera camera = camera_over(images(30));
  FakeLoop loop(camera);
  const ReplayOutcome outcome = run(camera, loop);
  CHECK_EQUAL(0, exit_status_of(outcome));
  CHECK_EQUAL(30U, outcome.poses);
  CHECK_EQUAL(30U, shown);
  CHECK_EQUAL(31U, lines("trajectory.tum"));
  CHECK_EQUAL(31U, lines("covariance.csv"));
  CHECK_EQUAL(31U, lines("timing.csv"));
  CHECK_EQUAL(12U, history.snapshots.size());
  CHECK_EQUAL(0U, history.snapshots.front().frame);
  CHECK_EQUAL(29U, history.snapshots.back().frame);
  STRCMP_EQUAL("100000000,0.0,0.0,0.0,0.0,0.0,0.0,2500.0", read_lines(scratch.path("out/timing.csv"))[1].c_str());
  CHECK_EQUAL(100'000'000, read_trajectory(scratch.path("out/trajectory.tum"))[0].time.ns);
}

TEST(Replay, RepeatedAndBackwardStampsReachTheLoop) {
  auto entries = images(5);
  entries[2].time = entries[1].time;
  entries[3].time.ns = 50'000'000;
  ReplayCamera camera = camera_over(entries);
  FakeLoop loop(camera);
  const ReplayOutcome outcome = run(camera, loop);
  CHECK_EQUAL(0, exit_status_of(outcome));
  CHECK_EQUAL(3U, outcome.poses);
  CHECK_EQUAL(5U, history.frames.size());
  CHECK(history.frames[2].status == Status::out_of_order);
  CHECK_EQUAL(3U, read_trajectory(scratch.path("out/trajectory.tum")).size());
}

TEST(Replay, BadImagesEndTheRunAndKeepWhatWasDone) {
  struct Case {
    std::string bytes;  ///< empty: no file
    const char* says;
  };
  const std::string good = png_bytes(width, height, 1);
  for (const Case& c : {Case{"", "cannot be opened"}, Case{good.substr(0, good.size() / 2), "damaged or truncated"},
                        Case{png_bytes(4, 3, 1), "4 x 3 pixels (expected 8 x 6 as the camera file says)"},
                        Case{"text", "no PNG signature"}}) {
    history = {};
    auto entries = images(5);
    std::filesystem::remove(entries[3].path);
    if (!c.bytes.empty()) scratch.write("f3.png", c.bytes);
    ReplayCamera camera = camera_over(entries);
    FakeLoop loop(camera);
    const ReplayOutcome outcome = run(camera, loop);
    CHECK_EQUAL(2, exit_status_of(outcome));
    CHECK_MESSAGE_HOLDS(outcome.problem, c.says);
    CHECK_MESSAGE_HOLDS(outcome.problem, "f3.png: ");
    CHECK_EQUAL(3U, read_trajectory(scratch.path("out/trajectory.tum")).size());
    CHECK(camera.incomplete_frames() == 1);
  }
}

TEST(Replay, EndsWhenTheImagesOfBothCamerasHaveBeenDealtWith) {
  for (const bool swapped : {false, true}) {
    history = {};
    ReplayCamera a = camera_over(rows_of("a", {0, 1, 4}));
    ReplayCamera b = camera_over(rows_of("b", {1, 2, 5}));
    const ReplayOutcome outcome = swapped ? run_pair(b, a) : run_pair(a, b);
    CHECK_EQUAL(0, exit_status_of(outcome));
    CHECK(a.finished() && b.finished());
    // Rows 0, 1 (a pair), 2, 4, 5: the last one is handed out long before it is dealt with.
    CHECK_EQUAL(5U, outcome.poses);
    CHECK_EQUAL(5U, history.frames.size());
    const std::int64_t stamps[] = {1, 2, 3, 5, 6};
    for (std::size_t i = 0; i < 5; ++i) {
      CHECK_EQUAL(stamps[i] * 100'000'000, history.frames[i].time.ns);
      CHECK_EQUAL(stamps[i] * 100'000'000, history.frames[i].state.time.ns);
    }
    CHECK_EQUAL(5U, history.snapshots.size());
    for (const Snapshot& shot : history.snapshots) {
      const std::string row = std::to_string(shot.time.ns / 100'000'000 - 1);
      CHECK_MESSAGE_HOLDS(shot.image.path, row + ".png");  // the image that the features are of
    }
  }
}

TEST(Replay, ABadImageOfEitherCameraEndsTheRun) {
  for (const bool in_second : {false, true}) {
    history = {};
    ReplayCamera first = camera_over(rows_of("a", {0, 1, 2, 3}));
    ReplayCamera second = camera_over(rows_of("b", {0, 1, 2, 3}));
    scratch.write(in_second ? "b2.png" : "a2.png", "text");
    const ReplayOutcome outcome = run_pair(first, second);
    CHECK(outcome.end == ReplayOutcome::End::bad_image);
    CHECK_EQUAL(2, exit_status_of(outcome));
    CHECK_MESSAGE_HOLDS(outcome.problem, in_second ? "b2.png: no PNG signature" : "a2.png: no PNG signature");
    CHECK_EQUAL(3U, history.frames.size());
    CHECK_EQUAL(3U, read_trajectory(scratch.path("out/trajectory.tum")).size());  // the other's image is used
    CHECK_MESSAGE_HOLDS(history.snapshots.back().image.path, in_second ? "a2.png" : "b2.png");
  }
}

TEST(Replay, NoPoseAndLostTrackAreFaults) {
  for (const app::Mode mode : {app::Mode::acquire, app::Mode::lost}) {
    ReplayCamera camera = camera_over(images(3));
    FakeLoop loop(camera);
    loop.mode = mode;
    loop.finds_target = false;
    const ReplayOutcome outcome = run(camera, loop);
    CHECK_EQUAL(1, exit_status_of(outcome));
    CHECK_MESSAGE_HOLDS(outcome.problem, "no pose was estimated");
  }
  ReplayCamera camera = camera_over(images(3));
  FakeLoop loop(camera);
  RunFiles files(prepare_run_folder(scratch.path("out"), true));
  const ReplayOutcome outcome =
      run_replay(loop, {&camera}, &files, history, [&](std::size_t done, std::size_t, const app::StepReport&) {
        if (done == 2) loop.mode = app::Mode::lost;
        return true;
      });
  CHECK_EQUAL(1, exit_status_of(outcome));
  CHECK_MESSAGE_HOLDS(outcome.problem, "ended without track, in mode LOST");
}

TEST(Replay, AnEstimateStillInItsFirstStartIsNoFault) {
  ReplayCamera camera = camera_over(images(3));
  FakeLoop loop(camera);
  loop.mode = app::Mode::acquire;
  const ReplayOutcome outcome = run(camera, loop);
  CHECK_EQUAL(0, exit_status_of(outcome));
  CHECK_EQUAL(3U, outcome.poses);
}

TEST(Replay, InterruptedStuckAndRefusedRunsEnd) {
  {
    ReplayCamera camera = camera_over(images(5));
    FakeLoop loop(camera);
    const ReplayOutcome outcome = run(camera, loop, 2);
    CHECK(outcome.end == ReplayOutcome::End::interrupted);
    CHECK_EQUAL(1, exit_status_of(outcome));
    CHECK_EQUAL(2U, read_trajectory(scratch.path("out/trajectory.tum")).size());
  }
  {
    ReplayCamera camera = camera_over(images(2));
    FakeLoop loop(camera);
    loop.takes_frames = false;
    const ReplayOutcome outcome = run(camera, loop);
    CHECK(outcome.end == ReplayOutcome::End::stuck);
    CHECK_EQUAL(1, exit_status_of(outcome));
  }
  ReplayCamera camera = camera_over(images(2));
  FakeLoop loop(camera);
  loop.start_answer = Status::not_configured;
  CHECK_EQUAL(1, exit_status_of(run(camera, loop)));
}

TEST(Replay, SummaryAndReportHoldTheRun) {
  ReplayCamera camera = camera_over(images(30));
  FakeLoop loop(camera);
  const ReplayOutcome outcome = run(camera, loop);
  Trajectory truth;
  for (const FrameRecord& r : history.frames) truth.push_back({r.state.time, r.state.t_CT * 2.0, r.state.R_CT});
  const auto evaluation = evaluate_run(history, truth, AlignMode::start);
  CHECK(evaluation.has_value());
  DOUBLES_EQUAL(2.0, evaluation->body_point->scale, 1e-9);
  RunDescription description;
  description.dataset = "a</script>b";
  description.frames_listed = 30;
  const auto summary = nlohmann::json::parse(summary_json(description, outcome, history, &*evaluation));
  CHECK_EQUAL(30, summary["poses"].get<int>());
  DOUBLES_EQUAL(2500.0, summary["step_us"]["median"].get<double>(), 1e-9);
  const std::string html = report_html(description, outcome, history, &*evaluation, &truth);
  CHECK(html.find("a</script>b") == std::string::npos);
  CHECK(html.find("src=\"http") == std::string::npos);  // nothing comes from a network
  CHECK(html.find("href=\"http") == std::string::npos);
  const std::string begin = "<script id=\"data\" type=\"application/json\">";
  const std::size_t at = html.find(begin) + begin.size();
  const auto data = nlohmann::json::parse(html.substr(at, html.find("</script>", at) - at));
  CHECK(data["summary"]["dataset"] == "a</script>b");
  CHECK_EQUAL(30U, data["estimate"]["t"].size());
  CHECK_EQUAL(12U, data["snapshots"].size());
  DOUBLES_EQUAL(0.0, data["truth"]["attitude_error"][1][17].get<double>(), 1e-6);
}

TEST(Replay, ReportOfARunWithoutPosesIsComplete) {
  ReplayCamera camera = camera_over(images(2));
  FakeLoop loop(camera);
  loop.mode = app::Mode::acquire;
  loop.finds_target = false;
  const ReplayOutcome outcome = run(camera, loop);
  const Trajectory truth{{Time{100'000'000}, Vec3(0, 0, 1), Mat3::Identity()}};
  CHECK(!evaluate_run(history, truth, AlignMode::start).has_value());
  CHECK(report_html({}, outcome, history, nullptr, &truth).find("</html>") != std::string::npos);
  CHECK(report_html({}, {}, {}, nullptr, nullptr).find("</html>") != std::string::npos);
}

TEST_GROUP(RunFolder) { Scratch scratch; };

TEST(RunFolder, IsCreatedWithItsParents) {
  static_cast<void>(prepare_run_folder(scratch.path("a/b/c"), false));
  CHECK(std::filesystem::is_directory(scratch.path("a/b/c")));
  static_cast<void>(prepare_run_folder(scratch.path("a/b/c"), false));  // empty: fine
}

TEST(RunFolder, NonEmptyIsRefusedWithoutForce) {
  scratch.write("out/keep.txt", "mine");
  scratch.write("out/trajectory.tum", "old");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(prepare_run_folder(scratch.path("out"), false)); }),
                      "out: is not empty (expected a new or empty folder, or --force)");
  CHECK(std::filesystem::exists(scratch.path("out/trajectory.tum")));
  static_cast<void>(prepare_run_folder(scratch.path("out"), true));
  CHECK(std::filesystem::exists(scratch.path("out/keep.txt")));  // not ours to remove
  CHECK(!std::filesystem::exists(scratch.path("out/trajectory.tum")));
}

TEST(RunFolder, FileInItsPlaceIsNamed) {
  scratch.write("out", "x");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(prepare_run_folder(scratch.path("out"), true)); }),
                      "out: is a file");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(prepare_run_folder(scratch.path("out/deeper"), true)); }),
                      "cannot be created");
}

TEST(RunFolder, FullDiskIsNamed) {
  OutputFile full("/dev/full");
  CHECK_MESSAGE_HOLDS(message_of([&] { full.line("x"); }), "/dev/full: cannot be written: No space left on device");
}

TEST_GROUP(Base64){};

TEST(Base64, MatchesTheTestVectorsOfTheRfc) {
  const auto of = [](const std::string& text) {
    return base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  STRCMP_EQUAL("", of("").c_str());
  STRCMP_EQUAL("Zg==", of("f").c_str());
  STRCMP_EQUAL("Zm8=", of("fo").c_str());
  STRCMP_EQUAL("Zm9v", of("foo").c_str());
  STRCMP_EQUAL("Zm9vYmFy", of("foobar").c_str());
}
