// Pose of a cooperative target from its features: ours against the solvers of OpenCV and, where installed, OpenGV and ViSP,
// on the same observations, one thread.
// Results and how to run it: docs/benchmarks-pose.md.
#include <benchmark/benchmark.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "fsw/attitude/so3.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/estimation/pose_acquisition.hpp"
#include "fsw/estimation/stereo_closed_form.hpp"
#include "tests/bench/pose_peer.hpp"

namespace {

using namespace relnav;

constexpr std::size_t cases = 256;  // solved in turn, so that no branch predictor learns one by heart

struct View {
  Pose truth;
  Pose guess;
  PoseObservations seen;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  cv::Mat rvec;  // of the guess
  cv::Mat tvec;
};

struct Problem {
  CameraRig rig;
  TargetModel target;
  std::vector<View> views;
  cv::Matx33d K;
  ObservationMask used;
};

[[noreturn]] void give_up(const char* what) {
  std::fprintf(stderr, "bench_pose: %s\n", what);
  std::exit(1);
}
void check(Status status) {
  if (status != Status::ok) give_up(to_string(status));
}

/// Cube of 8 corners or square of 4 about 1 m across, 3 to 4 m away, 0.5 px of noise (uniform), any attitude that shows it.
Problem make_problem(bool planar, bool stereo) {
  Problem p;
  p.used.fill(true);
  CameraIntrinsics k;
  k.fu = k.fv = 1000.0;
  k.cu = k.cv = 511.5;
  k.width_px = k.height_px = 1024;
  p.K = cv::Matx33d(k.fu, 0, k.cu, 0, k.fv, k.cv, 0, 0, 1);
  const Expected<CameraModel> camera = CameraModel::create(k);
  if (!camera) give_up("camera");
  check(p.rig.push_back({camera.value(), Mat3::Identity(), Vec3::Zero()}));
  if (stereo) check(p.rig.push_back({camera.value(), Mat3::Identity(), Vec3(-1.0, 0.0, 0.0)}));
  std::vector<Vec3> points;
  if (planar) {
    points = {Vec3(-0.5, 0, 0), Vec3(0, -0.5, 0), Vec3(0.5, 0, 0), Vec3(0, 0.5, 0)};
  } else {
    for (int i = 0; i < 8; ++i) {
      points.emplace_back((i & 1) != 0 ? 0.3 : -0.3, (i & 2) != 0 ? 0.3 : -0.3, (i & 4) != 0 ? 0.3 : -0.3);
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    check(p.target.features.push_back({static_cast<std::uint16_t>(i), points[i], Vec3::Zero()}));
  }
  Generator generator(7);
  const auto unit = [&] { return 2.0 * generator.uniform() - 1.0; };
  const auto vector = [&] {
    const double x = unit();
    const double y = unit();
    return Vec3(x, y, unit());
  };
  while (p.views.size() < cases) {
    View v;
    v.truth.R_CT = exp_so3(Vec3((planar ? 0.7 : 3.0) * vector()));
    v.truth.t_CT = Vec3(0.3 * unit() + (stereo ? 0.5 : 0.0), 0.3 * unit(), 3.5 + 0.5 * unit());
    for (std::size_t c = 0; c < p.rig.size(); ++c) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        PoseObservation o;
        o.feature = static_cast<std::uint16_t>(i);
        o.camera = static_cast<std::uint16_t>(c);
        check(p.rig[c].model.project(Vec3(v.truth.R_CT * points[i] + v.truth.t_CT + p.rig[c].t_KC), o.uv_px));
        o.uv_px += 0.87 * Vec2(unit(), unit());
        o.sigma_px = 0.5;
        check(v.seen.push_back(o));
        if (c == 0) {
          v.points.emplace_back(points[i].x(), points[i].y(), points[i].z());
          v.pixels.emplace_back(o.uv_px.x(), o.uv_px.y());
        }
      }
    }
    // As far as a target moves between two frames.
    v.guess.R_CT = exp_so3(Vec3(0.03 * vector())) * v.truth.R_CT;
    v.guess.t_CT = v.truth.t_CT + 0.05 * vector();
    const Vec3 r = log_so3(v.guess.R_CT);
    v.rvec = (cv::Mat_<double>(3, 1) << r.x(), r.y(), r.z());
    v.tvec = (cv::Mat_<double>(3, 1) << v.guess.t_CT.x(), v.guess.t_CT.y(), v.guess.t_CT.z());
    p.views.push_back(v);
  }
  return p;
}

const Problem& cube() {
  static const Problem problem = make_problem(false, false);
  return problem;
}
const Problem& square() {
  static const Problem problem = make_problem(true, false);
  return problem;
}
const Problem& stereo_square() {
  static const Problem problem = make_problem(true, true);
  return problem;
}

void solve_warm(benchmark::State& state, const Problem& p) {
  PoseEstimate e;
  std::size_t i = 0;
  double iterations = 0.0;
  double count = 0.0;
  for (auto _ : state) {
    const View& v = p.views[i++ % cases];
    check(solve_pose(p.rig, p.target, v.seen, p.used, v.guess, {}, e));
    benchmark::DoNotOptimize(e);
    iterations += e.iterations;
    count += 1.0;
  }
  state.counters["iterations"] = iterations / count;
}
void warm_ours(benchmark::State& state) { solve_warm(state, cube()); }
BENCHMARK(warm_ours)->Unit(benchmark::kMicrosecond);

