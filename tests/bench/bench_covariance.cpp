// One filter update, n = 252 and m = 60: the flight kernels against unrestricted Eigen, each compiled for baseline
// x86-64 (SSE2, what we ship) and for x86-64-v3. Also checks that both kernel builds give the same bits.
// Results and how to run it: docs/benchmarks-covariance.md.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <limits>
#include <memory>
#include <vector>

#include "fsw/base/generator.hpp"
#include "tests/bench/covariance_case.hpp"

namespace {

namespace b = relnav::bench;

constexpr std::size_t element_count = static_cast<std::size_t>(b::states) * b::states;

std::unique_ptr<b::Case> make_case() {
  relnav::Generator generator(7);
  const auto draw = [&] { return 2.0 * generator.uniform() - 1.0; };
  auto c = std::make_unique<b::Case>();
  constexpr int rank = 20;
  std::vector<double> a(static_cast<std::size_t>(b::states) * rank);
  for (double& x : a) x = draw();
  for (std::size_t j = 0; j < b::states; ++j) {
    for (std::size_t i = 0; i < b::states; ++i) {
      double sum = i == j ? 1.0 : 0.0;
      for (std::size_t k = 0; k < rank; ++k) sum += a[i * rank + k] * a[j * rank + k];
      c->P[i + j * b::states] = sum;
    }
  }
  for (int i = 0; i < b::rows; ++i) {
    for (int k = 0; k < b::motion; ++k) c->motion_coefficients[i * b::motion + k] = k < 6 ? draw() : 0.0;
    for (int k = 0; k < b::feature; ++k) c->feature_coefficients[i * b::feature + k] = draw();
    c->r[i] = 1e-2;
  }
  for (int i = 0; i < b::pairs; ++i) c->feature_offset[i] = b::motion + 8 * i / 6 * 6;
  return c;
}

double thread_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

struct Contender {
  const char* name;
  const b::Update* update;
};

/// Least thread CPU time of `runs`, in microseconds; all contenders take turns, so that a busy machine is fair to all.
void compare(const std::vector<Contender>& all, int runs) {
  const std::size_t count = all.size();
  constexpr std::size_t columns = static_cast<std::size_t>(b::part_count) + 1U;
  std::vector<double> best(count * columns, std::numeric_limits<double>::infinity());
  for (int run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < count; ++i) {
      all[i].update->restore();
      double start = thread_us();
      benchmark::DoNotOptimize(all[i].update->update());
      best[i * columns] = std::min(best[i * columns], thread_us() - start);
      all[i].update->restore();
      for (std::size_t part = 1; part < columns; ++part) {
        start = thread_us();
        benchmark::DoNotOptimize(all[i].update->part(static_cast<int>(part) - 1));
        best[i * columns + part] = std::min(best[i * columns + part], thread_us() - start);
      }
    }
  }
  std::printf("least of %d runs, us    update   P H'      S   chol  solve  downdate+mirror\n", runs);
  for (std::size_t i = 0; i < count; ++i) {
    std::printf("%-22s", all[i].name);
    for (std::size_t part = 0; part < columns; ++part) std::printf(" %7.1f", best[i * columns + part]);
    std::printf("\n");
  }
  for (std::size_t i = 0; i + 1 < count; i += 2) {
    std::printf("ratio %s / %s: %.2f\n", all[i].name, all[i + 1].name, best[i * columns] / best[(i + 1) * columns]);
  }
}

void run(benchmark::State& state, const b::Update* update) {
  for (auto _ : state) {
    state.PauseTiming();
    update->restore();
    state.ResumeTiming();
    benchmark::DoNotOptimize(update->update());
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto data = make_case();
  std::vector<Contender> all = {{"kernels_sse2", relnav_kernels_sse2()}, {"eigen_sse2", relnav_eigen_sse2()}};
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    all.push_back({"kernels_v3", relnav_kernels_v3()});
    all.push_back({"eigen_v3", relnav_eigen_v3()});
  }
  std::vector<std::vector<double>> results;
  for (const Contender& c : all) {
    c.update->prepare(data.get());
    c.update->restore();
    if (!c.update->update()) {
      std::fprintf(stderr, "%s: update failed\n", c.name);
      return 1;
    }
    c.update->result(results.emplace_back(element_count).data());
    double difference = 0.0;
    for (std::size_t i = 0; i < element_count; ++i)
      difference = std::max(difference, std::abs(results.back()[i] - results[0][i]));
    std::printf("%s: largest difference to kernels_sse2 %.2g\n", c.name, difference);
    if (!(difference < 1e-10)) return 1;
  }
  if (all.size() > 2 && std::memcmp(results[0].data(), results[2].data(), element_count * sizeof(double)) != 0) {
    std::fprintf(stderr, "kernels_sse2 and kernels_v3 differ in bits\n");
    return 1;
  }
  compare(all, 400);
  for (const Contender& c : all)
    benchmark::RegisterBenchmark(c.name, [u = c.update](benchmark::State& s) { run(s, u); });
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
