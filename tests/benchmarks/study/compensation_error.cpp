#include "tests/benchmarks/study/compensation_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/compensate/inverse_stream.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/identify/streams/recording_stream.h"
#include "analysis/identify/taxel_stream.h"
#include "analysis/statistics/scoring/score.h"
#include "analysis/workers.h"
#include "tests/benchmarks/study/simulated_run.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

struct Condition {
  const char* name;
  SimulatedRun made;
  double goal = 0.0;        // of the dynamic compensator's mean error, psi; paper's specimen
  double most_goal = 0.0;   // of its largest; 0: none
  double harsh_goal = 0.0;  // of its mean error on the harsh specimen, as a share of ELAM's stream's
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
      {"random_1", {{"random-reversal"}, {"recipe.seed=1"}}, 0.19, 5.0, 0.5},
      {"random_2", {{"random-reversal"}, {"recipe.seed=7"}}, 0.19, 5.0, 0.5},
      {"dwell_0.2_s", {{"random-reversal"}, {"recipe.dwell_s=0.2"}}, 0.22, 0.0, 0.5},
      {"dwell_10_s", {{"random-reversal"}, {"recipe.dwell_s=10"}}, 0.22, 0.0, 0.5},
      {"random_to_54_psi", {{"random-reversal"}, {"recipe.random.high=54"}}},
      {"same", {{"descending", "ascending"}, {"recipe.repeats=1"}}},
      {"remounted", {{"descending", "ascending"}, once(remounted)}, 0.52, 0.0, 1.0},
      {"month_and_5_degrees", {{"descending", "ascending"}, once(month)}, 0.77, 0.0, 1.0},
      {"remounted_random", {{"random-reversal"}, remounted}, 0.0, 0.0, 1.0},
      {"month_and_5_degrees_random", {{"random-reversal"}, month}, 0.0, 0.0, 1.0},
  };
  return list;
}

struct CoveredErrors {
  ErrorSum error;
  double covered = 0.0;  // samples whose error is within twice the uncertainty
  void add(const CoveredErrors& other) {
    error.add(other.error);
    covered += other.covered;
  }
};

// Means of all sensors, by condition; `others` by condition and model.
struct ErrorsOfSpecimen {
  std::map<std::string, CoveredErrors> dynamic, alone, elam;  // alone: the dynamic model without lag and creep
  std::map<std::string, ErrorSum> others;
};

template <class Errors>
Errors total_of(const std::vector<Errors>& taxels) {
  Errors all;
  for (const Errors& own : taxels) all.add(own);
  return all;
}

CoveredErrors of_stream(const Dataset& data, const SensorModel& fit) {
  std::vector<CoveredErrors> errors(fit.taxels.size());
  const auto width = static_cast<std::size_t>(data.taxels());
  for_each_index(width, 0, [&](std::size_t taxel) {
    if (!fit.taxels[taxel].fitted()) return;
    RecordingStream stream(fit, fit.taxels[taxel]);
    stream_samples(
        data, stream, [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * width + taxel]; },
        [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
          const double error = std::abs(now.pressure_psi - data.sequences[s].repeats[r].steps[i].reference_psi);
          errors[taxel].error.add(error);
          errors[taxel].covered += error <= 2.0 * now.uncertainty_psi ? 1.0 : 0.0;
        });
  });
  return total_of(errors);
}

constexpr std::size_t kFittedEvery = 8;  // taxels

// Any model by the one rule of comparison, every eighth taxel; without a model where the taxel cannot be fitted.
std::vector<ModelFit> every_eighth(const Histories& histories, const std::string& name, bool linearise) {
  IdentifyOptions options;
  options.linearise = linearise;
  std::vector<ModelFit> fits(static_cast<std::size_t>(histories.rows * histories.columns) / kFittedEvery);
  for_each_index(fits.size(), 0, [&](std::size_t k) {
    const TaxelHistories& taxel = histories.taxels[k * kFittedEvery];
    if (taxel.usable()) fits[k] = identify(name, fit_data_of(taxel, {}), options);
  });
  return fits;
}

ErrorSum of_model(const std::vector<ModelFit>& fits, const Histories& histories, const Histories& scored) {
  std::vector<ErrorSum> errors(fits.size());
  for_each_index(fits.size(), 0, [&](std::size_t k) {
    if (fits[k].model == nullptr) return;
    InverseStream stream(*fits[k].model, kBandInNoises * histories.taxels[k * kFittedEvery].noise);
    for (const History& history : scored.taxels[k * kFittedEvery].score)
      for (std::size_t i = 0; i < history.x.size(); ++i)
        errors[k].add(std::abs(stream.step(history.y[i]) - history.x[i]));
  });
  return total_of(errors);
}

