// Our corners against OpenCV's, as write_fast_reference.cpp wrote them down.
#include <array>
#include <string>
#include <vector>

#include "tests/unit/vision/corner_list.hpp"
#include "tests/unit/vision/opencv/fast_cases.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::corners_of;
using test::facets;
using test::fast_sizes;
using test::fast_thresholds;
using test::FastReference;
using test::OwnedImage;

constexpr std::array<FastReference, 2 * fast_sizes.size() * fast_thresholds.size()> opencv{{
#include "tests/unit/vision/opencv/fast_reference.inc"
}};

}  // namespace

TEST_GROUP(FastCornersAgainstOpenCv){};

TEST(FastCornersAgainstOpenCv, equals_opencv_on_every_size_stride_and_threshold) {
  std::size_t seen = 0;
  std::size_t at = 0;
  for (const auto& [width, height, slack] : fast_sizes) {
    const OwnedImage image = facets(width, height, static_cast<std::uint64_t>(width), slack);
    for (const int threshold : fast_thresholds) {
      for (const bool suppress : {false, true}) {
        FastOptions options;
        options.threshold = static_cast<std::uint8_t>(threshold);
        options.suppress_non_maxima = suppress;
        FastReference own;
        for (const FastCorner& c : corners_of(image, options)) own.add(c.u_px, c.v_px, c.score, suppress);
        const FastReference& expected = opencv[at++];
        const std::string where = std::to_string(width) + "x" + std::to_string(height) + " t " +
                                  std::to_string(threshold) + (suppress ? ", suppressed" : "");
        CHECK_EQUAL_TEXT(expected.count, own.count, where.c_str());
        CHECK_TEXT(expected.hash == own.hash, where.c_str());
        seen += own.count;
      }
    }
  }
  CHECK(seen > 10000);
}

}  // namespace relnav::vision
