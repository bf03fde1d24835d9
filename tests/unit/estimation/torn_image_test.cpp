// Which images count as put together from two frames.
#include "fsw/estimation/torn_image.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {

TEST_GROUP(TornImage) {
  static constexpr double sigma_px = 0.1;
  ExpectedMarkers before;
  ExpectedMarkers now;
  RigSpots spots;
  SpotAssignment found;
  TearSettings settings;
  Tear tear;

  /// A marker that moved by `moved_px` to (100, v_px), and its spot, off by `off_px` from where it should be now.
  void add(double v_px, const Vec2& moved_px, const Vec2& off_px, std::uint16_t camera = 0) {
    ExpectedMarker m;
    m.feature = static_cast<std::uint16_t>(now.size());
    m.camera = camera;
    m.S_px2 = 0.01 * Mat2::Identity();
    m.uv_px = Vec2(100.0, v_px) - moved_px;
    CHECK(before.push_back(m) == Status::ok);
    m.uv_px = Vec2(100.0, v_px);
    PoseObservation o;
    o.feature = m.feature;
    o.camera = camera;
    o.uv_px = m.uv_px + off_px;
    o.sigma_px = sigma_px;
    CHECK(found.marker.push_back(static_cast<std::uint16_t>(now.size())) == Status::ok);
    CHECK(now.push_back(m) == Status::ok);
    CHECK(found.observations.push_back(o) == Status::ok);
    LightSpot spot;
    spot.uv_px = o.uv_px;
    spot.sigma_px = sigma_px;
    CHECK(spots[camera].push_back(spot) == Status::ok);
    CHECK(found.flux.push_back(v_px) == Status::ok);
  }
  const Vec2 motion_px{4.0, -1.0};
  void add_late(double v_px, std::uint16_t camera = 0) {
    add(v_px, motion_px, Vec2(-motion_px + Vec2(0.1, 0.1)), camera);
  }
  void add_fresh(double v_px, std::uint16_t camera = 0) { add(v_px, motion_px, Vec2(-0.1, 0.1), camera); }
  bool find(std::uint16_t camera = 0) const {
    Tear unused;
    return find_tear(before, now, spots[camera], camera, settings, unused);
  }
};

TEST(TornImage, rows_below_a_line_that_show_the_frame_before_are_found_and_left_out) {
  for (const double v : {300.0, 50.0, 210.0}) add_late(v + 200.0);
  for (const double v : {100.0, 200.0}) add_fresh(v);
  CHECK_TRUE(find_tear(before, now, spots[0], 0, settings, tear));
  CHECK_TRUE(tear.late_below);
  LONGS_EQUAL(3, tear.late);
  LONGS_EQUAL(2, tear.fresh);
  DOUBLES_EQUAL(225.6, tear.row_px, 0.06);  // between 200.1 and 251.1
  drop_late_side(tear, found);
  LONGS_EQUAL(2, found.observations.size());
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK_TRUE(found.observations[i].uv_px(1) < 201.0);
    LONGS_EQUAL(found.observations[i].feature, found.marker[i]);
    DOUBLES_EQUAL(now[found.marker[i]].uv_px(1), found.flux[i], 0.0);
  }
}

TEST(TornImage, the_old_part_may_be_above) {
  add_late(10.0);
  add_late(20.0);
  add_fresh(30.0);
  CHECK_TRUE(find_tear(before, now, spots[0], 0, settings, tear));
  CHECK_FALSE(tear.late_below);
  drop_late_side(tear, found);
  LONGS_EQUAL(1, found.observations.size());
  LONGS_EQUAL(2, found.observations[0].feature);
}

TEST(TornImage, one_old_spot_is_an_outlier_and_no_tear) {
  add_fresh(10.0);
  add_fresh(20.0);
  add_late(30.0);
  CHECK_FALSE(find());
}

TEST(TornImage, old_and_new_spots_mixed_are_no_tear) {
  add_fresh(10.0);
  add_late(20.0);
  add_fresh(30.0);
  add_late(40.0);
  CHECK_FALSE(find());
}

TEST(TornImage, all_old_is_a_late_frame_or_a_target_that_stopped) {
  for (int i = 0; i < 6; ++i) add_late(10.0 * i);
  CHECK_FALSE(find());
}

TEST(TornImage, without_motion_nothing_tells_two_moments_apart) {
  add(10.0, Vec2(0.2, 0.1), Vec2(0.0, 0.0));
  for (int i = 2; i < 6; ++i) add(10.0 * i, Vec2(0.2, 0.1), Vec2(-0.2, -0.1));
  CHECK_FALSE(find());
}

