#include "bench/benchmarks/identify.h"

#include <fmt/format.h>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/elam/elam_samples.h"
#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "bench/benchmarks/synthetic_array.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

using Taxels = std::vector<TaxelToIdentify>;

ElamFit exact(const TaxelToIdentify& taxel) {
  return identify_elam(taxel.data.ascending, taxel.data.descending, taxel.branches);
}

void identify_all(const Taxels& taxels) {
  for (const TaxelToIdentify& taxel : taxels) keep(exact(taxel).j_v2);
}

double fit_seconds(int rounds, const Dataset& dataset, int threads, By by) {
  FitOptions options;
  options.threads = threads;
  return best_seconds(
      rounds, [&] { keep(fit_array(dataset, options).full_scale_v()); }, by);
}

void time_elam(IdentifyTimes& times, const Taxels& taxels, int rounds) {
  std::vector<ElamModel> models;
  for (const TaxelToIdentify& taxel : taxels) models.push_back(exact(taxel).model);
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
  times.taxels = static_cast<int>(taxels.size());
  times.plain_j = taken[0];
  for (std::size_t i = 0; i < dispatches().size(); ++i)
    times.levels.emplace_back(to_string(dispatches()[i]), taken[i + 1]);
}

void time_genetic(IdentifyTimes& times, std::span<const TaxelToIdentify> few) {
  if (!has_genetic()) return;
  const std::vector<double> taken =
      best_seconds(1,
                   {[&] {
                      for (const TaxelToIdentify& taxel : few) times.exact_j.push_back(exact(taxel).j_v2);
                    },
                    [&] {
                      for (const TaxelToIdentify& taxel : few)
                        times.genetic_j.push_back(
                            identify_elam_ga(taxel.data.ascending, taxel.data.descending, taxel.branches).j_v2);
                    }},
                   By::kProcessor);
  times.exact = taken[0];
  times.genetic = taken[1];
}

// From a stored run to the parameters of all taxels, against reading its frames and identifying alone.
void time_store(IdentifyTimes& times, const Dataset& dataset, const std::string& folder, int rounds) {
  db::RunStore store = db::RunStore::open(folder + "/identify.db", db::Durability::kNormal);
  const std::int64_t run = store_run(store, dataset);
  const Taxels taxels = taxels_to_identify(load_dataset(store, run));
  FitOptions options;
  options.threads = 1;
  const std::vector<double> taken =
      best_seconds(rounds,
                   {[&] { keep(store.frames(run).size()); }, [&] { identify_all(taxels); },
                    [&] { keep(fit_array(load_dataset(store, run), options).full_scale_v()); }},
                   By::kProcessor);
  times.reading = taken[0];
  times.alone = taken[1];
  times.from_store = taken[2];
}

// 256 taxels from the paper's run, one of `rate` and one of `creep-levels`, on two threads.
void time_dynamic(IdentifyTimes& times, const std::string& folder, int rounds, const Simulate& simulate) {
  db::RunStore store = db::RunStore::open(folder + "/dynamic.db", db::Durability::kNormal);
  const auto run = [&](const SimulatedRun& made, unsigned seed) { return simulate(made, {}, seed, store).data; };
  const Dataset fitted = run({{"descending", "ascending"}, {}}, 1), rate = run({{"rate"}, {}}, 2),
                creep = run({{"creep-levels"}, {}}, 3);
  DynamicFitOptions options;
  options.threads = 2;
  times.dynamic = best_seconds(rounds, [&] { keep(fit_dynamic(fitted, rate, creep, options).full_scale_v()); });
}

