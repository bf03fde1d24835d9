#include "fsw/vision/fast_corners.hpp"

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::facets;
using test::OwnedImage;

std::vector<FastCorner> ours(const OwnedImage& image, const FastOptions& options) {
  std::vector<FastCorner> corners(200000);
  const FastResult result = detect_fast(image.view(), options, corners);
  CHECK(result.status == Status::ok);
  CHECK_EQUAL(result.found, result.count);
  corners.resize(result.count);
  return corners;
}

/// OpenCV keeps memory of its first call, which a test would report as its leak.
const bool opencv_is_warm = [] {
  std::vector<cv::KeyPoint> points;
  cv::FAST(cv::Mat::zeros(16, 16, CV_8UC1), points, 10);
  return true;
}();

std::vector<cv::KeyPoint> opencv(OwnedImage& image, int threshold, bool suppress) {
  CHECK(opencv_is_warm);
  const cv::Mat mat(image.height(), image.width(), CV_8UC1, image.data(),
                    static_cast<std::size_t>(image.view().stride));
  std::vector<cv::KeyPoint> points;
  cv::FAST(mat, points, threshold, suppress, cv::FastFeatureDetector::TYPE_9_16);
  return points;
}

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

TEST(FastCorners, equals_opencv_on_every_size_stride_and_threshold) {
  constexpr std::array<std::array<int, 3>, 12> sizes{{{7, 7, 0},
                                                      {8, 30, 3},
                                                      {21, 21, 0},
                                                      {22, 40, 5},
                                                      {23, 23, 1},
                                                      {37, 41, 0},
                                                      {64, 48, 16},
                                                      {101, 67, 11},
                                                      {255, 33, 0},
                                                      {320, 240, 0},
                                                      {641, 479, 7},
                                                      {1024, 40, 0}}};
  std::size_t seen = 0;
  for (const auto& [width, height, slack] : sizes) {
    OwnedImage image = facets(width, height, static_cast<std::uint64_t>(width), slack);
    for (const int threshold : {0, 1, 5, 20, 60, 150, 254, 255}) {
      for (const bool suppress : {false, true}) {
        FastOptions options;
        options.threshold = static_cast<std::uint8_t>(threshold);
        options.suppress_non_maxima = suppress;
        const std::vector<FastCorner> corners = ours(image, options);
        const std::vector<cv::KeyPoint> expected = opencv(image, threshold, suppress);
        const std::string where =
            std::to_string(width) + "x" + std::to_string(height) + " t " + std::to_string(threshold);
        CHECK_EQUAL_TEXT(expected.size(), corners.size(), where.c_str());
        for (std::size_t i = 0; i < corners.size(); ++i) {
          CHECK_EQUAL_TEXT(std::lround(expected[i].pt.x), corners[i].u_px, where.c_str());
          CHECK_EQUAL_TEXT(std::lround(expected[i].pt.y), corners[i].v_px, where.c_str());
          if (suppress) CHECK_EQUAL_TEXT(std::lround(expected[i].response), corners[i].score, where.c_str());
        }
        seen += corners.size();
      }
    }
  }
  CHECK(seen > 10000);
}

TEST(FastCorners, score_is_the_largest_threshold_that_keeps_the_corner) {
  const OwnedImage image = facets(90, 70, 3);
  FastOptions options;
  options.threshold = 8;
  options.suppress_non_maxima = false;
  const std::vector<FastCorner> corners = ours(image, options);
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
  const std::vector<FastCorner> all = ours(image, options);
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
    CHECK(expected == ours(image, options));
  }
}

TEST(FastCorners, without_room_the_strongest_are_kept_in_raster_order) {
  const OwnedImage image = facets(200, 150, 6);
  FastOptions options;
  const std::vector<FastCorner> all = ours(image, options);
  CHECK(all.size() > 100);
  for (const std::size_t room : {std::size_t{0}, std::size_t{1}, all.size() / 3, all.size() - 1, all.size()}) {
    std::vector<FastCorner> strongest = all;
    std::stable_sort(strongest.begin(), strongest.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
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
    CHECK(ours(image, {}).empty());
    image.at(31, 17) = level < 100 ? 255 : 0;
    const int contrast = level < 100 ? 255 : level;
    const std::vector<FastCorner> corners = ours(image, {});
    CHECK_EQUAL(std::size_t{1}, corners.size());
    CHECK((corners[0] == FastCorner{31, 17, static_cast<std::uint8_t>(contrast - 1)}));
  }
}

TEST(FastCorners, images_too_small_have_none_and_unusable_ones_are_refused) {
  for (const int side : {1, 6}) CHECK(ours(facets(side, side, 1), {}).empty());
  std::vector<FastCorner> corners(4);
  const OwnedImage image(64, 64);
  for (const ImageView& bad :
       {ImageView{}, ImageView{image.view().pixels, 64, 64, 63}, ImageView{image.view().pixels, 0, 64, 64},
        ImageView{image.view().pixels, static_cast<int>(config::max_image_width) + 1, 1, 5000}}) {
    CHECK(detect_fast(bad, {}, corners).status == Status::invalid_argument);
  }
}

}  // namespace relnav::vision
