// Identification: ELAM of a taxel in units of one plain J over its 660 samples; an array from the store to
// its parameters; threads; growth; the genetic search of the paper; the dynamic model of an array.
#include "analysis/identify/elam/elam.h"

#include <benchmark/benchmark.h>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/fit_models.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"
#include "bench/common/private_files.h"
#include "tests/benchmarks/speed/ratios.h"
#include "tests/benchmarks/speed/synthetic_array.h"
#include "tests/benchmarks/study/simulated_run.h"

namespace tactbench::speed {
namespace {

using namespace analysis;

constexpr int kSide = 16, kRepeats = 5;
constexpr std::size_t kFew = 8;  // taxels for the genetic search, which takes 0.1 s each

struct Taxel {
  FitData data;
  std::vector<TaxelBranch> branches;
  [[nodiscard]] ElamFit fit() const { return identify_elam(data.ascending, data.descending, branches); }
};

std::vector<Taxel> taxels_of(const Dataset& dataset) {
  std::vector<Taxel> taxels;
  for (const TaxelHistories& histories : histories_of(dataset).taxels) {
    if (histories.taxel == kMeanTaxel) continue;
    Taxel taxel{fit_data_of(histories, {}), {}};
    for (const History& history : taxel.data.histories)
      for (const Branch& branch : history.branches)
        taxel.branches.push_back({branch.ascending,
                                  {history.x.begin() + branch.first, history.x.begin() + branch.last + 1},
                                  {history.y.begin() + branch.first, history.y.begin() + branch.last + 1}});
    taxels.push_back(std::move(taxel));
  }
  return taxels;
}

const Dataset& dataset() {
  static const Dataset made = synthetic_dataset(kSide, kSide, kRepeats);
  return made;
}
const std::vector<Taxel>& taxels() {
  static const std::vector<Taxel> made = taxels_of(dataset());
  return made;
}

// Time is per taxel: an iteration goes over so many.
void per_taxel(benchmark::State& state, std::size_t count) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

// J written plainly: turning points, curves, residuals.
double plain_j(const ElamModel& model, const std::vector<TaxelBranch>& branches) {
  double j = 0.0;
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    const ElamCurve curve(model, branch.ascending, turn.x, turn.y);
    for (std::size_t i = 1; i < branch.volts.size(); ++i) {
      const double error = curve.output(branch.pressure_psi[i]) - branch.volts[i];
      j += error * error;
    }
  }
  return j;
}

void elam_plain_j(benchmark::State& state) {
  std::vector<ElamModel> models;
  for (const Taxel& taxel : taxels()) models.push_back(taxel.fit().model);
  for (auto _ : state)
    for (std::size_t i = 0; i < models.size(); ++i) benchmark::DoNotOptimize(plain_j(models[i], taxels()[i].branches));
  per_taxel(state, taxels().size());
}
BENCHMARK(elam_plain_j)->Name("identify/evaluate_j")->Unit(benchmark::kMicrosecond);

void elam(benchmark::State& state) {
  (void)taxels();
  for (auto _ : state)
    for (const Taxel& taxel : taxels()) benchmark::DoNotOptimize(taxel.fit().j_v2);
  per_taxel(state, taxels().size());
}
BENCHMARK(elam)->Name("identify/elam")->Unit(benchmark::kMicrosecond);

const bool registered =
    declare({{"identify_elam_over_evaluate_j", "identify/elam", {"identify/evaluate_j"}, 100.0},
             {"identify_genetic_time_over_exact", "identify/few_taxels_genetic", {"identify/few_taxels_exact"}},
             {"identify_array_over_minimum",
              "identify/read_and_fit_elam",
              {"identify/read_frames", "identify/fit_elam_of_stored_frames"},
              1.5},
             {"identify_two_threads_speedup", "identify/fit_array/16/1", {"identify/fit_array/16/2"}, 0.0, 1.7},
             {"identify_growth_64_over_16", "identify/fit_array/64/1", {"identify/fit_array/16/1"}}});

void few(benchmark::State& state, bool genetic) {
  if (genetic && !has_genetic()) return state.SkipWithError("this build has no genetic search");
  double j = 0.0;
  for (auto _ : state) {
    j = 0.0;
    for (std::size_t t = 0; t < kFew; ++t) {
      const Taxel& own = taxels()[t];
      j += genetic ? identify_elam_ga(own.data.ascending, own.data.descending, own.branches).j_v2 : own.fit().j_v2;
    }
  }
  state.counters["j [V2]"] = j;
  per_taxel(state, kFew);
}
BENCHMARK_CAPTURE(few, exact, false)->Name("identify/few_taxels_exact")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(few, genetic, true)
    ->Name("identify/few_taxels_genetic")
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(1);

// A stored run of that array.
struct Stored {
  bench::ScratchFolder folder{"tactbench-speed"};
  db::RunStore store = db::RunStore::open(folder.path() + "/identify.db", db::Durability::kNormal);
  std::int64_t run = store_run(store, dataset());
  std::vector<Taxel> taxels = taxels_of(load_dataset(store, run));
};
Stored& stored() {
  static Stored made;
  return made;
}

void read_frames(benchmark::State& state) {
  (void)stored();
  for (auto _ : state) benchmark::DoNotOptimize(stored().store.frames(stored().run).size());
}
void stored_elam(benchmark::State& state) {
  (void)stored();
  for (auto _ : state)
    for (const Taxel& taxel : stored().taxels) benchmark::DoNotOptimize(taxel.fit().j_v2);
}
void from_store(benchmark::State& state) {
  FitOptions options;
  options.threads = 1;
  (void)stored();
  for (auto _ : state)
    benchmark::DoNotOptimize(fit_array(load_dataset(stored().store, stored().run), options).full_scale_v());
}
BENCHMARK(read_frames)->Name("identify/read_frames")->Unit(benchmark::kMillisecond);
BENCHMARK(stored_elam)->Name("identify/fit_elam_of_stored_frames")->Unit(benchmark::kMillisecond);
BENCHMARK(from_store)->Name("identify/read_and_fit_elam")->Unit(benchmark::kMillisecond);

// Arguments: taxels a side, threads.
void fit_array_of(benchmark::State& state) {
  const Dataset data = synthetic_dataset(static_cast<int>(state.range(0)), static_cast<int>(state.range(0)), 1);
  FitOptions options;
  options.threads = static_cast<int>(state.range(1));
  for (auto _ : state) benchmark::DoNotOptimize(fit_array(data, options).full_scale_v());
  per_taxel(state, static_cast<std::size_t>(data.taxels()));
}
BENCHMARK(fit_array_of)
    ->Name("identify/fit_array")
    ->Args({16, 1})
    ->Args({16, 2})
    ->Args({64, 1})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

// 256 taxels from the paper's run, one of `rate` and one of `creep-levels`, on two threads.
void dynamic_array(benchmark::State& state) {
  static const std::vector<Dataset> runs = [] {
    const bench::ScratchFolder folder("tactbench-speed");
    db::RunStore store = db::RunStore::open(folder.path() + "/dynamic.db", db::Durability::kNormal);
    std::vector<Dataset> made;
    for (const std::vector<std::string>& recipes :
         std::vector<std::vector<std::string>>{{std::string("descending"), "ascending"}, {"rate"}, {"creep-levels"}})
      made.push_back(bench::simulate_run({recipes, {}}, {}, static_cast<unsigned>(made.size()) + 1, store).data);
    return made;
  }();
  DynamicFitOptions options;
  options.threads = 2;
  for (auto _ : state) benchmark::DoNotOptimize(fit_dynamic(runs[0], runs[1], runs[2], options).full_scale_v());
}
BENCHMARK(dynamic_array)->Name("identify/dynamic_array")->Unit(benchmark::kSecond)->UseRealTime();

}  // namespace
}  // namespace tactbench::speed
