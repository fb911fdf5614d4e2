#include "tests/benchmarks/study/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/report/runs.h"
#include "analysis/statistics/figures/step_kinds.h"
#include "analysis/statistics/figures/streams.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/reporting/report_budget.h"
#include "bench/reporting/report_results.h"
#include "tests/benchmarks/study/simulated_run.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

// The bench's thermometer, which the recipes do not need and the budget does.
constexpr const char* kThermometer =
    "environment.sensor=[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], "
    "span_c = [-100, 100]}]";
constexpr const char *kProduction = "production", *kWarm = "simulation.temperature_c=28";

constexpr int kGiven = 5, kUsed = 3;  // runs of each use of random reversals: given to the report, and counted

// How a sensor is used after its calibration, and the condition that the report states for it.
struct Use {
  const char* name;
  UseCondition condition;
  bool random;  // reversals; else the sequences of the calibration
  std::vector<const char*> set;
  bool full_sweeps = false;  // of its frames those on full sweeps count, else those on inner branches
};

const std::vector<Use>& uses() {
  static const std::vector<Use> list = {
      {"full_sweeps", UseCondition::kFullSweeps, false, {}, true},
      {"inner_branches", UseCondition::kFittedBranches, false, {}},
      {"random_reversals", UseCondition::kAnyHistory, true, {}},
      {"other_dwell", UseCondition::kOtherDwell, true, {"recipe.dwell_s=10"}},
      {"held", UseCondition::kHeld, true, {"recipe.dwell_s=25"}},
      {"other_temperature", UseCondition::kOtherTemperature, true, {kWarm}},
      {"remounted", UseCondition::kRemounted, true, {"simulation.effects.remount_variation=0.03"}},
      {"month_later",
       UseCondition::kLater,
       true,
       {kWarm, "simulation.age_months=1", "simulation.effects.gain_drift_per_month=0.01",
        "simulation.effects.zero_drift_v_per_month=0.01"}},
  };
  return list;
}

SimulatedRun run_of(const Use& use) {
  SimulatedRun made{{}, {use.set.begin(), use.set.end()}};
  if (use.random) made.recipes = {"random-reversal"};
  return made;
}

struct Covered {
  double inside = 0.0, not_valid = 0.0;  // pairs; sensors of which the report says that U does not cover the use
  std::vector<double> errors, expanded;  // of each pair
};
using Coverages = std::map<std::string, Covered>;  // by specimen, calibration, model and use
// The readings of a run by that fit, in the order of the taxels, against the pressures that are known and what is
// stated of them: those on full sweeps, or those on inner branches.
void add_errors(const KnownRun& run, const SensorModel& fit, const ConditionUncertainty& stated, bool full_sweeps,
                Covered& covered) {
  std::vector<std::vector<StepKind>> kinds;
  std::vector<std::vector<std::size_t>> first;  // frame of a repeat's first step
  std::size_t frames = 0;
  for (const SequenceData& sequence : run.data.sequences) {
    kinds.push_back(step_kinds(sequence, fit.pressure_psi.front(), fit.pressure_psi.back()));
    first.emplace_back();
    for (const Repeat& repeat : sequence.repeats) {
      first.back().push_back(frames);
      frames += repeat.steps.size();
    }
  }
  std::vector<Covered> taxels(fit.taxels.size());
  compensate_in_order(run.data, fit, 0, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      const StepKind& kind = kinds[s][i];
      if (kind.full != full_sweeps) return;
      const auto [known, expanded] = reading_uncertainty(stated, taxel, now.pressure_psi, kind.up);
      const double error = std::abs(now.pressure_psi - known - run.chamber_psi[first[s][r] + i]);
      taxels[taxel].inside += error <= expanded ? 1.0 : 0.0;
      taxels[taxel].errors.push_back(error);
      taxels[taxel].expanded.push_back(expanded);
    };
  });
  for (const Covered& own : taxels) {
    covered.inside += own.inside;
    covered.errors.insert(covered.errors.end(), own.errors.begin(), own.errors.end());
    covered.expanded.insert(covered.expanded.end(), own.expanded.begin(), own.expanded.end());
  }
}

// One sensor: its calibrations, what a careful user gives beside them, and its uses.
class CoverageOfSensor {
 public:
  CoverageOfSensor(const SimulatedSensor& sensor, const CoverageOptions& options, const std::string& folder)
      : sensor_(sensor),
        options_(options),
        store_(db::RunStore::open(fmt::format("{}/{}-{}.db", folder, sensor.seed, word_of(sensor.kind)),
                                  db::Durability::kNormal)),
        runs_(store_) {}

