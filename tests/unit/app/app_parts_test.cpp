#include <cmath>
#include <memory>

#include "fsw/app/event_log.hpp"
#include "fsw/app/filter_watch.hpp"
#include "fsw/app/mode_table.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

using namespace relnav;
using app::FilterWatch;
using app::Mode;

TEST_GROUP(ModeTable){};

TEST(ModeTable, HoldsExactlyTheseWays) {
  const Mode modes[] = {Mode::standby, Mode::acquire, Mode::track, Mode::lost};
  // rows: from, columns: to
  const bool allowed[4][4] = {
      {false, true, false, false}, {true, false, true, true}, {true, false, false, true}, {true, true, false, false}};
  for (int from = 0; from < 4; ++from) {
    for (int to = 0; to < 4; ++to) CHECK_EQUAL(allowed[from][to], app::is_allowed(modes[from], modes[to]));
  }
}

TEST_GROUP(EventLog) {
  app::EventLog log;
  telemetry::EventPacket packet;
};

TEST(EventLog, SpacesReportsOfOneKindAndCountsTheRest) {
  using telemetry::EventId;
  log.configure(5);
  for (std::uint32_t frame = 10; frame < 20; ++frame) {
    CHECK_EQUAL(frame % 5 == 0, log.note(EventId::frame_gap, frame, packet));
  }
  LONGS_EQUAL(6, packet.occurrence);
  LONGS_EQUAL(4, packet.suppressed);
  CHECK_TRUE(log.note(EventId::camera_lost, 20, packet));  // another kind is not held back
  CHECK_TRUE(log.note(EventId::mode_changed, 20, packet));
  CHECK_TRUE(log.note(EventId::mode_changed, 20, packet));  // nor is any change of mode
  LONGS_EQUAL(13, log.count());
  LONGS_EQUAL(8, log.suppressed());
}

TEST_GROUP(FilterWatch) {
  std::unique_ptr<FilterState> state = std::make_unique<FilterState>();
  RelativeState output;
  FilterWatch watch;
  Mat12 P = Mat12::Identity();

  void setup() override {
    state->reset(MotionState(), P);
    watch.configure({.max_refused_in_a_row = 3, .max_test_ratio = 5.0, .max_test_ratio_frames = 4});
  }
  Status judge(const app::UpdateSummary& update = {}) {
    return watch.judge(app::check_variances(*state), output, update);
  }
};

TEST(FilterWatch, BelievesASoundFilter) {
  for (int i = 0; i < 100; ++i) CHECK_TRUE(judge({Status::ok, 1.0, false}) == Status::ok);
}

TEST(FilterWatch, AcceptsVariancesThatAreZeroByDefinition) {
  P(3, 3) = 0.0;
  P(4, 4) = -1e-20;
  state->reset(MotionState(), P);
  CHECK_TRUE(judge() == Status::ok);
}

TEST(FilterWatch, FindsANegativeVariance) {
  P(7, 7) = -1e-6;
  state->reset(MotionState(), P);
  CHECK_TRUE(judge() == Status::not_positive_definite);
}

TEST(FilterWatch, FindsNumbersThatAreNotFinite) {
  P(11, 11) = std::nan("");
  state->reset(MotionState(), P);
  CHECK_TRUE(judge() == Status::not_finite);
  state->reset(MotionState(), Mat12::Identity());
  output.t_CT.y() = HUGE_VAL;
  CHECK_TRUE(judge() == Status::not_finite);
  output = RelativeState();
  output.rate_covariance(2, 3) = std::nan("");
  CHECK_TRUE(judge() == Status::not_finite);
}

TEST(FilterWatch, CountsRefusedUpdatesInARow) {
  for (int round = 0; round < 3; ++round) {
    CHECK_TRUE(judge({Status::not_positive_definite, 0.0, false}) == Status::ok);
    CHECK_TRUE(judge({Status::not_positive_definite, 0.0, false}) == Status::ok);
    CHECK_TRUE(judge() == Status::ok);
  }
  for (int i = 0; i < 2; ++i) CHECK_TRUE(judge({Status::not_finite, 0.0, false}) == Status::ok);
  CHECK_TRUE(judge({Status::not_finite, 0.0, false}) == Status::not_positive_definite);
}

TEST(FilterWatch, DoesNotBearHighTestRatiosForLong) {
  for (int i = 0; i < 20; ++i) CHECK_TRUE(judge({Status::ok, 100.0, true}) == Status::ok);  // start adjustment
  for (int i = 0; i < 3; ++i) CHECK_TRUE(judge({Status::ok, 5.1, false}) == Status::ok);
  CHECK_TRUE(judge({Status::ok, 4.9, false}) == Status::ok);
  for (int i = 0; i < 3; ++i) CHECK_TRUE(judge({Status::ok, 5.1, false}) == Status::ok);
  CHECK_TRUE(judge({Status::ok, std::nan(""), false}) == Status::no_convergence);
}