void add_sensor(ErrorsOfSpecimen& errors, const SimulatedSensor& sensor, const std::string& folder, bool all_models) {
  db::RunStore store = db::RunStore::open(fmt::format("{}/{}-{}.db", folder, sensor.seed, word_of(sensor.kind)),
                                          db::Durability::kNormal);
  unsigned seed = 1;
  const auto run = [&](const SimulatedRun& made) { return simulate_run(made, sensor, seed++, store).data; };
  const Dataset fitted = run({{"descending", "ascending"}, {}});
  const Dataset rate = run({{"rate"}, {}}), creep = run({{"creep-levels"}, {}});
  const SensorModel elam_fit = fit_array(fitted);
  const SensorModel dynamic_fit = fit_dynamic(fitted, rate, creep), alone_fit = fit_dynamic_alone(fitted);
  const Histories histories = all_models ? histories_of(fitted) : Histories();
  std::map<std::string, std::vector<ModelFit>> other_fits;
  if (all_models)
    for (const char* const model : model_names())
      for (const bool linearise : {false, true})
        other_fits[fmt::format("{}{}", model, linearise ? "_linearised" : "")] =
            every_eighth(histories, model, linearise);
  for (const Condition& condition : conditions()) {
    const Dataset data = run(condition.made);
    errors.elam[condition.name].add(of_stream(data, elam_fit));
    errors.dynamic[condition.name].add(of_stream(data, dynamic_fit));
    errors.alone[condition.name].add(of_stream(data, alone_fit));
    if (!all_models) continue;
    const Histories scored = histories_of(data);
    for (const auto& [model, fits] : other_fits)
      errors.others[fmt::format("{}_{}", condition.name, model)].add(of_model(fits, histories, scored));
  }
}

void add_figures(FigureList& figures, const ErrorsOfSpecimen& errors, SpecimenKind kind) {
  const bool paper = kind == SpecimenKind::kPaper, harsh = kind == SpecimenKind::kHarsh;
  const std::string prefix = paper ? "" : word_of(kind) + "_";
  for (const Condition& condition : conditions()) {
    const CoveredErrors& ours = errors.dynamic.at(condition.name);
    const CoveredErrors& theirs = errors.elam.at(condition.name);
    const ErrorSum &own = ours.error, &elam = theirs.error;
    const std::string name = prefix + condition.name;
    const auto add = [&](const std::string& what, double value, double goal, const char* unit) {
      if (goal > 0.0)
        figures.add_at_most(what, value, goal, unit);
      else
        figures.add(what, value, unit);
    };
    add(name, own.mean(), paper ? condition.goal : 0.0, "psi");
    add(name + "_most", own.max, paper ? condition.most_goal : 0.0, "psi");
    figures.add(name + "_within_2_u", 100.0 * ours.covered / own.samples, "%");
    const CoveredErrors& alone = errors.alone.at(condition.name);
    figures.add(name + "_one_run", alone.error.mean(), "psi");
    figures.add(name + "_one_run_most", alone.error.max, "psi");
    figures.add(name + "_one_run_within_2_u", 100.0 * alone.covered / alone.error.samples, "%");
    figures.add(name + "_elam_stream", elam.mean(), "psi");
    figures.add(name + "_elam_stream_most", elam.max, "psi");
    figures.add(name + "_elam_stream_within_2_u", 100.0 * theirs.covered / elam.samples, "%");
    if (!paper) add(name + "_of_elam_stream", own.mean() / elam.mean(), harsh ? condition.harsh_goal : 0.0, "ratio");
  }
  for (const auto& [name, other] : errors.others) figures.add(prefix + name, other.mean(), "psi");
}

}  // namespace

std::vector<Figure> benchmark_compensation_error(const std::vector<SpecimenKind>& specimens,
                                                 const std::vector<unsigned>& sensor_seeds, const std::string& folder,
                                                 bool all_models) {
  FigureList figures("compensation-error");
  for (const SpecimenKind kind : specimens) {
    ErrorsOfSpecimen errors;
    for (const unsigned seed : sensor_seeds) add_sensor(errors, {kind, seed}, folder, all_models);
    add_figures(figures, errors, kind);
  }
  return figures.take();
}

}  // namespace tactbench::bench
