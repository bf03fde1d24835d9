#pragma once
#include <vector>

#include "fsw/vision/fast_corners.hpp"
#include "tests/unit/vision/test_images.hpp"

// After the rest: its macros replace new.
#include <CppUTest/TestHarness.h>

namespace relnav::vision::test {

/// All of them: there is room.
inline std::vector<FastCorner> corners_of(const OwnedImage& image, const FastOptions& options) {
  std::vector<FastCorner> corners(200000);
  const FastResult result = detect_fast(image.view(), options, corners);
  CHECK(result.status == Status::ok);
  CHECK_EQUAL(result.found, result.count);
  corners.resize(result.count);
  return corners;
}

}  // namespace relnav::vision::test
