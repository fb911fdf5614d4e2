#include "bench/benchmarks/compensation_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/compensate/dynamic_compensator.h"
#include "analysis/compensate/inverse_stream.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/streams.h"
#include "analysis/workers.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/run/characterize.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

struct Condition {
  const char* name;
  std::vector<const char*> recipes;
  std::vector<std::string> set;
  double goal = 0.0;       // of the dynamic compensator's mean error, psi
  double most_goal = 0.0;  // of its largest; 0: none
};

const std::vector<Condition>& conditions() {
  const std::vector<std::string> remounted = {"simulation.mount_seed=1", "simulation.effects.remount_variation=0.03"};
  const std::vector<std::string> month = {"simulation.temperature_c=28", "simulation.age_months=1",
                                          "simulation.effects.gain_drift_per_month=0.01",
                                          "simulation.effects.zero_drift_v_per_month=0.01"};
  const auto once = [](std::vector<std::string> set) {
    set.emplace_back("recipe.repeats=1");
    return set;
  };
  static const std::vector<Condition> list = {
      {"random_1", {"random-reversal"}, {"recipe.seed=1"}, 0.19, 5.0},
      {"random_2", {"random-reversal"}, {"recipe.seed=7"}, 0.19, 5.0},
      {"dwell_0.2_s", {"random-reversal"}, {"recipe.dwell_s=0.2"}, 0.22},
      {"dwell_10_s", {"random-reversal"}, {"recipe.dwell_s=10"}, 0.22},
      {"random_to_54_psi", {"random-reversal"}, {"recipe.random.high=54"}},
      {"same", {"descending", "ascending"}, {"recipe.repeats=1"}},
      {"remounted", {"descending", "ascending"}, once(remounted), 0.52},
      {"month_and_5_degrees", {"descending", "ascending"}, once(month), 0.77},
      {"remounted_random", {"random-reversal"}, remounted},
      {"month_and_5_degrees_random", {"random-reversal"}, month},
  };
  return list;
}

Dataset carry_out(const Condition& condition, unsigned sensor_seed, unsigned seed, db::RunStore& store) {
  const SplitOverrides overrides = split_overrides(condition.set);
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), overrides.bench, {seed, sensor_seed});
  for (const char* name : condition.recipes)
    request.recipes.push_back(sequences::read_recipe(find_recipe(name), overrides.recipe));
  request.overrides = overrides.all;
  request.sensor_type = read_sensor_type(find_config("sensor.toml"));
  request.sensor = {fmt::format("SIM-{:04}", sensor_seed),
                    request.sensor_type.name,
                    request.sensor_type.text,
                    db::sha256_hex(request.sensor_type.text),
                    SimulationConfig().scanner_serial,
                    "",
                    utc_now()};
  if (!store.sensor(request.sensor.serial)) store.add_sensor(request.sensor);
  request.operator_name = "benchmark";
  request.check_seating = false;
  Progress quiet(Progress::Mode::kQuiet);
  const RunResult result = characterize(request, store, quiet);
  if (result.error) throw *result.error;
  return load_dataset(store, result.run);
}

struct Errors {
  double sum = 0.0, count = 0.0, most = 0.0, covered = 0.0;
  void add(double error) {
    sum += error;
    count += 1.0;
    most = std::max(most, error);
  }
  void add(const Errors& other) {
    sum += other.sum;
    count += other.count;
    covered += other.covered;
    most = std::max(most, other.most);
  }
};

Errors of_elam(const Dataset& data, const SensorModel& fit) {
  std::vector<Errors> errors(fit.taxels.size());
  compensate_in_order(data, fit, 0, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      errors[taxel].add(std::abs(now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi));
    };
  });
  Errors all;
  for (const Errors& own : errors) all.add(own);
  return all;
}