void solve_opencv(benchmark::State& state, const Problem& p, int method, bool guess) {
  cv::setNumThreads(1);
  std::size_t i = 0;
  for (auto _ : state) {
    const View& v = p.views[i++ % cases];
    cv::Mat rvec = v.rvec.clone();
    cv::Mat tvec = v.tvec.clone();
    if (!cv::solvePnP(v.points, v.pixels, p.K, cv::noArray(), rvec, tvec, guess, method)) give_up("solvePnP");
    benchmark::DoNotOptimize(rvec.data);
  }
}
void warm_opencv_iterative(benchmark::State& state) { solve_opencv(state, cube(), cv::SOLVEPNP_ITERATIVE, true); }
BENCHMARK(warm_opencv_iterative)->Unit(benchmark::kMicrosecond);

void acquire(benchmark::State& state, const Problem& p) {
  AcquiredPose a;
  std::size_t i = 0;
  double ambiguous = 0.0;
  double count = 0.0;
  for (auto _ : state) {
    check(acquire_pose(p.rig, p.target, p.views[i++ % cases].seen, p.used, {}, a));
    benchmark::DoNotOptimize(a);
    ambiguous += a.ambiguous ? 1.0 : 0.0;
    count += 1.0;
  }
  state.counters["ambiguous"] = ambiguous / count;
}
void cold_ours(benchmark::State& state) { acquire(state, cube()); }
BENCHMARK(cold_ours)->Unit(benchmark::kMicrosecond);
void cold_opencv_sqpnp(benchmark::State& state) { solve_opencv(state, cube(), cv::SOLVEPNP_SQPNP, false); }
BENCHMARK(cold_opencv_sqpnp)->Unit(benchmark::kMicrosecond);
void cold_opencv_epnp(benchmark::State& state) { solve_opencv(state, cube(), cv::SOLVEPNP_EPNP, false); }
BENCHMARK(cold_opencv_epnp)->Unit(benchmark::kMicrosecond);
void cold_opencv_iterative(benchmark::State& state) { solve_opencv(state, cube(), cv::SOLVEPNP_ITERATIVE, false); }
BENCHMARK(cold_opencv_iterative)->Unit(benchmark::kMicrosecond);

void planar_ours(benchmark::State& state) { acquire(state, square()); }
BENCHMARK(planar_ours)->Unit(benchmark::kMicrosecond);
void planar_opencv_ippe(benchmark::State& state) { solve_opencv(state, square(), cv::SOLVEPNP_IPPE, false); }
BENCHMARK(planar_opencv_ippe)->Unit(benchmark::kMicrosecond);

void stereo_motor(benchmark::State& state) {
  const Problem& p = stereo_square();
  StereoPoints points;
  Pose pose;
  std::size_t i = 0;
  for (auto _ : state) {
    check(triangulate_features(p.rig, p.target, p.views[i++ % cases].seen, points));
    check(solve_motor(p.target, points, MotorLines::target, pose));
    benchmark::DoNotOptimize(pose);
  }
}
BENCHMARK(stereo_motor)->Unit(benchmark::kMicrosecond);

void stereo_refined(benchmark::State& state) {
  const Problem& p = stereo_square();
  StereoPoints points;
  Pose pose;
  PoseEstimate e;
  std::size_t i = 0;
  for (auto _ : state) {
    const View& v = p.views[i++ % cases];
    check(triangulate_features(p.rig, p.target, v.seen, points));
    check(solve_motor(p.target, points, MotorLines::target, pose));
    check(solve_pose(p.rig, p.target, v.seen, p.used, pose, {}, e));
    benchmark::DoNotOptimize(e);
  }
}
BENCHMARK(stereo_refined)->Unit(benchmark::kMicrosecond);

/// Of other libraries, on the cube. Counts the views whose attitude is off by more than 5 deg.
void solve_peer(benchmark::State& state, const bench::Peer& peer) {
  const Problem& p = cube();
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R_CT;
  Vec3 t_CT;
  std::size_t i = 0;
  for (auto _ : state) {
    if (!peer.solve(static_cast<int>(i++ % cases), R_CT.data(), t_CT.data())) give_up(peer.name);
    benchmark::DoNotOptimize(t_CT);
  }
  double wrong = 0.0;
  for (i = 0; i < cases; ++i) {
    const bool solved = peer.solve(static_cast<int>(i), R_CT.data(), t_CT.data());
    wrong += solved && log_so3(Mat3(R_CT * p.views[i].truth.R_CT.transpose())).norm() < 0.087 ? 0.0 : 1.0;
  }
  state.counters["wrong"] = wrong;
}

[[maybe_unused]] void add_peers(int (*library)(const bench::PeerView*, int, const bench::Peer**)) {
  std::vector<bench::PeerView> views;
  for (const View& v : cube().views) {
    bench::PeerView view;
    for (std::size_t k = 0; k < v.points.size(); ++k) {
      const Vec2 xy = (v.seen[k].uv_px - Vec2(511.5, 511.5)) / 1000.0;
      for (int c = 0; c < 3; ++c) view.p_T[k][c] = cube().target.features[k].p_T(c);
      for (int c = 0; c < 2; ++c) view.xy[k][c] = xy(c);
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) view.R_CT[3 * r + c] = v.guess.R_CT(r, c);
      view.t_CT[r] = v.guess.t_CT(r);
    }
    views.push_back(view);
  }
  const bench::Peer* peers = nullptr;
  const int count = library(views.data(), static_cast<int>(views.size()), &peers);
  for (int k = 0; k < count; ++k) {
    benchmark::RegisterBenchmark(peers[k].name, solve_peer, peers[k])->Unit(benchmark::kMicrosecond);
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifdef RELNAV_PEER_OPENGV
  add_peers(relnav_peers_opengv);
#endif
#ifdef RELNAV_PEER_VISP
  add_peers(relnav_peers_visp);
#endif
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
