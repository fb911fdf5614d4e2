#include "bench/reporting/as_found.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "bench/reporting/judged_figures.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/sensor_state.h"
#include "bench/reporting/source_runs.h"

namespace tactbench::bench {

namespace {

bool passed(const db::RunStore& store, std::int64_t run) { return analysis::passes(standing(store, run).verdict); }

// The newest run of the sensor before `run` on which, or on whose models, a passing verdict stands; empty: none.
std::string last_pass_utc(const db::RunStore& store, const db::RunRecord& run) {
  std::string last;
  for (const db::RunRecord& other : store.runs({.sensor_serial = run.sensor_serial}))
    if (other.sensor_serial == run.sensor_serial && other.origin == run.origin &&
        std::pair(other.started_utc, other.run) < std::pair(run.started_utc, run.run) && other.started_utc > last &&
        !other.is_void() && passed(store, other.run))
      last = other.started_utc;
  return last;
}

std::string day_of_utc(const std::string& utc) { return utc.substr(0, std::min<std::size_t>(10, utc.size())); }

}  // namespace

std::string models_before(analysis::Runs& runs, std::int64_t run) {
  const db::RunStore& store = runs.store();
  const db::RunRecord record = runs.record(run);
  std::vector<db::RunRecord> of_sensor = store.runs({.sensor_serial = record.sensor_serial});
  std::erase_if(of_sensor, &db::RunRecord::is_void);
  const std::optional<db::FitRecord> fit = earlier_models(store, of_sensor, record);
  if (!fit) return {};
  const analysis::SensorModel models = analysis::load_fit(*fit);
  const std::vector<std::int64_t> sources = source_runs(store, models);
  if (models.fitted().empty() || std::ranges::find(sources, run) != sources.end()) return {};
  try {
    analysis::check_same_sensor(runs.dataset(run), models);
  } catch (const analysis::AnalysisError&) {
    return {};
  }
  return fmt::format("{}:{}", fit->run, fit->fit);
}

void judge_as_found(analysis::Runs& runs, analysis::ReportInput& input, const std::string& previous,
                    const analysis::Limits& limits) {
  if (!input.more.previous || input.judgement.figures.empty()) return;
  analysis::AsFound& found = *input.more.previous;
  // The earlier models' own run may lie in another store: scatter and budgets are those of this run.
  analysis::SensorModel models = analysis::load_model(previous, &runs.store());
  models.run = input.run.run;
  analysis::Evidence evidence;
  analysis::EvidenceRun& own = evidence.runs.emplace_back();
  own.run = found.evaluation.run;
  own.reference = analysis::reference_uncertainty(input.run, input.laboratory.instruments);
  analysis::OfModelsRun of_models;
  own.figures = judged_figures(runs, models, found.evaluation, limits, own.reference, of_models);
  found.judgement = judge(evidence, limits);
  const auto overall = found.judgement.overall;
  if (overall != analysis::Verdict::kFail && overall != analysis::Verdict::kConditionalFail) return;
  const std::string last = last_pass_utc(runs.store(), input.run);
  found.doubt = last.empty()
                    ? std::string(
                          "As found, the sensor does not conform, and the store has no earlier calibration of it that "
                          "passed: all measurements made with the earlier models are in doubt.")
                    : fmt::format(
                          "As found, the sensor does not conform: measurements made with the earlier models since {}, "
                          "the last calibration of this sensor that passed, are in doubt.",
                          day_of_utc(last));
}

}  // namespace tactbench::bench
