#include "bench/reporting/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

#include "analysis/identify/stored/model_document.h"
#include "analysis/judgement/judgement.h"
#include "analysis/report/report_facts.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/common/error.h"
#include "bench/common/overrides.h"
#include "bench/common/terminal.h"
#include "bench/reporting/judgement.h"
#include "bench/reporting/report_budget.h"
#include "bench/run/run_record.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

using analysis::EvidenceRun;
using analysis::Source;

bool is_among(const std::vector<std::int64_t>& runs, std::int64_t run) {
  return std::ranges::find(runs, run) != runs.end();
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

// Conditions in which a run differs from the run of the models.
void find_changed_conditions(analysis::Runs& runs, const analysis::SensorModel& fit, EvidenceRun& judged) {
  const db::RunRecord &models = runs.record(fit.run), &run = runs.record(judged.run);
  const analysis::Dataset &fitted = runs.dataset(fit.run), &dataset = runs.dataset(judged.run);
  judged.trajectory = analysis::judged_trajectory(dataset, fitted);
  const std::optional<double> dwell = dwell_of(run), fitted_dwell = dwell_of(models);
  if (dwell && fitted_dwell) analysis::set_dwell(judged.trajectory, *dwell, *fitted_dwell);
  const StateChange change = state_change(models, run);
  const analysis::InstrumentCalibration& calibration = judged.reference.calibration;
  const auto shows = [&](bool shown, Source source) {
    if (shown) judged.shows.insert(source);
  };
  shows(judged.trajectory.trajectory != analysis::Trajectory::kAsFitted, Source::kHistory);
  shows(change.mounted, Source::kRemounting);
  shows(change.later, Source::kTime);
  shows(temperature_differs(models, run, fitted, dataset), Source::kTemperature);
  shows(!calibration.calibrated_on.empty() || !calibration.due.empty(), Source::kReferenceAge);
}

}  // namespace

StoredVerdicts stored_verdicts(analysis::Runs& runs, const analysis::SensorModel& fit, bool void_too) {
  StoredVerdicts stored;
  if (fit.taxels.empty()) return stored;
  const db::RunStore& store = runs.store();
  std::map<std::int64_t, bool> same_models;  // by fit
  const std::string models = analysis::model_sha256(fit);
  const std::vector<std::int64_t> sources = source_runs(store, fit);
  std::vector<std::int64_t> gone;
  std::string other_limits;
  std::int64_t other_fit = 0;
  for (const db::VerdictRecord& verdict : store.verdicts_of_models(fit.run)) {
    const auto [same, added] = same_models.try_emplace(verdict.fit, false);
    if (added)
      same->second =
          verdict.fit == fit.fit || analysis::model_sha256(analysis::load_fit(store.fit(verdict.fit))) == models;
    if (!same->second) {
      other_limits = verdict.limits_toml;
      other_fit = verdict.fit;
      continue;
    }
    stored.limits_toml = verdict.limits_toml;
    if (verdict.run == fit.run) {
      stored.figures.push_back(analysis::figure_of(verdict));
      continue;
    }
    if (is_among(sources, verdict.run)) continue;  // not independent data
    const db::RunRecord& run = runs.record(verdict.run);
    if (void_too || !run.is_void()) {
      stored.figures.push_back(analysis::figure_of(verdict));
      if (!is_among(stored.runs, run.run)) stored.runs.push_back(run.run);
    } else if (!is_among(gone, run.run)) {
      gone.push_back(run.run);
      stored.lost.push_back({analysis::Remark::Kind::kStoredOnVoid, analysis::void_of(run), run.run});
    }
  }
  if (stored.limits_toml.empty() && other_fit != 0) {
    stored.limits_toml = other_limits;
    stored.lost.push_back({analysis::Remark::Kind::kOtherModels, {}, fit.run, other_fit});
  }
  std::ranges::sort(stored.runs);
  return stored;
}