TEST(TornImage, spots_that_are_at_neither_place_say_nothing) {
  add_fresh(10.0);
  add(25.0, motion_px, Vec2(3.0, 3.0));
  add_late(30.0);
  add(35.0, motion_px, Vec2(-3.0, 3.0));
  add_late(40.0);
  CHECK_TRUE(find());
}

TEST(TornImage, a_loose_prediction_holds_both_places_and_the_nearer_one_counts) {
  add_fresh(10.0);
  add_fresh(20.0);
  add_late(30.0);
  add_late(40.0);
  for (ExpectedMarker& m : now) m.S_px2 = 25.0 * Mat2::Identity();
  CHECK_TRUE(find_tear(before, now, spots[0], 0, settings, tear));
  LONGS_EQUAL(2, tear.fresh);
}

TEST(TornImage, motion_too_small_for_a_spot_shows_in_what_a_pose_leaves_out) {
  // 0.8 px, less than eight sigma of the difference; the pose has gone by the late side, or by the fresh one.
  const Vec2 little(0.7, -0.4);
  for (int i = 0; i < 3; ++i) add(10.0 * i, little, Vec2(0.05, 0.0));
  for (int i = 5; i < 8; ++i) add(10.0 * i, little, Vec2(-little + Vec2(0.0, 0.05)));
  CHECK_FALSE(find());
  for (const bool late_used : {true, false}) {
    ObservationMask used{};
    for (std::size_t i = 0; i < 6; ++i) used[i] = (i >= 3) == late_used;
    CHECK_TRUE(find_tear_by_outliers(before, now, found, used, 0, settings, tear));
    CHECK_TRUE(tear.late_below);
    LONGS_EQUAL(3, tear.late);
    DOUBLES_EQUAL(35.2, tear.row_px, 0.1);
  }
  ObservationMask all_but_one{};
  for (std::size_t i = 0; i < 5; ++i) all_but_one[i] = true;
  CHECK_FALSE(find_tear_by_outliers(before, now, found, all_but_one, 0, settings, tear));
}

TEST(TornImage, outliers_that_are_nowhere_are_no_tear) {
  for (int i = 0; i < 4; ++i) add(10.0 * i, motion_px, Vec2(0.05, 0.0));
  for (int i = 5; i < 7; ++i) add(10.0 * i, motion_px, Vec2(3.0, 2.0));
  ObservationMask used{};
  for (std::size_t i = 0; i < 4; ++i) used[i] = true;
  CHECK_FALSE(find_tear_by_outliers(before, now, found, used, 0, settings, tear));
}

TEST(TornImage, of_a_target_at_rest_nothing_can_be_late) {
  for (int i = 0; i < 6; ++i) add(10.0 * i, Vec2(0.0, 0.0), Vec2(0.05, 0.0));
  ObservationMask used{};
  for (std::size_t i = 0; i < 3; ++i) used[i] = true;
  CHECK_FALSE(find_tear_by_outliers(before, now, found, used, 0, settings, tear));
}

TEST(TornImage, a_marker_with_spots_at_both_places_says_nothing) {
  add_fresh(10.0);
  add_late(20.0);
  add_late(30.0);
  CHECK_TRUE(find());
  LightSpot glint;
  glint.uv_px = now[2].uv_px;
  glint.sigma_px = sigma_px;
  CHECK(spots[0].push_back(glint) == Status::ok);
  CHECK_FALSE(find());
}

TEST(TornImage, a_marker_out_of_sight_says_nothing) {
  add_fresh(10.0);
  add_late(20.0);
  add_late(30.0);
  now[2].in_sight = false;
  CHECK_FALSE(find());
}

TEST(TornImage, each_camera_is_judged_by_itself) {
  add_fresh(10.0, 0);
  add_fresh(20.0, 0);
  add_late(300.0, 1);
  add_late(400.0, 1);
  CHECK_FALSE(find(0));
  CHECK_FALSE(find(1));
  add_fresh(200.0, 1);
  CHECK_FALSE(find(0));
  CHECK_TRUE(find_tear(before, now, spots[1], 1, settings, tear));
  LONGS_EQUAL(1, tear.camera);
  drop_late_side(tear, found);
  LONGS_EQUAL(3, found.observations.size());
}

}  // namespace relnav
