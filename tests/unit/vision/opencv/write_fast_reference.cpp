// Writes fast_reference.inc, OpenCV's corners. Not part of the build, which does without OpenCV; when the cases change:
//   g++ -std=c++20 -O2 -w -I. $(pkg-config --cflags opencv4) -isystem /usr/include/eigen3 \
//     tests/unit/vision/opencv/write_fast_reference.cpp -lopencv_features2d -lopencv_core -o /tmp/write_fast_reference
//   /tmp/write_fast_reference >tests/unit/vision/opencv/fast_reference.inc
// from the root of the tree, with the package libopencv-dev.
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>

#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/unit/vision/opencv/fast_cases.hpp"
#include "tests/unit/vision/test_images.hpp"

int main() {
  using namespace relnav::vision::test;
  std::printf(
      "// Made by write_fast_reference.cpp with OpenCV %s: for each size and threshold, without and with "
      "suppression.\n",
      CV_VERSION);
  for (const auto& [width, height, slack] : fast_sizes) {
    OwnedImage image = facets(width, height, static_cast<std::uint64_t>(width), slack);
    const cv::Mat mat(height, width, CV_8UC1, image.data(), static_cast<std::size_t>(image.view().stride));
    for (const int threshold : fast_thresholds) {
      for (const bool suppress : {false, true}) {
        std::vector<cv::KeyPoint> points;
        cv::FAST(mat, points, threshold, suppress, cv::FastFeatureDetector::TYPE_9_16);
        FastReference reference;
        for (const cv::KeyPoint& p : points) {
          reference.add(std::lround(p.pt.x), std::lround(p.pt.y), std::lround(p.response), suppress);
        }
        std::printf("{%zu, 0x%016llxULL},  // %dx%d t %d%s\n", reference.count,
                    static_cast<unsigned long long>(reference.hash), width, height, threshold,
                    suppress ? ", suppressed" : "");
      }
    }
  }
  return 0;
}
