#include "bench/reporting/sensor_state.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <ranges>

#include "analysis/report/document/document.h"
#include "analysis/report/gather.h"
#include "analysis/report/report_facts.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

using analysis::doc::number_with_u;

// Whether the run completed and its frames can be read.
bool can_be_checked(const db::RunReader& store, const db::RunRecord& run) {
  return run.outcome == db::Outcome::kCompleted && !store.pruned(run.run);
}

// Nothing where the models and the run do not go together (another scanner, a run of objects, no whole loop).
std::optional<SensorDrift> checked(analysis::Runs& runs, const analysis::SensorModel& model, std::int64_t run) {
  try {
    const analysis::Histories histories = analysis::histories_of(runs.dataset(run));
    SensorDrift found{run, model.run, {}, analysis::drift_of(model, histories), {}};
    found.outside = analysis::outside_validity(model, histories);
    return found;
  } catch (const analysis::AnalysisError&) {
    return std::nullopt;
  }
}

std::optional<SensorDrift> find_drift(const db::RunStore& store, const std::vector<db::RunRecord>& all) {
  std::optional<SensorDrift> newest;
  std::optional<analysis::SensorModel> model;
  for (const db::RunRecord& run : std::views::reverse(all)) {
    if (newest && run.run <= newest->model_run) break;
    if (!can_be_checked(store, run)) continue;
    analysis::Runs runs(store);
    if (newest) {  // since when
      const std::optional<SensorDrift> before = checked(runs, *model, run.run);
      if (before && !before->drift.drifted()) break;
      if (before) newest->since_utc = run.started_utc;
      continue;
    }
    const std::optional<db::FitRecord> fit = earlier_models(store, all, run);
    if (!fit) continue;
    model = analysis::load_fit(*fit);
    newest = checked(runs, *model, run.run);
    if (newest && !newest->drift.drifted()) break;
    if (newest) newest->since_utc = run.started_utc;
  }
  return newest;
}

std::string changes_text(const analysis::Drift& drift) {
  return fmt::format("zero {} % FS{}", signed_percent(drift.zero, drift.zero_u),
                     drift.gain_u > 0.0 ? fmt::format(", gain {} %", signed_percent(drift.gain, drift.gain_u)) : "");
}

std::string no_drift_text(const SensorState& state) {
  return state.runs.empty() ? "not measured" : "not known: no later run to check models on";
}

// The part that moved and the command that corrects it; or the run of a later calibration.
std::string advice_text(const SensorState& state) {
  const SensorDrift& found = *state.drift;
  const analysis::DriftVerdict verdict = found.drift.verdict;
  std::string way = "tactbench calibrate " + state.runs.back().sensor_serial;
  if (const std::int64_t newest = state.verdict ? state.verdict->models_run() : 0; newest > found.model_run)
    way = fmt::format("new models made since, from run {}", newest);
  else if (verdict != analysis::DriftVerdict::kRecalibrate)
    way = fmt::format("tactbench model adjust {} {} --{} -o adjusted.json", found.model_run, found.run,
                      verdict == analysis::DriftVerdict::kZero ? "zero" : "gain");
  return fmt::format("{} ({})", display_text(found.drift), way);
}

std::string yes_or_no(const SensorDrift& found) {
  return found.drift.drifted() ? fmt::format("yes, since {}", analysis::date_of(found.since_utc)) : "no";
}

}  // namespace

std::optional<db::FitRecord> earlier_models(const db::Models& store, const std::vector<db::RunRecord>& runs,
                                            const db::RunRecord& run) {
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(run.run);
  std::optional<db::FitRecord> judged;
  for (const db::RunRecord& earlier : std::views::reverse(runs)) {
    if (earlier.run >= run.run || earlier.origin != run.origin) continue;
    std::optional<db::FitRecord> fit = store.default_fit(earlier.run);
    if (!fit || fit->fitted == 0) continue;
    if (std::ranges::find(verdicts, earlier.run, &db::VerdictRecord::model_run) == verdicts.end()) return fit;
    if (!judged) judged = std::move(fit);
  }
  return judged;
}

std::string signed_percent(double share, double expanded) {
  const std::string text = text_of(number_with_u(100.0 * share, 100.0 * expanded), analysis::PressureUnit::kPsi);
  return share > 0.0 ? "+" + text : text;
}

SensorState sensor_state(const db::RunStore& store, const std::string& serial, const analysis::Laboratory& laboratory) {
  SensorState state;
  state.runs = store.runs({.sensor_serial = serial});
  std::erase_if(state.runs, &db::RunRecord::is_void);
  for (const db::RunRecord& run : std::views::reverse(state.runs)) {
    Standing stands = standing(store, run.run);
    if (!stands.verdict) continue;
    state.verdict = std::move(stands);
    state.judged_run = run.run;
    state.valid_until = analysis::valid_until(laboratory, run.started_utc);
    break;
  }
  state.drift = find_drift(store, state.runs);
  return state;
}

std::string drift_text(const SensorState& state) {
  if (!state.drift) return no_drift_text(state);
  const analysis::Drift& drift = state.drift->drift;
  return fmt::format(
             "{}: run {} is off the models of run {} by {:.2f} % FS (tolerance {:.2f}); {}, pattern {:.2f} % FS{}",
             yes_or_no(*state.drift), state.drift->run, state.drift->model_run, 100.0 * drift.as_is,
             100.0 * drift.tolerance, changes_text(drift), 100.0 * std::min(drift.adjusted, drift.as_is),
             drift.drifted() ? "; " + advice_text(state) : "") +
         (state.drift->outside.empty()
              ? ""
              : fmt::format("; outside the models' validity: {}", fmt::join(state.drift->outside, "; ")));
}

}  // namespace tactbench::bench
