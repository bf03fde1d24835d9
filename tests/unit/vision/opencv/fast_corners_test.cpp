// Our corners against OpenCV's: on the host only, targets have no OpenCV.
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/vision/corner_list.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::corners_of;
using test::facets;
using test::OwnedImage;

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

}  // namespace

TEST_GROUP(FastCornersAgainstOpenCv){};

TEST(FastCornersAgainstOpenCv, equals_opencv_on_every_size_stride_and_threshold) {
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
        const std::vector<FastCorner> corners = corners_of(image, options);
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

}  // namespace relnav::vision
