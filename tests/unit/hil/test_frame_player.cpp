#include <algorithm>
#include <chrono>
#include <thread>

#include "hil/serve/frame_player.hpp"
#include "platform/files/input_error.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using namespace relnav;
using namespace relnav::hil;

namespace {

constexpr std::int64_t player_step_ns = 10'000'000;

/// 4 x 4 pixels, all of frame k are 10 + k; a frame every 10 ms.
class PlainSource final : public FrameSource {
 public:
  explicit PlainSource(std::size_t count) : count_(count) {}
  [[nodiscard]] std::size_t count() const override { return count_; }
  [[nodiscard]] FrameShape shape() const override { return {4, 4, 1}; }
  [[nodiscard]] Time stamp(std::size_t index) const override {
    return {1000 + static_cast<std::int64_t>(index) * player_step_ns};
  }
  std::shared_ptr<const Image> image(std::size_t index) override {
    return std::make_shared<const Image>(
        Image{4, 4, 1, std::vector<std::uint8_t>(16, static_cast<std::uint8_t>(10 + index))});
  }

 private:
  std::size_t count_;
};

struct Written {
  std::uint64_t number;
  Time stamp;
  std::uint8_t first;
  std::uint8_t last;
  bool lost;
  std::uint32_t packets_lost_per_mille;
  std::chrono::steady_clock::time_point when;
};

class RecordingSink final : public FrameSink {
 public:
  void plug(const FrameShape& shape) override {
    CHECK_EQUAL(4, shape.width_px);
    plugged = true;
    ++plugs;
  }
  void unplug() override {
    plugged = false;
    unplugged_at.push_back(frames.size());
  }
  bool write(const ServedFrame& frame, Duration) override {
    CHECK_TRUE(plugged);
    if (refusals > 0) {
      --refusals;
      return false;
    }
    frames.push_back({frame.number, frame.stamp, frame.image->bytes.front(), frame.image->bytes.back(), frame.lost,
                      frame.packets_lost_per_mille, std::chrono::steady_clock::now()});
    return true;
  }
  std::vector<Written> frames;
  std::vector<std::size_t> unplugged_at;
  bool plugged = false;
  int plugs = 0;
  int refusals = 0;
};

void check_refused(const char* text, const char* part) {
  try {
    static_cast<void>(parse_fault(text));
  } catch (const InputError& error) {
    if (std::string(error.what()).find(part) == std::string::npos) FAIL(error.what());
    return;
  }
  FAIL(text);
}

}  // namespace

TEST_GROUP(FramePlayer) {
  PlainSource source{8};
  RecordingSink sink;

  PlayedFrames play(std::vector<Fault> faults, double speed = 0.0) {
    PlayerSettings settings;
    settings.speed = speed;
    settings.faults = std::move(faults);
    return FramePlayer(source, settings).play(sink, [] { return false; });
  }
};

TEST(FramePlayer, LockStepHandsOutEveryFrameWithItsStamp) {
  sink.refusals = 3;
  const PlayedFrames played = play({});
  CHECK_EQUAL(8, played.sent);
  CHECK_EQUAL(0, played.lost + played.unseen);
  CHECK_EQUAL(8, sink.frames.size());
  for (std::size_t k = 0; k < 8; ++k) {
    CHECK_EQUAL(k, sink.frames[k].number);
    CHECK_TRUE(sink.frames[k].stamp == source.stamp(k));
    CHECK_EQUAL(10 + k, sink.frames[k].first);
    CHECK_FALSE(sink.frames[k].lost);
  }
  CHECK_EQUAL(1, sink.plugs);
  CHECK_FALSE(sink.plugged);
}

TEST(FramePlayer, PaceIsThatOfTheStamps) {
  const PlayedFrames played = play({}, 0.5);
  CHECK_EQUAL(8, played.sent);
  for (std::size_t k = 1; k < 8; ++k) {
    const auto since_first = sink.frames[k].when - sink.frames[0].when;
    CHECK_TRUE(since_first > std::chrono::nanoseconds(2 * player_step_ns) * k - std::chrono::milliseconds(2));
  }
}

