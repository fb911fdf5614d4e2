#include "bench/benchmarks/identify.h"

#include <fmt/format.h>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/elam/elam_samples.h"
#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "bench/benchmarks/simulated_run.h"
#include "bench/benchmarks/synthetic_array.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

constexpr int kSide = 16, kRepeats = 5;
constexpr std::size_t kFew = 8;  // taxels for what takes milliseconds each

struct Taxel {
  FitData data;
  std::vector<TaxelBranch> branches;
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

ElamFit exact(const Taxel& taxel) { return identify_elam(taxel.data.ascending, taxel.data.descending, taxel.branches); }

void identify_all(const std::vector<Taxel>& taxels) {
  for (const Taxel& taxel : taxels) keep(exact(taxel).j_v2);
}

double fit_seconds(int rounds, const Dataset& dataset, int threads, By by) {
  FitOptions options;
  options.threads = threads;
  return best_seconds(
      rounds, [&] { keep(fit_array(dataset, options).full_scale_v()); }, by);
}

void time_elam(FigureList& figures, const std::vector<Taxel>& taxels, int rounds) {
  const auto count = static_cast<double>(taxels.size());
  std::vector<ElamModel> models;
  for (const Taxel& taxel : taxels) models.push_back(exact(taxel).model);
  // In turn: the processor's speed changes with what else runs on it.
  std::vector<std::function<void()>> acts{[&] {
    for (std::size_t i = 0; i < taxels.size(); ++i) keep(plain_j(models[i], taxels[i].branches));
  }};
  for (const Dispatch level : dispatches())
    acts.emplace_back([&taxels, level] {
      force_lane_dispatch(level);
      identify_all(taxels);
    });
  const std::vector<double> taken = best_seconds(rounds, acts, By::kProcessor);
  unforce_lane_dispatch();
  figures.add("plain_j", 1e6 * taken[0] / count, "us");
  for (std::size_t i = 0; i < dispatches().size(); ++i) {
    const Dispatch level = dispatches()[i];
    const double own = taken[i + 1];
    figures.add(fmt::format("elam_{}", to_string(level)), 1e6 * own / count, "us/taxel");
    figures.add_at_most(fmt::format("elam_{}_in_plain_j", to_string(level)), own / taken[0],
                        level == Dispatch::kBase ? 100.0 : 50.0);
  }
  figures.add("elam_in_plain_j_stretch_base", 50.0, "x");
  figures.add("elam_in_plain_j_stretch_avx2", 15.0, "x");
}

void time_genetic(FigureList& figures, const std::vector<Taxel>& taxels) {
  if (!has_genetic()) return;
  double j_exact = 0.0, j_genetic = 0.0, worst = 0.0;
  std::vector<double> least(kFew);
  const std::vector<double> taken =
      best_seconds(1,
                   {[&] {
                      for (std::size_t i = 0; i < kFew; ++i) j_exact += least[i] = exact(taxels[i]).j_v2;
                    },
                    [&] {
                      for (std::size_t i = 0; i < kFew; ++i) {
                        const FitData& data = taxels[i].data;
                        const double j = identify_elam_ga(data.ascending, data.descending, taxels[i].branches).j_v2;
                        j_genetic += j;
                        worst = std::max(worst, j / least[i]);
                      }
                    }},
                   By::kProcessor);
  figures.add("elam_genetic", 1e6 * taken[1] / static_cast<double>(kFew), "us/taxel");
  figures.add("elam_genetic_time_over_exact", taken[1] / taken[0], "x");
  figures.add("elam_genetic_j_over_exact", j_genetic / j_exact, "x");
  figures.add("elam_genetic_j_over_exact_worst_taxel", worst, "x");
}

// From a stored run to the parameters of all taxels, against reading its frames and identifying alone.
void time_store(FigureList& figures, const Dataset& dataset, const std::string& folder, int rounds) {
  db::RunStore store = db::RunStore::open(folder + "/identify.db", db::Durability::kNormal);
  const std::int64_t run = store_run(store, dataset);
  const std::vector<Taxel> taxels = taxels_of(load_dataset(store, run));
  FitOptions options;
  options.threads = 1;
  const std::vector<double> taken =
      best_seconds(rounds,
                   {[&] { keep(store.frames(run).size()); }, [&] { identify_all(taxels); },
                    [&] { keep(fit_array(load_dataset(store, run), options).full_scale_v()); }},
                   By::kProcessor);
  figures.add("array_reading", 1e3 * taken[0], "ms");
  figures.add("array_identification_alone", 1e3 * taken[1], "ms");
  figures.add("array_from_store", 1e3 * taken[2], "ms");
  figures.add_at_most("array_over_floor", taken[2] / (taken[0] + taken[1]), 1.5);
}

void time_threads_and_growth(FigureList& figures, const Dataset& dataset, int rounds) {
  figures.add_at_least("two_threads_speedup",
                       fit_seconds(rounds, dataset, 1, By::kWall) / fit_seconds(rounds, dataset, 2, By::kWall), 1.7);
  double first = 0.0;
  for (const int side : {16, 32, 64}) {
    const double per_taxel = fit_seconds(rounds, synthetic_dataset(side, side, 1), 1, By::kProcessor) / (side * side);
    figures.add(fmt::format("growth_{0}x{0}", side), 1e6 * per_taxel, "us/taxel");
    if (side == 16) first = per_taxel;
    if (side == 64) figures.add("growth_64x64_over_16x16", per_taxel / first, "x");
  }
}

// 256 taxels from the paper's run, one of `rate` and one of `creep-levels`, on two threads.
void time_dynamic(FigureList& figures, const std::string& folder, int rounds) {
  db::RunStore store = db::RunStore::open(folder + "/dynamic.db", db::Durability::kNormal);
  const auto run = [&](const SimulatedRun& made, unsigned seed) { return simulate_run(made, {}, seed, store).data; };
  const Dataset fitted = run({{"descending", "ascending"}, {}}, 1), rate = run({{"rate"}, {}}, 2),
                creep = run({{"creep-levels"}, {}}, 3);
  DynamicFitOptions options;
  options.threads = 2;
  const auto fit = [&] { keep(fit_dynamic(fitted, rate, creep, options).full_scale_v()); };
  figures.add_at_most("dynamic_array", best_seconds(rounds, fit), 1.0, "s");
}

// Each against its own plain J: one evaluation of the fitted model along all samples.
void time_models(FigureList& figures, const std::vector<Taxel>& taxels, int rounds) {
  for (const char* name : {"gpi", "mpi", "poly", "preisach"}) {
    const auto identifier = prepare(name, taxels.front().data);
    std::vector<ModelFit> fits;
    for (std::size_t i = 0; i < kFew; ++i) fits.push_back(identifier->fit(taxels[i].data));
    const std::vector<double> taken = best_seconds(rounds,
                                                   {[&] {
                                                      for (std::size_t i = 0; i < kFew; ++i)
                                                        keep(identifier->fit(taxels[i].data).j);
                                                    },
                                                    [&] {
                                                      for (std::size_t i = 0; i < kFew; ++i)
                                                        for (const History& history : taxels[i].data.histories)
                                                          keep(predict_history(*fits[i].model, history, false));
                                                    }},
                                                   By::kProcessor);
    figures.add(name, 1e6 * taken[0] / static_cast<double>(kFew), "us/taxel");
    figures.add(fmt::format("{}_in_walks", name), taken[0] / taken[1], "x");
  }
}

}  // namespace

double plain_j(const analysis::ElamModel& model, std::span<const analysis::TaxelBranch> branches) {
  double j = 0.0;
  for (const analysis::TaxelBranch& branch : branches) {
    const analysis::TurningPoint turn = analysis::turning_point(model, branch);
    const analysis::ElamCurve curve(model, branch.ascending, turn.x, turn.y);
    for (std::size_t i = 1; i < branch.volts.size(); ++i) {
      const double error = curve.output(branch.pressure_psi[i]) - branch.volts[i];
      j += error * error;
    }
  }
  return j;
}

std::vector<Figure> benchmark_identify(int rounds, const std::string& folder) {
  const Dataset dataset = synthetic_dataset(kSide, kSide, kRepeats);
  const std::vector<Taxel> taxels = taxels_of(dataset);
  FigureList figures("identify");
  time_elam(figures, taxels, rounds);
  time_genetic(figures, taxels);
  time_store(figures, dataset, folder, rounds);
  time_threads_and_growth(figures, dataset, rounds);
  time_models(figures, taxels, rounds);
  time_dynamic(figures, folder, rounds);
  return figures.take();
}

}  // namespace tactbench::bench
