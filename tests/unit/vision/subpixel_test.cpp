#include "fsw/vision/subpixel.hpp"

#include <cmath>

#include "fsw/vision/correlation.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::OwnedImage;

struct Figures {
  int done = 0;
  int tried = 0;
  int quadratic = 0;        ///< of those done, by the quadratic fit; not in the figures below
  double rms_px = 0.0;      ///< an axis
  double normalised = 0.0;  ///< mean square of error / sigma
};

/// Synthetic noise is white: no allowance on top of the Cramer-Rao figure.
SubpixelOptions white_noise() {
  SubpixelOptions options;
  options.sigma_scale = 1.0;
  options.min_sigma_px = 0.01;
  return options;
}

/// Shifts textures by fractions of a pixel; `distort` turns a level into what the second camera image shows.
template <typename Distort>
Figures measure(double noise, Distort&& distort) {
  Figures figures;
  Generator generator(99);
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const test::Texture texture(seed);
    OwnedImage first(48, 48);
    OwnedImage second(48, 48);
    const double du = 1.2 * generator.uniform() - 0.6;
    const double dv = 1.2 * generator.uniform() - 0.6;
    first.fill([&](double u, double v) { return texture(u, v) + noise * test::normal(generator); });
    second.fill([&](double u, double v) { return distort(texture(u - du, v - dv)) + noise * test::normal(generator); });
    ReferencePatch reference;
    WarpedPatch patch;
    CHECK(capture_patch(first.view(), 24, 24, reference) == Status::ok);
    CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
    SubpixelResult result;
    ++figures.tried;
    const Status status =
        refine(patch, second.view(), 24, 24, correlation_at(patch, second.view(), 24, 24), white_noise(), result);
    if (status != Status::ok) continue;
    ++figures.done;
    const double eu = result.uv_px(0) - 24.0 - du;
    const double ev = result.uv_px(1) - 24.0 - dv;
    if (result.quadratic) {
      ++figures.quadratic;
      CHECK(std::hypot(eu, ev) < 1.5 * result.sigma_px);
      continue;
    }
    squares += eu * eu + ev * ev;
    figures.normalised += 0.5 * (eu * eu + ev * ev) / (result.sigma_px * result.sigma_px);
  }
  figures.rms_px = std::sqrt(squares / (2.0 * (figures.done - figures.quadratic)));
  figures.normalised /= figures.done - figures.quadratic;
  return figures;
}

double same(double level) { return level; }

}  // namespace

TEST_GROUP(Subpixel){};

TEST(Subpixel, noise_free_shifts_are_found_to_hundredths) {
  const Figures figures = measure(0.0, same);
  CHECK_EQUAL(figures.tried, figures.done);
  CHECK_EQUAL(0, figures.quadratic);
  CHECK_COMPARE(figures.rms_px, <, 0.01);
}

TEST(Subpixel, gain_and_bias_make_no_difference) {
  const Figures figures = measure(0.0, [](double level) { return 0.5 * level + 60.0; });
  CHECK_EQUAL(figures.tried, figures.done);
  CHECK_COMPARE(figures.rms_px, <, 0.01);
}

TEST(Subpixel, a_tenth_of_a_pixel_under_noise_a_quarter_of_the_contrast) {
  const Figures figures = measure(10.0, same);
  CHECK_EQUAL(figures.tried, figures.done);
  CHECK_COMPARE(figures.rms_px, <, 0.1);
}

TEST(Subpixel, sigma_is_honest_under_noise) {
  const Figures figures = measure(20.0, same);
  CHECK_COMPARE(figures.quadratic, <, 6);
  CHECK_COMPARE(figures.normalised, <, 1.6);
  CHECK_COMPARE(figures.normalised, >, 0.6);
}

TEST(Subpixel, overexposure_does_not_bias) {
  const Figures figures = measure(0.0, [](double level) { return 2.0 * level; });
  CHECK_EQUAL(figures.tried, figures.done);
  CHECK_COMPARE(figures.quadratic, <, figures.tried / 4);
  CHECK_COMPARE(figures.rms_px, <, 0.02);
}

TEST(Subpixel, mostly_overexposed_windows_use_the_quadratic_fit) {
  const test::Texture texture(4);
  OwnedImage image(48, 48);
  image.fill([&](double u, double v) { return 6.0 * texture(u, v) - 330.0; });
  ReferencePatch reference;
  WarpedPatch patch;
  CHECK(capture_patch(image.view(), 24, 24, reference) == Status::ok);
  CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
  SubpixelOptions options;
  options.min_pixels = window_pixels;
  SubpixelResult result;
  CHECK(refine(patch, image.view(), 24, 24, 1.0, options, result) == Status::ok);
  CHECK(result.quadratic);
  DOUBLES_EQUAL(24.0, result.uv_px(0), 0.2);
  DOUBLES_EQUAL(24.0, result.uv_px(1), 0.2);
  DOUBLES_EQUAL(options.quadratic_sigma_px, result.sigma_px, 0.0);
  options.quadratic_fallback = false;
  CHECK(refine(patch, image.view(), 24, 24, 1.0, options, result) == Status::rank_deficient);
}

TEST(Subpixel, an_edge_does_not_determine_a_position) {
  OwnedImage image(48, 48);
  image.fill([](double u, double) { return u < 24.0 ? 40.0 : 160.0; });
  ReferencePatch reference;
  WarpedPatch patch;
  CHECK(capture_patch(image.view(), 24, 24, reference) == Status::ok);
  CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
  SubpixelResult result;
  CHECK(refine(patch, image.view(), 24, 24, 1.0, {}, result) == Status::rank_deficient);
}

TEST(Subpixel, a_peak_more_than_a_pixel_away_is_refused) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const test::Texture texture(seed);
    OwnedImage first(48, 48);
    OwnedImage second(48, 48);
    first.fill(texture);
    const double far = 1.2;
    second.fill([&](double u, double v) { return seed % 2 == 0 ? texture(u - far, v) : texture(u, v - far); });
    ReferencePatch reference;
    WarpedPatch patch;
    CHECK(capture_patch(first.view(), 24, 24, reference) == Status::ok);
    CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
    SubpixelResult result;
    CHECK(refine(patch, second.view(), 24, 24, 0.8, {}, result) == Status::no_convergence);
  }
}

TEST(Subpixel, works_up_to_the_edge_of_the_image_and_not_beyond) {
  const test::Texture texture(9);
  OwnedImage image(60, 60);
  image.fill(texture);
  ReferencePatch reference;
  WarpedPatch patch;
  CHECK(capture_patch(image.view(), 30, 30, reference) == Status::ok);
  CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
  OwnedImage corner(20, 20);
  corner.fill([&](double u, double v) { return texture(u + 24.0, v + 24.0); });
  SubpixelResult result;
  CHECK(refine(patch, corner.view(), 6, 6, 1.0, {}, result) == Status::ok);
  DOUBLES_EQUAL(6.0, result.uv_px(0), 0.01);
  CHECK(refine(patch, corner.view(), 5, 6, 1.0, {}, result) == Status::outside_domain);
}

}  // namespace relnav::vision