analysis::Evidence gather_evidence(analysis::Runs& runs, const analysis::SensorModel& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const analysis::Limits& limits,
                                   bool void_too, const std::vector<analysis::InstrumentNote>& notes,
                                   const StoredVerdicts& stored) {
  analysis::Evidence evidence;
  evidence.fit = fit.fit;
  evidence.model_run = fit.run;
  evidence.void_too = void_too;
  evidence.stored = stored.figures;
  evidence.lost = stored.lost;
  // Creep from a single dwell is not evidence for longer holds.
  if (fit.dynamics && fit.dynamics->creep.run != 0) evidence.studied.insert(Source::kCreep);
  if (evaluations.empty()) return evidence;
  const std::vector<std::int64_t> sources = source_runs(runs.store(), fit);
  for (const std::int64_t source : sources)
    if (const db::RunRecord& run = runs.record(source); run.is_void())
      evidence.models_void.push_back(analysis::void_of(run));
  analysis::ModelRunResults of_models;
  const auto measure = [&](EvidenceRun& own, const NamedEvaluation& named) {
    own.figures = judged_figures(runs, fit, named.evaluation, limits, own.reference, of_models);
  };
  bool any = false;
  for (const NamedEvaluation& named : evaluations) {
    EvidenceRun& own = evidence.runs.emplace_back();
    own.run = named.evaluation.run;
    const db::RunRecord& run = runs.record(own.run);
    own.reference = analysis::reference_uncertainty(run, notes);
    if (run.is_void()) own.voided = analysis::void_of(run);
    own.counts = is_among(sources, own.run) ? EvidenceRun::Counts::kUsedByModels
                 : !run.is_void()           ? EvidenceRun::Counts::kYes
                 : void_too                 ? EvidenceRun::Counts::kVoidOnRequest
                                            : EvidenceRun::Counts::kVoid;
    if (own.counts == EvidenceRun::Counts::kUsedByModels || own.counts == EvidenceRun::Counts::kVoid) continue;
    if (!evidence.models_void.empty() && !void_too) continue;
    measure(own, named);
    find_changed_conditions(runs, fit, own);
    any = true;
  }
  if (!any) measure(evidence.runs.front(), evaluations.front());
  return evidence;
}

std::optional<std::int64_t> run_of_source(const db::RunReader& store, const analysis::SensorDynamics::Source& source) {
  if (source.content_sha256.empty()) {
    const std::vector<db::RunRecord> runs = store.runs();
    const bool there = std::ranges::find(runs, source.run, &db::RunRecord::run) != runs.end();
    return there ? std::optional(source.run) : std::nullopt;
  }
  const std::vector<db::RunRecord> same = store.runs({.content_sha256 = source.content_sha256});
  if (same.empty()) return std::nullopt;
  return std::ranges::find(same, source.run, &db::RunRecord::run) != same.end() ? source.run : same.front().run;
}

std::vector<std::int64_t> source_runs(const db::RunReader& store, const analysis::SensorModel& fit) {
  std::vector<std::int64_t> numbers;
  if (fit.run != 0) numbers.push_back(fit.run);
  if (!fit.dynamics) return numbers;
  for (const analysis::SensorDynamics::Source& source : {fit.dynamics->rate, fit.dynamics->creep}) {
    const std::optional<std::int64_t> run = run_of_source(store, source);
    if (run && std::ranges::find(numbers, *run) == numbers.end()) numbers.push_back(*run);
  }
  return numbers;
}

std::vector<db::RunRecord> named_runs(analysis::Runs& runs, const std::vector<std::int64_t>& numbers,
                                      const RunSelectionRules& named, bool void_too) {
  std::vector<db::RunRecord> records;
  for (const std::int64_t run : numbers) {
    if (std::ranges::find(records, run, &db::RunRecord::run) != records.end())
      throw Error("TB-RUN-TWICE", fmt::format("run {} is named twice", run), named.at,
                  "name each run once: counted twice, it would look like a repetition");
    if (run == named.models_of)
      throw Error("TB-RUN-OWN",
                  fmt::format("the models were made from run {}: it is not independent data for them", run), named.at);
    records.push_back(runs.record(run));
    const db::RunRecord& record = records.back();
    if (!record.is_void()) continue;
    const std::string why = display_text(analysis::void_of(record));
    if (!void_too || !named.void_can_be_used)
      throw Error("TB-RUN-VOID", why, named.at,
                  named.void_can_be_used
                      ? "name another run, or add --void-too; the results are then marked as from void runs"
                      : "name another run: a void run cannot be accepted");
    tty::print(stderr, "warning: {}; used because of --void-too\n", why);
  }
  return records;
}

}  // namespace tactbench::bench