// The stream begins where conditioning, which has no frames, ended: it is told how long that was.
Errors of_dynamic(const Dataset& data, DynamicSetup setup) {
  const Sample& begin = data.sequences.front().repeats.front().steps.front();
  setup.worked_s = std::max(0.0, begin.time_s - begin.held_s);
  const std::size_t width = setup.taxels.size();
  std::vector<Errors> errors(width);
  for_each_index(width, 0, [&](std::size_t taxel) {
    if (!setup.taxels[taxel].usable) return;
    DynamicTaxelCompensator compensator(setup, taxel);
    double before = -1.0;
    for (const SequenceData& sequence : data.sequences)
      for (const Repeat& repeat : sequence.repeats)
        for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
          const Sample& sample = repeat.steps[i];
          const double seconds = before < 0.0 ? 0.0 : sample.time_s - before;
          before = sample.time_s;
          const Compensated now = compensator.step(repeat.volts[i * width + taxel], seconds);
          const double error = std::abs(now.pressure_psi - sample.reference_psi);
          errors[taxel].add(error);
          errors[taxel].covered += error <= 2.0 * now.uncertainty_psi ? 1.0 : 0.0;
        }
  });
  Errors all;
  for (const Errors& own : errors) all.add(own);
  return all;
}

// Any model by the one rule of comparison, every eighth taxel.
Errors of_model(const Histories& histories, const Histories& scored, const std::string& name, bool linearise) {
  constexpr std::size_t kEvery = 8;
  IdentifyOptions options;
  options.linearise = linearise;
  const std::size_t width = static_cast<std::size_t>(histories.rows * histories.columns);
  std::vector<Errors> errors(width / kEvery);
  for_each_index(errors.size(), 0, [&](std::size_t k) {
    const TaxelHistories& taxel = histories.taxels[k * kEvery];
    if (!taxel.usable()) return;
    const ModelFit fit = identify(name, fit_data_of(taxel, {}), options);
    InverseStream stream(*fit.model, kBandInNoises * taxel.noise);
    for (const History& history : scored.taxels[k * kEvery].score)
      for (std::size_t i = 0; i < history.x.size(); ++i)
        errors[k].add(std::abs(stream.step(history.y[i]) - history.x[i]));
  });
  Errors all;
  for (const Errors& own : errors) all.add(own);
  return all;
}

}  // namespace

std::vector<Figure> benchmark_compensation_error(const std::vector<unsigned>& sensor_seeds, const std::string& folder,
                                                 bool all_models) {
  FigureList figures("compensation-error");
  std::map<std::string, Errors> dynamic, elam, others;  // others: by condition and model
  for (const unsigned sensor_seed : sensor_seeds) {
    db::RunStore store = db::RunStore::open(fmt::format("{}/{}.db", folder, sensor_seed), db::Durability::kNormal);
    unsigned seed = 1;
    const auto run = [&](const Condition& condition) { return carry_out(condition, sensor_seed, seed++, store); };
    const Dataset fitted = run({"", {"descending", "ascending"}, {}});
    const Dataset rate = run({"", {"rate"}, {}}), creep = run({"", {"creep-levels"}, {}});
    const SensorModel elam_fit = fit_array(fitted);
    const DynamicFit fit = fit_dynamic(fitted, &rate, &creep);
    for (const Condition& condition : conditions()) {
      const Dataset data = run(condition);
      elam[condition.name].add(of_elam(data, elam_fit));
      dynamic[condition.name].add(of_dynamic(data, fit.setup));
      if (!all_models) continue;
      const Histories histories = histories_of(fitted), scored = histories_of(data);
      for (const char* const model : model_names())
        for (const bool linearise : {false, true})
          others[fmt::format("{}_{}{}", condition.name, model, linearise ? "_linearised" : "")].add(
              of_model(histories, scored, model, linearise));
    }
  }
  for (const Condition& condition : conditions()) {
    const Errors &own = dynamic[condition.name], &other = elam[condition.name];
    const std::string name = condition.name;
    if (condition.goal > 0.0)
      figures.add_at_most(name, own.sum / own.count, condition.goal, "psi");
    else
      figures.add(name, own.sum / own.count, "psi");
    if (condition.most_goal > 0.0)
      figures.add_at_most(name + "_most", own.most, condition.most_goal, "psi");
    else
      figures.add(name + "_most", own.most, "psi");
    figures.add(name + "_within_2_u", 100.0 * own.covered / own.count, "%");
    figures.add(name + "_elam_stream", other.sum / other.count, "psi");
    figures.add(name + "_elam_stream_most", other.most, "psi");
  }
  for (const auto& [name, errors] : others) figures.add(name, errors.sum / errors.count, "psi");
  return figures.take();
}

}  // namespace tactbench::bench