// Each against its own plain J: one evaluation of the fitted model along all samples.
void time_models(IdentifyTimes& times, std::span<const TaxelToIdentify> few, int rounds) {
  times.few = static_cast<int>(few.size());
  for (const char* name : {"gpi", "mpi", "poly", "preisach"}) {
    const auto identifier = prepare(name, few.front().data);
    std::vector<ModelFit> fits;
    for (const TaxelToIdentify& taxel : few) fits.push_back(identifier->fit(taxel.data));
    const std::vector<double> taken = best_seconds(rounds,
                                                   {[&] {
                                                      for (const TaxelToIdentify& taxel : few)
                                                        keep(identifier->fit(taxel.data).j);
                                                    },
                                                    [&] {
                                                      for (std::size_t i = 0; i < few.size(); ++i)
                                                        for (const History& history : few[i].data.histories)
                                                          keep(predict_history(*fits[i].model, history, false));
                                                    }},
                                                   By::kProcessor);
    times.models.push_back({name, taken[0], taken[1]});
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

std::vector<TaxelToIdentify> taxels_to_identify(const analysis::Dataset& dataset) {
  std::vector<TaxelToIdentify> taxels;
  for (const TaxelHistories& histories : histories_of(dataset).taxels) {
    if (histories.taxel == kMeanTaxel) continue;
    TaxelToIdentify taxel{fit_data_of(histories, {}), {}};
    for (const History& history : taxel.data.histories)
      for (const Branch& branch : history.branches)
        taxel.branches.push_back({branch.ascending,
                                  {history.x.begin() + branch.first, history.x.begin() + branch.last + 1},
                                  {history.y.begin() + branch.first, history.y.begin() + branch.last + 1}});
    taxels.push_back(std::move(taxel));
  }
  return taxels;
}

std::vector<Figure> benchmark_identify(int rounds, const std::string& folder, const IdentifySizes& sizes,
                                       const Simulate& simulate) {
  const Dataset dataset = synthetic_dataset(sizes.side, sizes.side, sizes.repeats);
  const Taxels taxels = taxels_to_identify(dataset);
  const auto few = std::span(taxels).first(sizes.few);
  IdentifyTimes times;
  time_elam(times, taxels, rounds);
  time_genetic(times, few);
  time_store(times, dataset, folder, rounds);
  times.one_thread = fit_seconds(rounds, dataset, 1, By::kWall);
  times.two_threads = fit_seconds(rounds, dataset, 2, By::kWall);
  for (const int side : sizes.growth)
    times.growth.emplace_back(side, fit_seconds(rounds, synthetic_dataset(side, side, 1), 1, By::kProcessor));
  time_models(times, few, rounds);
  time_dynamic(times, folder, rounds, simulate);
  return figures_of(times);
}

namespace {

void add_genetic(FigureList& figures, const IdentifyTimes& times) {
  if (times.genetic_j.empty()) return;
  double exact = 0.0, genetic = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < times.exact_j.size(); ++i) {
    exact += times.exact_j[i];
    genetic += times.genetic_j[i];
    worst = std::max(worst, times.genetic_j[i] / times.exact_j[i]);
  }
  figures.add("elam_genetic", 1e6 * times.genetic / static_cast<double>(times.genetic_j.size()), "us/taxel");
  figures.add("elam_genetic_time_over_exact", times.genetic / times.exact, "x");
  figures.add("elam_genetic_j_over_exact", genetic / exact, "x");
  figures.add("elam_genetic_j_over_exact_worst_taxel", worst, "x");
}

}  // namespace

std::vector<Figure> figures_of(const IdentifyTimes& times) {
  FigureList figures("identify");
  figures.add("plain_j", 1e6 * times.plain_j / times.taxels, "us");
  for (const auto& [level, own] : times.levels) {
    figures.add("elam_" + level, 1e6 * own / times.taxels, "us/taxel");
    figures.add_at_most("elam_" + level + "_in_plain_j", own / times.plain_j, level == "base" ? 100.0 : 50.0);
  }
  figures.add("elam_in_plain_j_stretch_base", 50.0, "x");
  figures.add("elam_in_plain_j_stretch_avx2", 15.0, "x");
  add_genetic(figures, times);
  figures.add("array_reading", 1e3 * times.reading, "ms");
  figures.add("array_identification_alone", 1e3 * times.alone, "ms");
  figures.add("array_from_store", 1e3 * times.from_store, "ms");
  figures.add_at_most("array_over_floor", times.from_store / (times.reading + times.alone), 1.5);
  figures.add_at_least("two_threads_speedup", times.one_thread / times.two_threads, 1.7);
  const auto per_taxel = [](const std::pair<int, double>& one) { return one.second / (one.first * one.first); };
  for (const auto& one : times.growth)
    figures.add(fmt::format("growth_{0}x{0}", one.first), 1e6 * per_taxel(one), "us/taxel");
  figures.add(fmt::format("growth_{0}x{0}_over_{1}x{1}", times.growth.back().first, times.growth.front().first),
              per_taxel(times.growth.back()) / per_taxel(times.growth.front()), "x");
  for (const auto& model : times.models) {
    figures.add(model.name, 1e6 * model.fit / times.few, "us/taxel");
    figures.add(model.name + "_in_walks", model.fit / model.walk, "x");
  }
  figures.add_at_most("dynamic_array", times.dynamic, 1.0, "s");
  return figures.take();
}

}  // namespace tactbench::bench
