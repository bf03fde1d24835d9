#include "fsw/vision/corner_spread.hpp"

#include <cmath>
#include <vector>

#include "fsw/vision/patch.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::facets;
using test::OwnedImage;

std::vector<FastCorner> corners_of(const OwnedImage& image) {
  std::vector<FastCorner> corners(20000);
  corners.resize(detect_fast(image.view(), {}, corners).count);
  return corners;
}

/// Its definition, in double.
double plain_strength(const ImageView& image, int u0, int v0) {
  double a = 0.0;
  double b = 0.0;
  double c = 0.0;
  for (int v = v0 - window_half_px; v <= v0 + window_half_px; ++v) {
    for (int u = u0 - window_half_px; u <= u0 + window_half_px; ++u) {
      const int left = *image.at(u - 1, v);
      const int right = *image.at(u + 1, v);
      const int above = *image.at(u, v - 1);
      const int below = *image.at(u, v + 1);
      if (std::max({left, right, above, below}) >= saturated_level) continue;
      const double gu = 0.5 * (right - left);
      const double gv = 0.5 * (below - above);
      a += gu * gu;
      b += gu * gv;
      c += gv * gv;
    }
  }
  return 100.0 * (0.5 * (a + c) - std::hypot(0.5 * (a - c), b)) / window_pixels;
}

double distance(const CornerCandidate& a, const Vec2& b) { return std::hypot(a.u_px - b(0), a.v_px - b(1)); }

}  // namespace

TEST_GROUP(CornerSpread) { CornerCandidates candidates; };

TEST(CornerSpread, strength_is_the_minimum_eigenvalue) {
  const OwnedImage image = facets(200, 150, 4, 3);
  for (int v = corner_reach_px; v < 150 - corner_reach_px; v += 7) {
    for (int u = corner_reach_px; u < 200 - corner_reach_px; ++u) {
      const double expected = plain_strength(image.view(), u, v);
      const double actual = corner_strength(image.view(), u, v);
      CHECK(actual <= expected + 0.5);
      CHECK(actual >= expected - 1.5);
    }
  }
}

TEST(CornerSpread, an_edge_is_weak_and_a_corner_strong) {
  OwnedImage edge(64, 64);
  edge.fill([](double u, double) { return u < 32.0 ? 20.0 : 200.0; });
  OwnedImage corner(64, 64);
  corner.fill([](double u, double v) { return u < 32.0 && v < 32.0 ? 20.0 : 200.0; });
  OwnedImage plateau(64, 64);
  plateau.fill([](double u, double v) { return u < 32.0 && v < 32.0 ? 20.0 : 255.0; });
  CHECK_EQUAL(0, corner_strength(edge.view(), 32, 32));
  CHECK(corner_strength(corner.view(), 32, 32) > 10000);
  CHECK_EQUAL(0, corner_strength(plateau.view(), 32, 32));
}

TEST(CornerSpread, candidates_keep_their_distances_and_the_border) {
  const OwnedImage image = facets(320, 240, 6);
  const std::vector<FastCorner> corners = corners_of(image);
  std::vector<Vec2> tracked;
  for (int i = 0; i < 12; ++i) tracked.emplace_back(30.25 + 22.0 * i, 40.5 + 13.0 * i);
  tracked.emplace_back(-50.0, 1e9);
  SpreadOptions options;
  CHECK(select_corners(image.view(), corners, tracked, 40, options, candidates) == Status::ok);
  CHECK(candidates.size() > 20);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const CornerCandidate& c = candidates[i];
    CHECK(image.view().contains(c.u_px, c.v_px, reference_half_px));
    CHECK(c.score >= options.min_score);
    CHECK_EQUAL(corner_strength(image.view(), c.u_px, c.v_px), c.score);
    for (const Vec2& uv : tracked) CHECK(distance(c, uv) >= options.min_distance_px);
    for (std::size_t k = 0; k < i; ++k) {
      CHECK(distance(c, Vec2(candidates[k].u_px, candidates[k].v_px)) >= options.min_distance_px);
    }
  }
}

