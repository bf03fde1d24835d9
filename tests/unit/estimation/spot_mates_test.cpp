#include "fsw/estimation/spot_mates.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "tests/unit/estimation/spot_simulation.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using namespace test;

/// Two cameras that look at eight lights.
struct Stage {
  CameraRig rig = two_cameras();
  TargetModel target = eight_leds();
  RigSpots spots;
  std::array<SpotField, config::max_cameras> fields;
  SpotSearchSettings settings;
  AttitudePrior prior;
  Pose truth;
  SpotMates mates;

  /// Spots of these markers, in their order, without noise.
  void see(std::initializer_list<std::size_t> markers) {
    for (std::size_t c = 0; c < rig.size(); ++c) {
      spots[c].clear();
      const Pose pose_K = in_camera(rig[c], truth);
      for (const std::size_t m : markers) {
        LightSpot spot;
        spot.sigma_px = 0.05;
        CHECK(rig[c].model.project(pose_K.R_CT * target.features[m].p_T + pose_K.t_CT, spot.uv_px) == Status::ok);
        CHECK(spots[c].push_back(spot) == Status::ok);
      }
    }
  }
  void build() {
    for (std::size_t c = 0; c < rig.size(); ++c) fields[c].build(rig[c].model, spots[c], settings.gate_px);
    mates.build({rig, target, spots, fields, settings, prior, -2.0});
  }
  [[nodiscard]] bool is_mated(std::size_t spot) const { return (mates.mated() >> spot & 1U) != 0; }
  /// The spot of a marker in the first camera; -1: none within 2 px.
  [[nodiscard]] int spot_of(std::size_t marker, std::size_t camera = 0) const {
    const Pose pose_K = in_camera(rig[camera], truth);
    Vec2 uv;
    if (rig[camera].model.project(pose_K.R_CT * target.features[marker].p_T + pose_K.t_CT, uv) != Status::ok) return -1;
    int best = -1;
    double least = 2.0;
    for (std::size_t s = 0; s < spots[camera].size(); ++s) {
      const double d = (spots[camera][s].uv_px - uv).norm();
      if (d < least) {
        least = d;
        best = static_cast<int>(s);
      }
    }
    return best;
  }
};

Stage stage;

}  // namespace

TEST_GROUP(SpotMates){void setup() override{stage = Stage();
}  // namespace relnav
}
;

TEST(SpotMates, lights_seen_by_both_have_mates_that_bound_their_distances) {
  SpotSimulation simulation(401);
  SpotScenario s;
  s.noise_px = 0.1;
  s.clutter = 10;
  int pairs = 0, outside = 0;
  double widest = 0.0;
  for (int k = 0; k < 60; ++k) {
    stage.truth = simulation.pose(s);
    stage.spots = simulation.spots(stage.rig, stage.target, stage.truth, s);
    stage.build();
    for (std::size_t i = 0; i < 8; ++i) {
      const int a = stage.spot_of(i);
      if (a < 0 || stage.spot_of(i, 1) < 0) continue;
      CHECK(stage.is_mated(static_cast<std::size_t>(a)));
      for (std::size_t j = 0; j < i; ++j) {
        const int b = stage.spot_of(j);
        if (b < 0 || stage.spot_of(j, 1) < 0) continue;
        const SpotMates::Span span = stage.mates.distance(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
        const double true2 = (stage.target.features[i].p_T - stage.target.features[j].p_T).squaredNorm();
        ++pairs;
        if (!(span.least2 <= true2 && true2 <= span.most2)) ++outside;
        const SpotMates::Span back = stage.mates.distance(static_cast<std::size_t>(b), static_cast<std::size_t>(a));
        DOUBLES_EQUAL(span.least2, back.least2, 1e-9);
        DOUBLES_EQUAL(span.most2, back.most2, 1e-9);
        if (stage.truth.t_CT.norm() < 5.0) widest = std::max(widest, std::sqrt(span.most2) - std::sqrt(span.least2));
      }
    }
  }
  CHECK_TRUE_TEXT(pairs > 1000, StringFromFormat("%d", pairs).asCharString());
  // Of markers whose own mate had no room among four, or is taken for another's.
  CHECK_TRUE_TEXT(outside * 200 <= pairs, StringFromFormat("%d of %d", outside, pairs).asCharString());
  CHECK(widest > 0.0);
}

TEST(SpotMates, two_near_lights_are_known_to_lie_a_decimetre_more_or_less_apart) {
  stage.truth = {Mat3::Identity(), Vec3(0.2, -0.1, 4.0)};
  stage.see({0, 2});
  stage.build();
  const SpotMates::Span span = stage.mates.distance(0, 1);
  const double length = (stage.target.features[0].p_T - stage.target.features[2].p_T).norm();
  CHECK(std::sqrt(span.least2) > length - 0.1);
  CHECK(std::sqrt(span.least2) < length);
  CHECK(std::sqrt(span.most2) < length + 0.1);
  CHECK(std::sqrt(span.most2) > length);
}

TEST(SpotMates, what_lies_off_the_epipolar_line_or_out_of_range_is_no_mate) {
  stage.truth = {Mat3::Identity(), Vec3(0.0, 0.0, 6.0)};
  stage.see({0});
  stage.build();
  CHECK(stage.is_mated(0));
  stage.settings.range_max_m = 3.0;  // and a metre of target
  stage.build();
  LONGS_EQUAL(0, stage.mates.mated());
  stage.settings.range_max_m = 100.0;
  stage.settings.range_min_m = 8.0;
  stage.build();
  LONGS_EQUAL(0, stage.mates.mated());
  stage.settings.range_min_m = 1.0;
  stage.spots[1][0].uv_px.y() += 3.0;
  stage.build();
  LONGS_EQUAL(0, stage.mates.mated());
}

TEST(SpotMates, more_mates_than_there_is_room_for_are_no_fault) {
  stage.truth = {Mat3::Identity(), Vec3(0.0, 0.0, 6.0)};
  stage.see({0});
  for (int k = 1; k < 7; ++k) {
    LightSpot near = stage.spots[1][0];
    near.uv_px.x() += 0.1 * k;
    CHECK(stage.spots[1].push_back(near) == Status::ok);
  }
  stage.build();
  CHECK(stage.is_mated(0));
}

}  // namespace relnav
