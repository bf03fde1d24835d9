#include "fsw/vision/patch.hpp"

#include <Eigen/LU>

#include <cmath>
#include <limits>

#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::OwnedImage;

Mat2 matrix(double a, double b, double c, double d) {
  Mat2 m;
  m << a, b, c, d;
  return m;
}

std::size_t index(int u, int v) {
  return static_cast<std::size_t>((v + window_half_px) * window_stride + u + window_half_px);
}

// Not in the group: CppUTest's operator new knows no alignment beyond that of a double.
ReferencePatch reference;
WarpedPatch patch;

}  // namespace

TEST_GROUP(Patch) {
  test::Texture texture{8};
  OwnedImage image{100, 90, 5};

  void setup() override {
    patch = WarpedPatch();
    image.fill(texture);
    CHECK(capture_patch(image.view(), 50, 45, reference) == Status::ok);
  }
};

TEST(Patch, identity_keeps_levels_and_gradients_exactly) {
  CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
  std::int32_t sum = 0;
  for (int v = -window_half_px; v <= window_half_px; ++v) {
    for (int u = -window_half_px; u <= window_half_px; ++u) {
      CHECK_EQUAL(8 * image.at(50 + u, 45 + v), patch.level_q3[index(u, v)]);
      CHECK_EQUAL(8 * (image.at(51 + u, 45 + v) - image.at(49 + u, 45 + v)), patch.gradient_u_q3[index(u, v)]);
      CHECK_EQUAL(8 * (image.at(50 + u, 46 + v) - image.at(50 + u, 44 + v)), patch.gradient_v_q3[index(u, v)]);
      sum += 8 * image.at(50 + u, 45 + v);
    }
  }
  CHECK_EQUAL(sum, patch.sum_q3);
  for (std::size_t i = 0; i < patch.level_q3.size(); ++i) {
    if (i % window_stride >= window_side_px) CHECK_EQUAL(0, patch.level_q3[i]);
  }
}

TEST(Patch, warp_samples_the_reference_at_the_inverse_offset) {
  const double angle = 0.4;
  for (const Mat2& warp : {matrix(std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle)),
                           matrix(0.6, 0.0, 0.0, 1.0), matrix(1.6, 0.0, 0.0, 1.5), matrix(0.8, 0.2, -0.1, 1.1)}) {
    CHECK(warp_patch(reference, warp, {}, patch) == Status::ok);
    const Mat2 inverse = warp.inverse();
    double squares = 0.0;
    for (int v = -window_half_px; v <= window_half_px; ++v) {
      for (int u = -window_half_px; u <= window_half_px; ++u) {
        const Vec2 at = inverse * Vec2(u, v);
        const double error = patch.level_q3[index(u, v)] / 8.0 - texture(50.0 + at(0), 45.0 + at(1));
        squares += error * error;
        CHECK(std::fabs(error) < 6.0);
      }
    }
    CHECK(std::sqrt(squares / window_pixels) < 1.5);  // levels spread over 40
  }
}

TEST(Patch, warps_that_leave_the_stored_border_or_the_limits_are_refused) {
  CHECK(warp_patch(reference, matrix(0.5, 0.0, 0.0, 1.0), {}, patch) == Status::ok);
  CHECK(warp_patch(reference, matrix(0.45, 0.0, 0.0, 1.0), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, matrix(0.49, 0.0, 0.0, 0.49), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, matrix(1.0, 0.0, 3.0, 1.0), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, matrix(2.1, 0.0, 0.0, 2.1), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, matrix(-1.0, 0.0, 0.0, 1.0), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, Mat2::Zero(), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, matrix(1e200, 1e200, 0.0, 1e-200), {}, patch) == Status::outside_domain);
  CHECK(warp_patch(reference, matrix(std::numeric_limits<double>::infinity(), 0.0, 0.0, 1.0), {}, patch) ==
        Status::not_finite);
  CHECK(warp_patch(reference, matrix(1.0, std::numeric_limits<double>::quiet_NaN(), 0.0, 1.0), {}, patch) ==
        Status::not_finite);
}

TEST(Patch, overexposed_pixels_are_marked_with_their_neighbours) {
  OwnedImage bright(100, 90, 0, 100);
  bright.at(50, 45) = 255;
  CHECK(capture_patch(bright.view(), 50, 45, reference) == Status::ok);
  CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
  int marked = 0;
  for (int v = -window_half_px; v <= window_half_px; ++v) {
    for (int u = -window_half_px; u <= window_half_px; ++u) marked += 1 + patch.unsaturated[index(u, v)];
  }
  CHECK_EQUAL(5, marked);
  CHECK_EQUAL(0, patch.unsaturated[index(0, 0)]);
  CHECK_EQUAL(0, patch.unsaturated[index(1, 0)]);
  CHECK_EQUAL(-1, patch.unsaturated[index(1, 1)]);
}

TEST(Patch, capture_needs_the_whole_patch_inside) {
  constexpr int h = reference_half_px;
  CHECK(capture_patch(image.view(), h, h, reference) == Status::ok);
  CHECK(capture_patch(image.view(), 99 - h, 89 - h, reference) == Status::ok);
  CHECK(capture_patch(image.view(), h - 1, h, reference) == Status::outside_domain);
  CHECK(capture_patch(image.view(), h, h - 1, reference) == Status::outside_domain);
  CHECK(capture_patch(image.view(), 100 - h, h, reference) == Status::outside_domain);
  CHECK(capture_patch(image.view(), h, 90 - h, reference) == Status::outside_domain);
  CHECK(capture_patch(ImageView{}, h, h, reference) == Status::invalid_argument);
}

}  // namespace relnav::vision
