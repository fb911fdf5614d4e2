// Compensation beside the plain scalar form (the same streams as `tactbench benchmark compensate`).
#include <benchmark/benchmark.h>

#include <cmath>

#include "analysis/compensate/compensator.h"
#include "analysis/compensate/frame_compensator.h"
#include "bench/benchmarks/compensate.h"

using namespace tactbench;

namespace {

constexpr std::size_t kTaxels = 256;

template <class Real>
void run_frames(benchmark::State& state, const bench::CompensationCase& c) {
  analysis::FrameCompensator<Real> fast(c.setup);
  const std::size_t width = c.models.size();
  std::vector<Real> pressure(width), uncertainty(width);
  std::vector<std::uint16_t> status(width);
  std::size_t frame = 0;
  for (auto _ : state) {
    fast.frame(std::span(c.counts).subspan(frame * width, width), {pressure, uncertainty, status});
    benchmark::DoNotOptimize(pressure.data());
    frame = frame + 1 == c.frames ? 0 : frame + 1;
  }
  state.counters["ns/taxel"] = benchmark::Counter(
      static_cast<double>(width) * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void run_plain(benchmark::State& state, const bench::CompensationCase& c) {
  std::vector<analysis::TaxelCompensator> plain;
  for (std::size_t t = 0; t < c.models.size(); ++t) {
    analysis::CompensatorOptions options;
    options.noise_v = c.setup.taxels[t].noise_v;
    plain.emplace_back(c.models[t], options);
  }
  std::size_t frame = 0;
  for (auto _ : state) {
    for (std::size_t t = 0; t < plain.size(); ++t)
      benchmark::DoNotOptimize(plain[t].step(c.counts[frame * plain.size() + t] * c.setup.volts_per_count));
    frame = frame + 1 == c.frames ? 0 : frame + 1;
  }
}

const bench::CompensationCase& slow() {
  static const bench::CompensationCase made = bench::slow_cycles(kTaxels, 20000);
  return made;
}
const bench::CompensationCase& turning() {
  static const bench::CompensationCase made = bench::random_frames(kTaxels, 1000);
  return made;
}

void compensate_slow_plain(benchmark::State& state) { run_plain(state, slow()); }
void compensate_slow_float(benchmark::State& state) { run_frames<float>(state, slow()); }
void compensate_slow_double(benchmark::State& state) { run_frames<double>(state, slow()); }
void compensate_turning_plain(benchmark::State& state) { run_plain(state, turning()); }
void compensate_turning_float(benchmark::State& state) { run_frames<float>(state, turning()); }
void compensate_growth(benchmark::State& state) {
  run_frames<float>(state, bench::tiled(slow(), static_cast<std::size_t>(state.range(0)), 1500));
}

BENCHMARK(compensate_slow_plain);
BENCHMARK(compensate_slow_float);
BENCHMARK(compensate_slow_double);
BENCHMARK(compensate_turning_plain);
BENCHMARK(compensate_turning_float);
BENCHMARK(compensate_growth)->Arg(1)->Arg(4)->Arg(16);

}  // namespace

BENCHMARK_MAIN();
