#include "fsw/vision/feature_tracker.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "fsw/vision/corner_spread.hpp"
#include "tests/unit/vision/test_images.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav::vision {
namespace {

using test::facets;
using test::OwnedImage;

FeaturePrediction prediction(SlotHandle slot, double u, double v, double sigma_px = 1.0) {
  FeaturePrediction p;
  p.slot = slot;
  p.uv_px = Vec2(u, v);
  p.S_px2 = Mat2::Identity() * (sigma_px * sigma_px);
  return p;
}

}  // namespace

TEST_GROUP(FeatureTracker) {
  std::unique_ptr<FeatureTracker> tracker = std::make_unique<FeatureTracker>();
  test::Texture texture{17};
  OwnedImage image{160, 140, 4};
  FeaturePredictions predictions;
  FeatureMatches matches;
  MatchReport report;

  void setup() override { image.fill(texture); }

  MatchOutcome match_one(const FeaturePrediction& p, const OwnedImage& in) {
    predictions.clear();
    CHECK(predictions.push_back(p) == Status::ok);
    CHECK(tracker->match(in.view(), predictions, matches, report) == Status::ok);
    CHECK_EQUAL(std::size_t{1}, report.outcomes.size());
    CHECK_EQUAL(report.outcomes[0] == MatchOutcome::matched, matches.size() == 1);
    CHECK_EQUAL(matches.size(), std::size_t{report.matched});
    return report.outcomes[0];
  }
};

TEST(FeatureTracker, finds_a_shifted_and_dimmed_patch) {
  CHECK(tracker->store({3, 9}, image.view(), 80, 70) == Status::ok);
  OwnedImage moved(160, 140);
  moved.fill([&](double u, double v) { return 0.6 * texture(u - 2.3, v + 1.4) + 20.0; });
  CHECK(match_one(prediction({3, 9}, 81.0, 69.5), moved) == MatchOutcome::matched);
  CHECK((matches[0].slot == SlotHandle{3, 9}));
  DOUBLES_EQUAL(82.3, matches[0].uv_px(0), 0.02);
  DOUBLES_EQUAL(68.6, matches[0].uv_px(1), 0.02);
  CHECK(matches[0].score > 0.8);
  CHECK(matches[0].sigma_px >= 0.1 && matches[0].sigma_px < 0.2);
}

TEST(FeatureTracker, finds_a_warped_patch_only_with_its_warp) {
  CHECK(tracker->store({0, 0}, image.view(), 80, 70) == Status::ok);
  Mat2 warp;
  warp << 0.75, -0.45, 0.35, 0.9;
  const double determinant = 0.75 * 0.9 + 0.45 * 0.35;
  OwnedImage warped(160, 140);
  warped.fill([&](double u, double v) {
    const double x = u - 80.4;
    const double y = v - 70.3;
    return texture(80.0 + (0.9 * x + 0.45 * y) / determinant, 70.0 + (-0.35 * x + 0.75 * y) / determinant);
  });
  FeaturePrediction p = prediction({0, 0}, 80.0, 70.0);
  CHECK(match_one(p, warped) != MatchOutcome::matched);
  p.warp = warp;
  CHECK(match_one(p, warped) == MatchOutcome::matched);
  DOUBLES_EQUAL(80.4, matches[0].uv_px(0), 0.02);
  DOUBLES_EQUAL(70.3, matches[0].uv_px(1), 0.02);
}

