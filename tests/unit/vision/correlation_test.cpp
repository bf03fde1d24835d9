#include "fsw/vision/correlation.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::facets;
using test::OwnedImage;

WarpedPatch patch_at(const OwnedImage& image, int u, int v) {
  ReferencePatch reference;
  CHECK(capture_patch(image.view(), u, v, reference) == Status::ok);
  WarpedPatch patch;
  CHECK(warp_patch(reference, Mat2::Identity(), {}, patch) == Status::ok);
  return patch;
}

/// The definition, in double.
double plain_correlation(const ImageView& a, int ua, int va, const ImageView& b, int ub, int vb) {
  double mean_a = 0.0;
  double mean_b = 0.0;
  for (int v = -window_half_px; v <= window_half_px; ++v) {
    for (int u = -window_half_px; u <= window_half_px; ++u) {
      mean_a += *a.at(ua + u, va + v) / static_cast<double>(window_pixels);
      mean_b += *b.at(ub + u, vb + v) / static_cast<double>(window_pixels);
    }
  }
  double ab = 0.0;
  double aa = 0.0;
  double bb = 0.0;
  for (int v = -window_half_px; v <= window_half_px; ++v) {
    for (int u = -window_half_px; u <= window_half_px; ++u) {
      const double x = *a.at(ua + u, va + v) - mean_a;
      const double y = *b.at(ub + u, vb + v) - mean_b;
      ab += x * y;
      aa += x * x;
      bb += y * y;
    }
  }
  return ab / std::sqrt(aa * bb);
}

struct Best {
  int u = 0, v = 0, positions = 0;
  double score = -2.0;
};

Best plain_search(const OwnedImage& reference, int ur, int vr, const OwnedImage& image, const Vec2& uv, const Mat2& S,
                  double gate) {
  Best best;
  const double determinant = S(0, 0) * S(1, 1) - S(0, 1) * S(0, 1);
  for (int v = window_half_px; v < image.height() - window_half_px; ++v) {
    for (int u = window_half_px; u < image.width() - window_half_px; ++u) {
      const double x = u - uv(0);
      const double y = v - uv(1);
      const double distance = (S(1, 1) * x * x - 2.0 * S(0, 1) * x * y + S(0, 0) * y * y) / determinant;
      const bool beside = std::abs(u - std::lround(uv(0))) <= 1 && std::abs(v - std::lround(uv(1))) <= 1;
      if (distance > gate && !beside) continue;
      ++best.positions;
      const double score = plain_correlation(reference.view(), ur, vr, image.view(), u, v);
      if (score > best.score) best = {u, v, best.positions, score};
    }
  }
  return best;
}

}  // namespace

TEST_GROUP(Correlation) { std::unique_ptr<SearchScratch> scratch = std::make_unique<SearchScratch>(); };

TEST(Correlation, equals_the_definition) {
  const OwnedImage a = facets(120, 100, 11);
  const OwnedImage b = facets(120, 100, 12, 9);
  const WarpedPatch patch = patch_at(a, 60, 50);
  for (int v = window_half_px; v < 100 - window_half_px; v += 3) {
    for (int u = window_half_px; u < 120 - window_half_px; ++u) {
      DOUBLES_EQUAL(plain_correlation(a.view(), 60, 50, b.view(), u, v), correlation_at(patch, b.view(), u, v), 1e-12);
    }
  }
  DOUBLES_EQUAL(1.0, correlation_at(patch, a.view(), 60, 50), 1e-15);
}

TEST(Correlation, gain_and_bias_do_not_matter_and_a_negative_is_minus_one) {
  OwnedImage a(60, 60);
  a.fill([](double u, double v) { return std::fmod(u * 31.0 + v * 57.0 + u * v, 100.0); });
  OwnedImage brighter(60, 60);
  OwnedImage negative(60, 60);
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 60; ++u) {
      brighter.at(u, v) = static_cast<std::uint8_t>(2 * a.at(u, v) + 40);
      negative.at(u, v) = static_cast<std::uint8_t>(200 - a.at(u, v));
    }
  }
  const WarpedPatch patch = patch_at(a, 30, 30);
  DOUBLES_EQUAL(1.0, correlation_at(patch, brighter.view(), 30, 30), 1e-14);
  DOUBLES_EQUAL(-1.0, correlation_at(patch, negative.view(), 30, 30), 1e-14);
}

TEST(Correlation, flat_windows_and_flat_patches_give_zero) {
  const OwnedImage textured = facets(60, 60, 3);
  for (const std::uint8_t level : {std::uint8_t{0}, std::uint8_t{255}}) {
    const OwnedImage flat(60, 60, 0, level);
    DOUBLES_EQUAL(0.0, correlation_at(patch_at(textured, 30, 30), flat.view(), 20, 20), 0.0);
    DOUBLES_EQUAL(0.0, correlation_at(patch_at(flat, 30, 30), textured.view(), 20, 20), 0.0);
  }
}

TEST(Correlation, largest_sums_do_not_overflow) {
  OwnedImage image(60, 60);
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 60; ++u) image.at(u, v) = static_cast<std::uint8_t>((u ^ v) % 5 == 0 ? 0 : 255);
  }
  const WarpedPatch patch = patch_at(image, 30, 30);
  DOUBLES_EQUAL(plain_correlation(image.view(), 30, 30, image.view(), 25, 33),
                correlation_at(patch, image.view(), 25, 33), 1e-12);
}

