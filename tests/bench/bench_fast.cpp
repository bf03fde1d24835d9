// FAST-9/16 on a whole 640x480 frame, threshold 20, with non-maximum suppression: ours against cv::FAST, one thread, and the
// rest of the vision front end on the same frame. Results and how to run it: docs/benchmarks-fast.md.
#include <benchmark/benchmark.h>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "fsw/base/generator.hpp"
#include "fsw/vision/corner_spread.hpp"
#include "fsw/vision/fast_corners.hpp"
#include "fsw/vision/feature_tracker.hpp"

namespace {

namespace vision = relnav::vision;

constexpr int threshold = 20;

/// Facets of random level on black, for where there are no recorded frames.
cv::Mat made_up_frame() {
  cv::Mat frame = cv::Mat::zeros(480, 640, CV_8UC1);
  relnav::Generator generator(1);
  for (int i = 0; i < 1200; ++i) {
    const int u0 = 140 + static_cast<int>(generator.below(340));
    const int v0 = 60 + static_cast<int>(generator.below(340));
    const int side = 3 + static_cast<int>(generator.below(22));
    frame(cv::Rect(u0, v0, side, side)) = cv::Scalar(std::min(255.0, 330.0 * generator.uniform()));
  }
  for (int v = 0; v < frame.rows; ++v) {
    for (int u = 0; u < frame.cols; ++u) {
      frame.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(frame.at<std::uint8_t>(v, u) + static_cast<int>(generator.below(3)) - 1);
    }
  }
  return frame;
}

/// The 640x480 grey frame named by RELNAV_BENCH_FRAME, or the made-up one.
const cv::Mat& frame() {
  static const cv::Mat the_frame = [] {
    const char* path = std::getenv("RELNAV_BENCH_FRAME");
    cv::Mat read = path == nullptr ? made_up_frame() : cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (read.empty()) {
      std::fprintf(stderr, "bench_fast: %s: not an image\n", path);
      std::exit(2);
    }
    return read;
  }();
  return the_frame;
}

vision::ImageView view() { return {frame().data, frame().cols, frame().rows, static_cast<int>(frame().step)}; }

void check_equal_once() {
  std::vector<cv::KeyPoint> theirs;
  cv::FAST(frame(), theirs, threshold, true);
  std::vector<vision::FastCorner> ours(100000);
  ours.resize(vision::detect_fast(view(), {}, ours).count);
  bool equal = ours.size() == theirs.size();
  for (std::size_t i = 0; equal && i < ours.size(); ++i) {
    equal = cvRound(theirs[i].pt.x) == ours[i].u_px && cvRound(theirs[i].pt.y) == ours[i].v_px &&
            cvRound(theirs[i].response) == ours[i].score;
  }
  if (!equal) {
    std::fprintf(stderr, "bench_fast: the corners differ from OpenCV's\n");
    std::exit(1);
  }
}

void fast_opencv(benchmark::State& state) {
  cv::setNumThreads(1);
  check_equal_once();
  std::vector<cv::KeyPoint> corners;
  corners.reserve(20000);
  for (auto _ : state) {
    cv::FAST(frame(), corners, threshold, true);
    benchmark::DoNotOptimize(corners.data());
  }
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(fast_opencv)->Unit(benchmark::kMicrosecond);

void fast_ours(benchmark::State& state) {
  std::vector<vision::FastCorner> corners(20000);
  vision::FastResult result;
  for (auto _ : state) {
    result = vision::detect_fast(view(), {}, corners);
    benchmark::DoNotOptimize(corners.data());
  }
  state.counters["corners"] = static_cast<double>(result.count);
}
BENCHMARK(fast_ours)->Unit(benchmark::kMicrosecond);

vision::CornerCandidates pick(std::vector<vision::FastCorner>& corners) {
  corners.resize(20000);
  corners.resize(vision::detect_fast(view(), {}, corners).count);
  vision::CornerCandidates candidates;
  if (vision::select_corners(view(), corners, {}, 40, {}, candidates) != relnav::Status::ok) std::exit(1);
  return candidates;
}

void select_40_corners(benchmark::State& state) {
  std::vector<vision::FastCorner> corners;
  vision::CornerCandidates candidates = pick(corners);
  for (auto _ : state) {
    if (vision::select_corners(view(), corners, {}, 40, {}, candidates) != relnav::Status::ok) std::exit(1);
    benchmark::DoNotOptimize(candidates.data());
  }
  state.counters["selected"] = static_cast<double>(candidates.size());
}
BENCHMARK(select_40_corners)->Unit(benchmark::kMicrosecond);

/// Argument: 1 sigma of the prediction, tenths of a pixel. Patches are warped a little, so that each is resampled.
void match_40_features(benchmark::State& state) {
  std::vector<vision::FastCorner> corners;
  const vision::CornerCandidates candidates = pick(corners);
  const auto tracker = std::make_unique<vision::FeatureTracker>();
  relnav::FeaturePredictions predictions;
  const double sigma_px = 0.1 * static_cast<double>(state.range(0));
  for (std::uint16_t i = 0; i < candidates.size(); ++i) {
    const relnav::SlotHandle slot{i, 0};
    if (tracker->store(slot, view(), candidates[i].u_px, candidates[i].v_px) != relnav::Status::ok) std::exit(1);
    relnav::FeaturePrediction p;
    p.slot = slot;
    p.uv_px = relnav::Vec2(candidates[i].u_px + 0.6, candidates[i].v_px - 0.4);
    p.S_px2 = relnav::Mat2::Identity() * sigma_px * sigma_px;
    p.warp << 1.01, 0.01, -0.01, 0.99;
    if (predictions.push_back(p) != relnav::Status::ok) std::exit(1);
  }
  relnav::FeatureMatches matches;
  vision::MatchReport report;
  for (auto _ : state) {
    if (tracker->match(view(), predictions, matches, report) != relnav::Status::ok) std::exit(1);
    benchmark::DoNotOptimize(matches.data());
  }
  state.counters["matched"] = static_cast<double>(report.matched);
  state.counters["positions"] = static_cast<double>(report.positions);
}
BENCHMARK(match_40_features)->Arg(10)->Arg(20)->Arg(100)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