  void add_to(Coverages& coverages) {
    rate_ = run({{"rate"}, {}}).data.run;
    creep_ = run({{"creep-levels"}, {}}).data.run;
    warm_ = run({{kProduction}, {kThermometer, kWarm}}).data.run;
    for (const Use& use : uses()) {
      if (!use.random) continue;
      for (int i = 0; i < kGiven; ++i) {
        const std::int64_t given = random_reversals(use).data.run;
        if (use.condition == UseCondition::kRemounted)
          studies_.push_back(fmt::format("{}:mount", given));
        else
          held_out_.push_back(given);
      }
      for (int i = 0; i < kUsed; ++i) used_[use.name].push_back(random_reversals(use));
    }
    if (options_.production) add_calibration({kProduction}, "production", coverages);
    if (options_.table_1) add_calibration({"descending", "ascending"}, "table_1", coverages);
  }

 private:
  // On one rig, whose instruments have errors of their own.
  KnownRun run(SimulatedRun made) {
    made.set.push_back(fmt::format("simulation.instrument_seed={}", sensor_.seed));
    return simulate_run(made, sensor_, noise_seed_++, store_);
  }

  // No two go the same way, or are of one mount: the same way of all sensors would be one draw, however many they are.
  KnownRun random_reversals(const Use& use) {
    SimulatedRun made = run_of(use);
    const unsigned drawn = 1000 * sensor_.seed + noise_seed_;
    made.set.push_back(fmt::format("recipe.seed={}", drawn));
    if (use.condition == UseCondition::kRemounted) made.set.push_back(fmt::format("simulation.mount_seed={}", drawn));
    return run(std::move(made));
  }

  void add_calibration(const std::vector<std::string>& recipes, const std::string& name, Coverages& coverages) {
    const std::int64_t calibration = run({recipes, {kThermometer}}).data.run;
    const std::vector<KnownRun> again = {run({recipes, {}}), run({recipes, {}})};
    std::vector<std::int64_t> held_out = held_out_;
    held_out.push_back(run({recipes, {}}).data.run);
    const Dataset& fitted = runs_.dataset(calibration);
    for (const bool dynamic : {true, false}) {
      if (!(dynamic ? options_.dynamic : options_.elam)) continue;
      const SensorModel fit =
          dynamic ? fit_dynamic(fitted, runs_.dataset(rate_), runs_.dataset(creep_)) : fit_array(fitted);
      const std::string prefix = fmt::format("{}_{}_{}_", word_of(sensor_.kind), name, dynamic ? "dynamic" : "elam");
      const Uncertainty uncertainty = assessed(calibration, fit, held_out);
      for (const Use& use : uses()) {
        const ConditionUncertainty& stated = uncertainty.condition(use.condition);
        if (!stated.valid()) {
          coverages[prefix + use.name].not_valid += 1.0;
          continue;
        }
        for (const KnownRun& run : use.random ? used_.at(use.name) : again)
          add_errors(run, fit, stated, use.full_sweeps, coverages[prefix + use.name]);
      }
    }
  }

  // As the report assesses it, from the runs that it is given.
  Uncertainty assessed(std::int64_t calibration, const SensorModel& fit, const std::vector<std::int64_t>& held_out) {
    ReportInput input;
    input.run = runs_.record(calibration);
    input.fit = fit;
    for (const std::int64_t run : held_out) input.held_out.push_back({"", runs_.record(run), {}});
    std::vector<MountedRun> mounts = {{calibration, sweep_estimates(runs_.dataset(calibration), fit)}};
    for (const StudyRun& study : study_runs_of(studies_))
      mounts.push_back({study.run, sweep_estimates(runs_.dataset(study.run), fit)});
    input.more.studies.remount = remount_of(mounts);
    return assess_uncertainty(runs_.dataset(calibration), fit, input.run,
                              budget_inputs(runs_, input, {rate_, creep_, warm_}, studies_));
  }

  SimulatedSensor sensor_;
  const CoverageOptions& options_;
  db::RunStore store_;
  Runs runs_;
  unsigned noise_seed_ = 1;
  std::int64_t rate_ = 0, creep_ = 0, warm_ = 0;
  std::vector<std::int64_t> held_out_;
  std::vector<std::string> studies_;
  std::map<std::string, std::vector<KnownRun>> used_;
};

std::vector<Figure> figures_of(const Coverages& coverages) {
  FigureList figures("coverage");
  for (const auto& [name, covered] : coverages) {
    if (covered.not_valid > 0.0) figures.add(name + "_not_valid", covered.not_valid, "sensors");
    if (covered.errors.empty()) continue;
    figures.add(name, 100.0 * covered.inside / static_cast<double>(covered.errors.size()), "%");
    figures.add(name + "_median_u", quantile_of(covered.expanded, 0.5), "psi");
    figures.add(name + "_half_width_95", quantile_of(covered.errors, 0.95), "psi");
  }
  return figures.take();
}

}  // namespace

std::vector<Figure> benchmark_coverage(const CoverageOptions& options, const std::string& folder) {
  Coverages coverages;
  for (const SpecimenKind kind : options.specimens)
    for (const unsigned seed : options.sensor_seeds) CoverageOfSensor({kind, seed}, options, folder).add_to(coverages);
  return figures_of(coverages);
}

}  // namespace tactbench::bench
