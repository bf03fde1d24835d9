#include "fsw/vision/fast_corners.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "tests/unit/vision/corner_list.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::corners_of;
using test::facets;
using test::OwnedImage;

/// Longest run of circle pixels brighter (sign 1) or darker (sign -1) than the centre by more than the threshold.
bool is_corner(const ImageView& image, int u, int v, int threshold) {
  constexpr std::array<std::array<int, 2>, 16> circle{{{0, -3},
                                                       {1, -3},
                                                       {2, -2},
                                                       {3, -1},
                                                       {3, 0},
                                                       {3, 1},
                                                       {2, 2},
                                                       {1, 3},
                                                       {0, 3},
                                                       {-1, 3},
                                                       {-2, 2},
                                                       {-3, 1},
                                                       {-3, 0},
                                                       {-3, -1},
                                                       {-2, -2},
                                                       {-1, -3}}};
  for (const int sign : {1, -1}) {
    int run = 0;
    for (std::size_t i = 0; i < 16 + 8; ++i) {
      const int difference = *image.at(u + circle[i % 16][0], v + circle[i % 16][1]) - *image.at(u, v);
      run = sign * difference > threshold ? run + 1 : 0;
      if (run == 9) return true;
    }
  }
  return false;
}

}  // namespace

TEST_GROUP(FastCorners){};

TEST(FastCorners, score_is_the_largest_threshold_that_keeps_the_corner) {
  const OwnedImage image = facets(90, 70, 3);
  FastOptions options;
  options.threshold = 8;
  options.suppress_non_maxima = false;
  const std::vector<FastCorner> corners = corners_of(image, options);
  CHECK(corners.size() > 100);
  for (const FastCorner& corner : corners) {
    CHECK(is_corner(image.view(), corner.u_px, corner.v_px, corner.score));
    CHECK_FALSE(is_corner(image.view(), corner.u_px, corner.v_px, corner.score + 1));
  }
}

TEST(FastCorners, region_holds_the_corners_whose_centre_is_in_it) {
  const OwnedImage image = facets(200, 150, 5);
  FastOptions options;
  options.suppress_non_maxima = false;
  const std::vector<FastCorner> all = corners_of(image, options);
  for (const PixelRegion& region :
       {PixelRegion{10, 20, 131, 97}, PixelRegion{50, 0, 61, 400}, PixelRegion{-5, 30, 30, 31},
        PixelRegion{184, 140, 500, 500}, PixelRegion{60, 60, 60, 90}}) {
    options.region = region;
    std::vector<FastCorner> expected;
    for (const FastCorner& c : all) {
      if (c.u_px >= region.u0_px && c.u_px < region.u1_px && c.v_px >= region.v0_px && c.v_px < region.v1_px) {
        expected.push_back(c);
      }
    }
    CHECK(expected == corners_of(image, options));
  }
}

TEST(FastCorners, without_room_the_strongest_are_kept_in_raster_order) {
  const OwnedImage image = facets(200, 150, 6);
  FastOptions options;
  const std::vector<FastCorner> all = corners_of(image, options);
  CHECK(all.size() > 100);
  for (const std::size_t room : {std::size_t{0}, std::size_t{1}, all.size() / 3, all.size() - 1, all.size()}) {
    std::vector<FastCorner> strongest = all;
    std::sort(strongest.begin(), strongest.end(), [](const FastCorner& a, const FastCorner& b) {
      return std::tuple(b.score, a.v_px, a.u_px) < std::tuple(a.score, b.v_px, b.u_px);
    });
    strongest.resize(room);
    std::vector<FastCorner> corners(room);
    const FastResult result = detect_fast(image.view(), options, corners);
    CHECK(result.status == (room < all.size() ? Status::no_capacity : Status::ok));
    CHECK_EQUAL(room, result.count);
    CHECK_EQUAL(all.size(), result.found);
    std::vector<FastCorner> expected;
    for (const FastCorner& c : all) {
      if (std::find(strongest.begin(), strongest.end(), c) != strongest.end()) expected.push_back(c);
    }
    CHECK(expected == corners);
  }
}

TEST(FastCorners, flat_images_have_none_and_one_dot_is_one) {
  for (const int level : {0, 128, 255}) {
    OwnedImage image(64, 64, 0, static_cast<std::uint8_t>(level));
    CHECK(corners_of(image, {}).empty());
    image.at(31, 17) = level < 100 ? 255 : 0;
    const int contrast = level < 100 ? 255 : level;
    const std::vector<FastCorner> corners = corners_of(image, {});
    CHECK_EQUAL(std::size_t{1}, corners.size());
    CHECK((corners[0] == FastCorner{31, 17, static_cast<std::uint8_t>(contrast - 1)}));
  }
}

TEST(FastCorners, images_too_small_have_none_and_unusable_ones_are_refused) {
  for (const int side : {1, 6}) CHECK(corners_of(facets(side, side, 1), {}).empty());
  std::vector<FastCorner> corners(4);
  const OwnedImage image(64, 64);
  for (const ImageView& bad :
       {ImageView{}, ImageView{image.view().pixels, 64, 64, 63}, ImageView{image.view().pixels, 0, 64, 64},
        ImageView{image.view().pixels, static_cast<int>(config::max_image_width) + 1, 1, 5000}}) {
    CHECK(detect_fast(bad, {}, corners).status == Status::invalid_argument);
  }
}

}  // namespace relnav::vision