TEST(Correlation, search_visits_the_ellipse_and_finds_its_best) {
  const OwnedImage a = facets(160, 140, 21);
  OwnedImage b = facets(160, 140, 22);
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < 40; ++u)
      b.at(60 + u, 50 + v) = static_cast<std::uint8_t>((*a.view().at(60 + u, 50 + v) + b.at(60 + u, 50 + v)) / 2);
  }
  const WarpedPatch patch = patch_at(a, 80, 70);
  Mat2 skewed;
  skewed << 6.0, -4.0, -4.0, 5.0;
  Mat2 tiny = Mat2::Identity() * 0.01;
  Mat2 flat;
  flat << 12.0, 0.0, 0.0, 0.3;
  for (const Mat2& S : {skewed, tiny, flat}) {
    for (const Vec2& uv : {Vec2(81.2, 69.1), Vec2(78.5, 72.5), Vec2(7.0, 7.4), Vec2(152.9, 132.2)}) {
      const Best expected = plain_search(a, 80, 70, b, uv, S, 9.21);
      SearchResult result;
      CHECK(search(patch, b.view(), uv, S, {}, *scratch, result) == Status::ok);
      CHECK_FALSE(result.on_lattice);
      CHECK_FALSE(result.capped);
      CHECK_EQUAL(expected.positions, result.positions);
      CHECK_EQUAL(expected.u, result.u_px);
      CHECK_EQUAL(expected.v, result.v_px);
      DOUBLES_EQUAL(expected.score, result.score, 1e-12);
    }
  }
}

TEST(Correlation, a_large_ellipse_is_scanned_on_a_lattice_and_gives_the_same_peak) {
  const test::Texture texture(5);
  OwnedImage a(200, 200);
  OwnedImage b(200, 200);
  a.fill(texture);
  int agreed = 0;
  for (int i = 0; i < 20; ++i) {
    const double du = -19.0 + 2.0 * i;
    const double dv = 11.0 - i;
    b.fill([&](double u, double v) { return texture(u - du, v - dv); });
    const WarpedPatch patch = patch_at(a, 100, 100);
    SearchResult coarse;
    SearchResult full;
    SearchOptions options;
    CHECK(search(patch, b.view(), Vec2(100.0, 100.0), Mat2::Identity() * 60.0, options, *scratch, coarse) ==
          Status::ok);
    options.full_scan_limit = 100000;
    CHECK(search(patch, b.view(), Vec2(100.0, 100.0), Mat2::Identity() * 60.0, options, *scratch, full) == Status::ok);
    CHECK(coarse.on_lattice);
    CHECK_FALSE(full.on_lattice);
    CHECK(3 * coarse.positions < full.positions);
    agreed += coarse.u_px == full.u_px && coarse.v_px == full.v_px ? 1 : 0;
    CHECK_EQUAL(100 + static_cast<int>(du), full.u_px);
    CHECK_EQUAL(100 + static_cast<int>(dv), full.v_px);
  }
  CHECK_EQUAL(20, agreed);
}

TEST(Correlation, an_endless_ellipse_is_capped) {
  const OwnedImage image = facets(300, 300, 31);
  const WarpedPatch patch = patch_at(image, 150, 150);
  SearchResult result;
  SearchOptions options;
  options.full_scan_limit = std::numeric_limits<std::int32_t>::max();
  CHECK(search(patch, image.view(), Vec2(150.3, 149.9), Mat2::Identity() * 1e4, options, *scratch, result) ==
        Status::ok);
  CHECK(result.capped);
  CHECK_EQUAL(80 * 80, result.positions);  // whole pixels within 40 of a centre between pixels
  CHECK_EQUAL(150, result.u_px);
  CHECK_EQUAL(150, result.v_px);
}

TEST(Correlation, second_best_is_the_repeated_pattern) {
  const OwnedImage source = facets(120, 120, 41);
  OwnedImage image(120, 120, 0, 30);
  for (const int shift : {0, 9}) {
    for (int v = -6; v <= 6; ++v) {
      for (int u = -4; u <= 4; ++u) image.at(50 + shift + u, 60 + v) = source.view().at(50 + u, 60 + v)[0];
    }
  }
  const WarpedPatch patch = patch_at(image, 50, 60);
  SearchResult result;
  CHECK(search(patch, image.view(), Vec2(53.0, 60.0), Mat2::Identity() * 9.0, {}, *scratch, result) == Status::ok);
  CHECK_EQUAL(50, result.u_px);
  CHECK(result.second_score > 0.2);
  CHECK(result.second_score < 0.999);
  CHECK(search(patch, image.view(), Vec2(50.0, 60.0), Mat2::Identity() * 0.1, {}, *scratch, result) == Status::ok);
  DOUBLES_EQUAL(-1.0, result.second_score, 0.0);
}

TEST(Correlation, what_cannot_be_searched_is_refused) {
  const OwnedImage image = facets(80, 80, 1);
  const WarpedPatch patch = patch_at(image, 40, 40);
  SearchResult result;
  const Mat2 S = Mat2::Identity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(search(patch, image.view(), Vec2(-20.0, 40.0), S, {}, *scratch, result) == Status::outside_domain);
  CHECK(search(patch, image.view(), Vec2(40.0, 1e300), S, {}, *scratch, result) == Status::outside_domain);
  CHECK(search(patch, image.view(), Vec2(nan, 40.0), S, {}, *scratch, result) == Status::not_finite);
  CHECK(search(patch, image.view(), Vec2(40.0, 40.0), S * nan, {}, *scratch, result) == Status::not_finite);
  Mat2 indefinite;
  indefinite << 1.0, 2.0, 2.0, 1.0;
  CHECK(search(patch, image.view(), Vec2(40.0, 40.0), indefinite, {}, *scratch, result) ==
        Status::not_positive_definite);
  const OwnedImage tiny(12, 12);
  CHECK(search(patch, tiny.view(), Vec2(6.0, 6.0), S, {}, *scratch, result) == Status::outside_domain);
}

}  // namespace relnav::vision
