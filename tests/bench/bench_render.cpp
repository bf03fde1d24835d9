// Simulated frames a second, 640 x 480: our satellite at a few distances, lights, the Earth behind it, sensor noise. Results:
// docs/simulation-images.md. Argument: distance in tenths of a metre, threads.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "hil/render/scene_renderer.hpp"
#include "hil/scenarios/targets.hpp"

namespace {

using relnav::Mat3;
using relnav::Vec3;
using namespace relnav::hil;

relnav::CameraModel camera() {
  relnav::CameraIntrinsics k;
  k.fu = 663.9;
  k.fv = 664.6;
  k.cu = 323.8;
  k.cv = 235.2;
  k.width_px = 640;
  k.height_px = 480;
  k.model = relnav::DistortionModel::radial_tangential;
  k.coefficients = {-0.045, 0.03, -0.0004, 0.0006};
  return relnav::CameraModel::create(k).value();
}

/// The target spins at 2 deg/s before a camera at rest; sun from behind the camera's left shoulder.
SceneState state_at(relnav::Time t, double distance, const Vec3& earth_C) {
  SceneState state;
  state.time = t;
  const double angle = -0.6 + 0.035 * static_cast<double>(t.ns) * 1e-9;
  state.R_CT << std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle);
  state.t_CT = Vec3(0.0, 0.0, distance);
  state.sun_C = Vec3(-0.7, -0.35, -0.62).normalized();
  state.earth_C = earth_C;
  return state;
}

void render(benchmark::State& bench, const RenderSettings& settings, const Vec3& earth_C) {
  const double distance = 0.1 * static_cast<double>(bench.range(0));
  RenderSettings s = settings;
  s.threads = static_cast<std::uint32_t>(bench.range(1));
  const relnav::TargetModel lights = square_target(0.5);
  SceneRenderer renderer(s, camera(), &lights, 1);
  Image image;
  std::uint32_t frame = 0;
  for (auto _ : bench) {
    const relnav::Time t{static_cast<std::int64_t>(frame) * 100'000'000};
    renderer.render(
        t, frame++, 1e-3, 1.0, [&](relnav::Time at) { return state_at(at, distance, earth_C); }, image);
    benchmark::DoNotOptimize(image.bytes.data());
  }
  bench.counters["frames/s"] = benchmark::Counter(static_cast<double>(frame), benchmark::Counter::kIsRate);
}

void frames(benchmark::State& bench) { render(bench, RenderSettings{}, Vec3(0.0, 6.8e6, 0.0)); }
BENCHMARK(frames)
    ->Args({34, 2})
    ->Args({50, 2})
    ->Args({80, 2})
    ->Args({300, 2})
    ->Args({34, 1})
    ->Args({80, 1})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// The Earth fills the image behind the target.
void frames_before_the_earth(benchmark::State& bench) { render(bench, RenderSettings{}, Vec3(0.0, 0.0, 6.8e6)); }
BENCHMARK(frames_before_the_earth)
    ->Args({80, 2})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void frames_with_rolling_shutter(benchmark::State& bench) {
  RenderSettings settings;
  settings.row_time_us = 20.0;
  render(bench, settings, Vec3(0.0, 6.8e6, 0.0));
}
BENCHMARK(frames_with_rolling_shutter)
    ->Args({80, 2})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
