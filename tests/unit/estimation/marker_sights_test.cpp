// Which markers are in sight.
#include "fsw/estimation/marker_sights.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
TEST_GROUP(MarkerSights) {
  MarkerSights sights;
  ExpectedMarkers expected;
  SpotAssignment agreed;

  void setup() override {
    for (std::uint16_t k = 0; k < 3; ++k) expect(k, 0);
  }
  void expect(std::uint16_t feature, std::uint16_t camera) {
    ExpectedMarker m;
    m.feature = feature;
    m.camera = camera;
    CHECK(expected.push_back(m) == Status::ok);
  }
  /// A frame in which these of the expected markers have a spot.
  void frame(std::initializer_list<std::uint16_t> with_spot, double flux = 1.0) {
    agreed.observations.clear();
    agreed.marker.clear();
    agreed.flux.clear();
    for (const std::uint16_t k : with_spot) {
      CHECK(agreed.observations.push_back(PoseObservation{}) == Status::ok);
      CHECK(agreed.marker.push_back(k) == Status::ok);
      CHECK(agreed.flux.push_back(flux) == Status::ok);
    }
    sights.record(0, expected, agreed);
  }
  bool is_in_sight(std::size_t k) {
    sights.mark(expected);
    return expected[k].in_sight;
  }
  void begin_with_first_two() {
    PoseObservations observations;
    for (std::uint16_t feature = 0; feature < 2; ++feature) {
      PoseObservation o;
      o.feature = feature;
      CHECK(observations.push_back(o) == Status::ok);
    }
    sights.begin(observations);
  }
};

TEST(MarkerSights, those_of_the_acquisition_are_in_sight) {
  begin_with_first_two();
  CHECK(is_in_sight(0));
  CHECK(is_in_sight(1));
  CHECK(!is_in_sight(2));
  expect(0, 1);
  CHECK(!is_in_sight(3));  // in the other camera
  sights.restart();
  CHECK(!is_in_sight(0));
}

TEST(MarkerSights, a_new_one_counts_after_three_frames_in_a_row) {
  begin_with_first_two();
  frame({2});
  frame({2});
  CHECK(!is_in_sight(2));
  frame({2});
  CHECK(is_in_sight(2));
}

TEST(MarkerSights, a_glint_now_and_then_never_counts) {
  begin_with_first_two();
  for (int k = 0; k < 20; ++k) {
    frame({2});
    CHECK(!is_in_sight(2));
    frame({});
    CHECK(!is_in_sight(2));
  }
}

TEST(MarkerSights, one_missed_frame_is_forgiven_to_a_long_sight_two_are_not) {
  begin_with_first_two();
  frame({0});
  CHECK(is_in_sight(0));
  CHECK(is_in_sight(1));
  frame({0});
  CHECK(is_in_sight(0));
  CHECK(!is_in_sight(1));
}

TEST(MarkerSights, what_is_not_expected_is_out_of_sight) {
  begin_with_first_two();
  expected.pop_back();
  expected.pop_back();
  frame({0});  // 1 has turned away
  expect(1, 0);
  CHECK(is_in_sight(0));
  CHECK(!is_in_sight(1));
}

TEST(MarkerSights, a_camera_without_an_image_forgets_nothing) {
  begin_with_first_two();
  for (int k = 0; k < 5; ++k) sights.record(1, {}, {});
  CHECK(is_in_sight(0));
  CHECK(is_in_sight(1));
}

TEST(MarkerSights, the_brightness_is_that_of_the_latest_sight) {
  begin_with_first_two();
  frame({0}, 5.0);
  frame({1}, 7.0);
  sights.mark(expected);
  DOUBLES_EQUAL(5.0, expected[0].flux, 0.0);
  DOUBLES_EQUAL(7.0, expected[1].flux, 0.0);
  DOUBLES_EQUAL(0.0, expected[2].flux, 0.0);
}

}  // namespace relnav