TEST(CornerSpread, one_rich_corner_of_the_image_does_not_take_all) {
  OwnedImage image = facets(320, 240, 7);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (u > 100 || v > 100) image.at(u, v) = static_cast<std::uint8_t>(image.at(u, v) / 3 + 60);
    }
  }
  CHECK(select_corners(image.view(), corners_of(image), {}, 30, {}, candidates) == Status::ok);
  CHECK_EQUAL(std::size_t{30}, candidates.size());
  int rich = 0;
  for (const CornerCandidate& c : candidates) rich += c.u_px <= 100 && c.v_px <= 100 ? 1 : 0;
  CHECK(rich <= 10);
}

TEST(CornerSpread, cells_with_features_come_last) {
  OwnedImage image(240, 120, 0, 50);
  std::vector<FastCorner> corners;
  for (const int u0 : {50, 65, 130, 190}) {  // the first two share a cell of 40 with a tracked feature
    for (int v = 0; v < 4; ++v) {
      for (int u = 0; u < 4; ++u) image.at(u0 + u, 60 + v) = static_cast<std::uint8_t>(u0 < 100 ? 220 : 150);
    }
    corners.push_back({static_cast<std::uint16_t>(u0 + 1), 61, 90});
  }
  SpreadOptions options;
  options.min_distance_px = 8.0;
  const std::vector<Vec2> tracked{Vec2(58.0, 45.0), Vec2(75.0, 45.0)};
  CHECK(select_corners(image.view(), corners, tracked, 2, options, candidates) == Status::ok);
  CHECK_EQUAL(std::size_t{2}, candidates.size());
  CHECK_EQUAL(131, candidates[0].u_px);
  CHECK_EQUAL(191, candidates[1].u_px);
}

TEST(CornerSpread, overexposed_and_weak_corners_are_left) {
  OwnedImage image(120, 60, 0, 50);
  for (int v = 20; v < 60; ++v) {
    for (int u = 30; u < 60; ++u) image.at(u, v) = 255;
  }
  image.at(90, 30) = 56;
  const std::vector<FastCorner> corners{{30, 20, 200}, {90, 30, 5}};
  CHECK(select_corners(image.view(), corners, {}, 10, {}, candidates) == Status::ok);
  CHECK(candidates.empty());
}

TEST(CornerSpread, the_largest_image_is_covered_to_its_edges) {
  const OwnedImage image =
      facets(static_cast<int>(config::max_image_width), static_cast<int>(config::max_image_height), 8);
  std::vector<FastCorner> corners(400000);
  corners.resize(detect_fast(image.view(), {}, corners).count);
  SpreadOptions options;
  options.cell_px = 16;
  CHECK(select_corners(image.view(), corners, {}, CornerCandidates::capacity(), options, candidates) == Status::ok);
  CHECK_EQUAL(CornerCandidates::capacity(), candidates.size());
  const auto quadrants = [&](int half_u, int half_v) {
    int found = 0;
    for (const CornerCandidate& c : candidates) found |= 1 << ((c.u_px < half_u ? 0 : 1) + (c.v_px < half_v ? 0 : 2));
    return found;
  };
  CHECK_EQUAL(15, quadrants(image.width() / 2, image.height() / 2));
}

TEST(CornerSpread, none_is_wanted_none_is_found_and_bad_arguments_are_refused) {
  const OwnedImage image = facets(320, 240, 6);
  const std::vector<FastCorner> corners = corners_of(image);
  CHECK(select_corners(image.view(), corners, {}, 0, {}, candidates) == Status::ok);
  CHECK(candidates.empty());
  CHECK(select_corners(image.view(), {}, {}, 10, {}, candidates) == Status::ok);
  CHECK(candidates.empty());
  CHECK(select_corners(image.view(), corners, {}, 100000, {}, candidates) == Status::ok);
  CHECK(candidates.size() <= CornerCandidates::capacity());
  SpreadOptions fine;
  fine.cell_px = 4;
  CHECK(select_corners(image.view(), corners, {}, 10, fine, candidates) == Status::invalid_argument);
  CHECK(select_corners(ImageView{}, corners, {}, 10, {}, candidates) == Status::invalid_argument);
}

}  // namespace relnav::vision
