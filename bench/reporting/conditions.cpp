#include "bench/reporting/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "analysis/statistics/conformity/overall_verdict.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/reporting/report_budget.h"
#include "bench/run/run_record.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

constexpr double kOtherDaySeconds = 86400.0;

// What a judged run shows beside the run of the models.
struct Shown {
  bool mount = false, temperature = false, time = false, path = false, calibration_dated = true;
};

bool mounted_anew(const db::RunRecord& a, const db::RunRecord& b) {
  if (a.origin != "simulated") return false;  // only a study says so: RUN:mount
  const std::optional<BenchConfig> ours = stored_bench(a), theirs = stored_bench(b);
  return ours && theirs && ours->simulation && theirs->simulation &&
         ours->simulation->plant.specimen.mount_seed != theirs->simulation->plant.specimen.mount_seed;
}

bool another_day(const db::RunRecord& a, const db::RunRecord& b) {
  if (seconds_between(a.started_utc, b.started_utc) + seconds_between(b.started_utc, a.started_utc) > kOtherDaySeconds)
    return true;
  if (a.origin != "simulated") return false;
  const std::optional<BenchConfig> ours = stored_bench(a), theirs = stored_bench(b);
  return ours && theirs && ours->simulation && theirs->simulation &&
         ours->simulation->plant.specimen.age_months != theirs->simulation->plant.specimen.age_months;
}

// Mean dwell of a run's recipes, as they were carried out; none where they cannot be read.
std::optional<double> dwell_of(const db::RunRecord& run) {
  std::optional<std::vector<sequences::Override>> overrides = stored_overrides(run.overrides_json);
  if (!overrides) return std::nullopt;
  std::vector<std::string> set;
  for (const sequences::Override& item : *overrides) set.push_back(item.key + "=" + item.value);
  std::vector<double> dwells;
  try {
    for (const db::SequenceRecord& sequence : run.sequences)
      std::ranges::copy(sequences::parse_recipe(sequences::TomlDocument::from_text(sequence.recipe_toml, sequence.name),
                                                split_overrides(set).recipe)
                            .dwell_s,
                        std::back_inserter(dwells));
  } catch (const std::exception&) {
    return std::nullopt;  // a recipe of another version
  }
  return dwells.empty() ? std::nullopt : std::optional(analysis::mean_of(dwells));
}

Shown shown_by(analysis::Runs& runs, const analysis::SensorModel& fit, const analysis::JudgementNotes& notes) {
  Shown shown;
  const db::RunRecord& models = runs.record(fit.run);
  for (const analysis::JudgedTrajectory& judged : notes.trajectories) {
    const db::RunRecord& run = runs.record(judged.run);
    shown.path |= judged.trajectory != analysis::Trajectory::kAsFitted;
    shown.mount |= mounted_anew(models, run);
    shown.time |= another_day(models, run);
    shown.temperature |= temperature_differs(models, run, runs.dataset(fit.run), runs.dataset(judged.run));
    const analysis::InstrumentCalibration calibration = analysis::reference_uncertainty(run).calibration;
    shown.calibration_dated &= !calibration.calibrated_on.empty() || !calibration.due.empty();
  }
  return shown;
}

}  // namespace

void note_conditions(analysis::Runs& runs, const analysis::SensorModel& fit,
                     std::span<const db::VerdictRecord> verdicts, const analysis::UncertaintyInputs* inputs,
                     const std::vector<analysis::InstrumentNote>& instruments, analysis::JudgementNotes& notes) {
  notes.trajectories.clear();
  notes.not_assessed.clear();
  notes.untraced.clear();
  if (!notes.not_judged.empty() || fit.taxels.empty() ||
      !analysis::states_conformity(analysis::overall_verdict(verdicts)))
    return;
  for (const analysis::RunVerdict& judged : analysis::verdicts_by_run(verdicts)) {
    notes.trajectories.push_back(analysis::judged_trajectory(runs.dataset(judged.run), runs.dataset(fit.run)));
    const std::optional<double> dwell = dwell_of(runs.record(judged.run)), fitted = dwell_of(runs.record(fit.run));
    if (dwell && fitted) analysis::set_dwell(notes.trajectories.back(), *dwell, *fitted);
    const analysis::ReferenceUncertainty reference =
        analysis::reference_uncertainty(runs.record(judged.run), instruments);
    if (notes.untraced.empty()) notes.untraced = reference.untraced();
  }
  const Shown shown = shown_by(runs, fit, notes);
  const auto missing = [&](bool assessed, const char* source, const char* why) {
    if (!assessed) notes.not_assessed.push_back({source, why});
  };
  missing(shown.path, "history",
          "every judged run repeats the fitted set-points: nothing is known of other inner branches");
  missing(shown.mount || (inputs != nullptr && inputs->mounting), "re-mounting",
          "no judged run and no study is of the sensor mounted anew");
  missing(shown.temperature || (inputs != nullptr && inputs->temperature.assessed()), "temperature",
          "no judged run and no study is at another temperature");
  missing(shown.time, "time", "no judged run is a day or more apart from that of the models");
  // What one dwell tells of creep is no evidence of longer holds.
  const bool of_holds = fit.dynamics && fit.dynamics->creep.run != 0;
  missing(of_holds || (inputs != nullptr && inputs->creep.assessed()), "creep",
          "no study holds the load for longer than the runs do");
  missing(shown.calibration_dated, "age of the reference's calibration",
          "neither its date nor its due date is stated: its drift cannot be scaled with time");
}

}  // namespace tactbench::bench