TEST(FramePlayer, ASlowDecoderShowsFewerFramesNotNone) {
  class SlowSource final : public FrameSource {
   public:
    [[nodiscard]] std::size_t count() const override { return plain_.count(); }
    [[nodiscard]] FrameShape shape() const override { return plain_.shape(); }
    [[nodiscard]] Time stamp(std::size_t index) const override { return plain_.stamp(index); }
    std::shared_ptr<const Image> image(std::size_t index) override {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return plain_.image(index);
    }

   private:
    PlainSource plain_{1500};
  } slow;
  RecordingSink shown;
  PlayerSettings settings;
  settings.speed = 10.0;  // a frame a millisecond
  const PlayedFrames played = FramePlayer(slow, settings).play(shown, [] { return false; });
  CHECK_TRUE(played.sent + played.unseen == 1500);
  CHECK_TRUE(played.unseen > 500);
  CHECK_TRUE(shown.frames.back().number > 1400);  // up to the end
}

TEST(FramePlayer, LoopsGoOnInTimeAndNumber) {
  PlayerSettings settings;
  settings.speed = 0.0;
  settings.loop = true;
  static_cast<void>(FramePlayer(source, settings).play(sink, [&] { return sink.frames.size() >= 20; }));
  CHECK_EQUAL(20, sink.frames.size());
  for (std::size_t k = 0; k < 20; ++k) {
    CHECK_EQUAL(k, sink.frames[k].number);
    CHECK_EQUAL(1000 + static_cast<std::int64_t>(k) * player_step_ns, sink.frames[k].stamp.ns);
    CHECK_EQUAL(10 + k % 8, sink.frames[k].first);
  }
}

TEST(FramePlayer, FaultsOfImagesHitTheirFramesOnly) {
  static_cast<void>(
      play({parse_fault("frozen@1:2"), parse_fault("torn@4"), parse_fault("black@5"), parse_fault("white@6")}));
  const std::uint8_t first[] = {10, 10, 10, 13, 14, 0, 255, 17};
  const std::uint8_t last[] = {10, 10, 10, 13, 13, 0, 255, 17};
  for (std::size_t k = 0; k < 8; ++k) {
    CHECK_EQUAL(first[k], sink.frames[k].first);
    CHECK_EQUAL(last[k], sink.frames[k].last);
    CHECK_TRUE(sink.frames[k].stamp == source.stamp(k));
  }
}

TEST(FramePlayer, FaultsOfTransportAndTime) {
  const PlayedFrames played =
      play({parse_fault("lost@2:2"), parse_fault("packets@4:2:150"), parse_fault("time_jump@6:-0.5")});
  CHECK_EQUAL(2, played.lost);
  CHECK_EQUAL(6, played.sent);
  for (std::size_t k = 0; k < 8; ++k) {
    CHECK_EQUAL(k == 2 || k == 3, sink.frames[k].lost);
    CHECK_EQUAL(k == 4 || k == 5 ? 150U : 0U, sink.frames[k].packets_lost_per_mille);
    CHECK_EQUAL(source.stamp(k).ns - (k >= 6 ? 500'000'000 : 0), sink.frames[k].stamp.ns);
  }
}

TEST(FramePlayer, AnUnpluggedCameraMissesWhatHappensMeanwhile) {
  const PlayedFrames played = play({parse_fault("unplug@3:25")}, 1.0);
  CHECK_EQUAL(2, sink.plugs);
  CHECK_EQUAL(3, sink.unplugged_at[0]);
  CHECK_TRUE(played.unseen >= 2);
  CHECK_EQUAL(8, played.sent + played.unseen);
  CHECK_EQUAL(3 + played.unseen, sink.frames[3].number);
}

TEST(FramePlayer, UnplugInLockStepMissesNothing) {
  const PlayedFrames played = play({parse_fault("unplug@3:5")});
  CHECK_EQUAL(8, played.sent);
  CHECK_EQUAL(2, sink.plugs);
}

TEST(FramePlayer, WrongFaultsAreSaid) {
  check_refused("lost", "has no @");
  check_refused("burnt@3", "is of no known kind");
  check_refused("lost@x", "begins at no frame");
  check_refused("lost@-1", "begins at no frame");
  check_refused("lost@3:0", "hits no frame");
  check_refused("lost@3:1:5", "has not as many parts as its kind");
  check_refused("time_jump@3", "has not as many parts as its kind");
  check_refused("time_jump@3:nan", "has no usable amount");
  check_refused("unplug@3:0", "takes no time");
  check_refused("packets@3:1:1001", "loses not 1 to 1000 packets in a thousand");
}