TEST(FeatureTracker, each_outcome) {
  CHECK(tracker->store({1, 0}, image.view(), 80, 70) == Status::ok);
  const OwnedImage other = facets(160, 140, 5);
  const OwnedImage black(160, 140);
  CHECK(match_one(prediction({1, 0}, 80.0, 70.0), other) == MatchOutcome::low_score);
  CHECK(match_one(prediction({1, 0}, 80.0, 70.0), black) == MatchOutcome::low_score);
  CHECK(match_one(prediction({1, 0}, 300.0, 70.0), image) == MatchOutcome::outside_image);
  CHECK(match_one(prediction({1, 1}, 80.0, 70.0), image) == MatchOutcome::no_patch);
  CHECK(match_one(prediction({2, 0}, 80.0, 70.0), image) == MatchOutcome::no_patch);
  CHECK(match_one(prediction({SlotHandle::no_index, 0}, 80.0, 70.0), image) == MatchOutcome::no_patch);
  FeaturePrediction p = prediction({1, 0}, 80.0, 70.0);
  p.warp *= 0.1;
  CHECK(match_one(p, image) == MatchOutcome::not_matchable);
  p.warp(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(match_one(p, image) == MatchOutcome::bad_prediction);
  p = prediction({1, 0}, 80.0, 70.0);
  p.S_px2 = -p.S_px2;
  CHECK(match_one(p, image) == MatchOutcome::bad_prediction);
  CHECK(tracker->store({2, 0}, black.view(), 80, 70) == Status::ok);
  CHECK(match_one(prediction({2, 0}, 80.0, 70.0), image) == MatchOutcome::not_matchable);
  CHECK(tracker->match(ImageView{}, predictions, matches, report) == Status::invalid_argument);
  CHECK(matches.empty());
}

TEST(FeatureTracker, a_repeated_pattern_is_ambiguous_when_asked) {
  OwnedImage repeated(160, 140);
  repeated.fill([&](double u, double v) { return texture(std::fmod(u, 16.0), v); });
  TrackerOptions options;
  options.max_second_ratio = 0.95;
  tracker = std::make_unique<FeatureTracker>(options);
  CHECK(tracker->store({0, 0}, repeated.view(), 80, 70) == Status::ok);
  CHECK(match_one(prediction({0, 0}, 80.0, 70.0, 6.0), repeated) == MatchOutcome::ambiguous);
  CHECK(match_one(prediction({0, 0}, 80.0, 70.0, 1.0), repeated) == MatchOutcome::matched);
}

TEST(FeatureTracker, slots_keep_their_first_view_until_dropped) {
  CHECK(tracker->store({5, 2}, image.view(), 80, 70) == Status::ok);
  CHECK(tracker->holds({5, 2}));
  CHECK_FALSE(tracker->holds({5, 3}));
  CHECK(tracker->drop({5, 3}) == Status::stale_handle);
  CHECK(tracker->drop({5, 2}) == Status::ok);
  CHECK(tracker->drop({5, 2}) == Status::stale_handle);
  CHECK(tracker->store({5, 3}, image.view(), 2, 70) == Status::outside_domain);
  CHECK_FALSE(tracker->holds({5, 3}));
  CHECK(tracker->store({config::max_features, 0}, image.view(), 80, 70) == Status::invalid_argument);
  CHECK(tracker->store({5, 3}, image.view(), 80, 70) == Status::ok);
  tracker->clear();
  CHECK_FALSE(tracker->holds({5, 3}));
}

TEST(FeatureTracker, runs_repeat_bit_for_bit) {
  // FNV-1a over the bits of every match of a run; equal on every target.
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  const auto add = [&hash](double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (unsigned shift = 0; shift < 64; shift += 8) hash = (hash ^ ((bits >> shift) & 0xFFU)) * 0x100000001B3ULL;
  };
  const OwnedImage first = facets(320, 240, 50);
  OwnedImage second = facets(320, 240, 51);
  for (int v = 1; v < 240; ++v) {
    for (int u = 1; u < 320; ++u) {
      const int sum = *first.view().at(u, v) * 3 + *first.view().at(u - 1, v) * 2 + *first.view().at(u, v - 1) * 3;
      second.at(u, v) = static_cast<std::uint8_t>((sum * 7 / 8 + second.at(u, v)) / 8);
    }
  }
  std::vector<FastCorner> corners(5000);
  corners.resize(detect_fast(first.view(), {}, corners).count);
  CornerCandidates candidates;
  CHECK(select_corners(first.view(), corners, {}, 40, {}, candidates) == Status::ok);
  Mat2 warp;
  warp << 1.02, 0.03, -0.02, 0.97;
  for (std::uint16_t i = 0; i < candidates.size(); ++i) {
    CHECK(tracker->store({i, 0}, first.view(), candidates[i].u_px, candidates[i].v_px) == Status::ok);
    FeaturePrediction p =
        prediction({i, 0}, candidates[i].u_px + 0.25, candidates[i].v_px - 0.5, i % 2 == 0 ? 1.5 : 9.0);
    p.warp = warp;
    CHECK(predictions.push_back(p) == Status::ok);
  }
  CHECK(tracker->match(second.view(), predictions, matches, report) == Status::ok);
  CHECK(report.on_lattice > 0);
  CHECK(matches.size() > 20);
  for (const FeatureMatch& match : matches) {
    add(match.uv_px(0));
    add(match.uv_px(1));
    add(match.sigma_px);
    add(match.score);
  }
  CHECK_EQUAL(std::uint64_t{8150648959863941964ULL}, hash);
}

}  // namespace relnav::vision
