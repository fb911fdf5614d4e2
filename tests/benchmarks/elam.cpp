// ELAM identification of one taxel beside one plain evaluation of J over its 660 samples (the unit of the goals), on
// every lane level, and an array's fit beside identification alone.
#include <benchmark/benchmark.h>

#include "analysis/identify/elam/identify.h"
#include "analysis/identify/elam/lanes.h"
#include "bench/benchmarks/identify.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset dataset_of(int side) {
  ArrayOptions options;
  options.rows = options.columns = side;
  RunOptions how;
  how.noise_v = 0.004;
  how.scans = 1;
  return run(Array(options), how);
}

const Dataset& dataset() {
  static const Dataset data = dataset_of(8);
  return data;
}

struct Taxel {
  PatternCurve ascending, descending;
  std::vector<TaxelBranch> branches;
};

const std::vector<Taxel>& taxels() {
  static const std::vector<Taxel> all = [] {
    const Dataset& data = dataset();
    const auto width = static_cast<std::size_t>(data.taxels());
    const SensorModel fit = fit_array(data);
    std::vector<Taxel> list;
    for (std::size_t taxel = 0; taxel < width; ++taxel) {
      Taxel own{fit.taxels[taxel].ascending, fit.taxels[taxel].descending, {}};
      for (const SequenceData& sequence : data.sequences) {
        const TaxelTable common = bring_to_common(sequence, data.taxels());
        for (const Branch& branch : common.branches) {
          TaxelBranch b{branch.ascending, {}, {}};
          for (auto i = static_cast<std::size_t>(branch.first); i <= static_cast<std::size_t>(branch.last); ++i) {
            b.pressure_psi.push_back(common.pressure_psi[i]);
            b.volts.push_back(common.values[i * width + taxel]);
          }
          own.branches.push_back(std::move(b));
        }
      }
      list.push_back(std::move(own));
    }
    return list;
  }();
  return all;
}

// Time is per taxel: an iteration goes over all of them.
void per_taxel(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(taxels().size()));
}

void elam_plain_j(benchmark::State& state) {
  std::vector<ElamModel> models;
  for (const Taxel& taxel : taxels())
    models.push_back(identify_elam(taxel.ascending, taxel.descending, taxel.branches).model);
  for (auto _ : state)
    for (std::size_t i = 0; i < models.size(); ++i)
      benchmark::DoNotOptimize(tactbench::bench::plain_j(models[i], taxels()[i].branches));
  per_taxel(state);
}
BENCHMARK(elam_plain_j)->Unit(benchmark::kMicrosecond);

void elam_identify(benchmark::State& state, Dispatch level) {
  force_lane_dispatch(level);
  for (auto _ : state)
    for (const Taxel& taxel : taxels())
      benchmark::DoNotOptimize(identify_elam(taxel.ascending, taxel.descending, taxel.branches).j_v2);
  unforce_lane_dispatch();
  per_taxel(state);
}

const bool registered = [] {
  for (const Dispatch level : dispatches())
    benchmark::RegisterBenchmark((std::string("elam_identify/") + to_string(level)).c_str(), elam_identify, level)
        ->Unit(benchmark::kMicrosecond);
  return true;
}();

// Arguments: rows and columns, threads.
void elam_fit_array(benchmark::State& state) {
  const Dataset data = dataset_of(static_cast<int>(state.range(0)));
  FitOptions options;
  options.threads = static_cast<int>(state.range(1));
  for (auto _ : state) benchmark::DoNotOptimize(fit_array(data, options).full_scale_v());
  state.SetItemsProcessed(state.iterations() * data.taxels());
}
BENCHMARK(elam_fit_array)
    ->Args({8, 1})
    ->Args({8, 2})
    ->Args({16, 1})
    ->Args({16, 2})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
