#include "bench/reporting/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/report/parts.h"
#include "analysis/statistics/conformity/overall_verdict.h"
#include "analysis/statistics/figures/limits.h"
#include "bench/config/config.h"
#include "bench/reporting/conditions.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/judged_figures.h"
#include "bench/reporting/named_runs.h"
#include "bench/reporting/source_runs.h"

namespace tactbench::bench {

using analysis::Verdict;

namespace {

constexpr const char* kNoIndependentData =
    "no independent data: the figures are of the run that the models were made from";

// A void run is no evidence.
bool run_counts(const db::RunRecord& run, bool void_too) { return void_too || !run.is_void(); }

bool is_among(const std::vector<std::int64_t>& runs, std::int64_t run) {
  return std::ranges::find(runs, run) != runs.end();
}

// What the models of a stored verdict rest on beside its model_run: only a dynamic model has more. Models that can no
// longer be read are not asked: `verify` reports them.
std::vector<std::int64_t> further_sources(const db::RunStore& store, const db::VerdictRecord& verdict) {
  if (verdict.fit == 0) return {};
  const db::FitRecord record = store.fit(verdict.fit);
  if (record.model != analysis::kDynamicModel) return {};
  try {
    return source_runs(store, analysis::load_fit(record));
  } catch (const analysis::AnalysisError&) {
    return {};
  }
}

std::vector<db::VerdictRecord> stored_on(const StoredJudgement& stored, std::int64_t run, const std::string& sha256) {
  std::vector<db::VerdictRecord> rows;
  std::ranges::copy_if(stored.verdicts, std::back_inserter(rows), [&](const db::VerdictRecord& verdict) {
    return verdict.run == run && verdict.limits_sha256 == sha256;
  });
  // Of two fits with the same models the newer one counts.
  std::int64_t newest = 0;
  for (const db::VerdictRecord& row : rows) newest = std::max(newest, row.fit);
  std::erase_if(rows, [&](const db::VerdictRecord& row) { return row.fit != newest; });
  return rows;
}

// Stored verdicts of independent runs that are worse than the present ones, by whichever limits.
std::vector<db::VerdictRecord> worse_than(const std::vector<db::VerdictRecord>& now, const StoredJudgement& stored) {
  const Verdict found = std::max(analysis::overall_verdict(now).value_or(Verdict::kPass), Verdict::kPass);
  std::vector<db::VerdictRecord> worse;
  for (const db::VerdictRecord& verdict : stored.verdicts)
    if (verdict.run != verdict.model_run && analysis::verdict_in(verdict) > found) worse.push_back(verdict);
  return worse;
}

}  // namespace

StoredJudgement stored_judgement(analysis::Runs& runs, const analysis::SensorModel& fit, bool void_too) {
  StoredJudgement stored;
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
    if (added) {
      const db::FitRecord record = store.fit(verdict.fit);
      same->second = verdict.fit == fit.fit || analysis::model_sha256(analysis::load_fit(record)) == models;
    }
    if (!same->second) {
      other_limits = verdict.limits_toml;
      other_fit = verdict.fit;
      continue;
    }
    stored.limits_toml = verdict.limits_toml;
    if (verdict.run == fit.run) {
      stored.verdicts.push_back(verdict);
      continue;
    }
    if (is_among(sources, verdict.run)) continue;  // no independent data
    const db::RunRecord& run = runs.record(verdict.run);
    if (run_counts(run, void_too)) {
      stored.verdicts.push_back(verdict);
      if (std::ranges::find(stored.runs, run.run) == stored.runs.end()) stored.runs.push_back(run.run);
    } else if (std::ranges::find(gone, run.run) == gone.end()) {
      gone.push_back(run.run);
      stored.lost.push_back(fmt::format("the models were judged on run {}, but {}", run.run, void_in_words(run)));
    }
  }
  if (stored.limits_toml.empty() && other_fit != 0) {
    stored.limits_toml = other_limits;
    stored.lost.push_back(fmt::format("fit {} of run {} was judged, which has other models", other_fit, fit.run));
  }
  std::ranges::sort(stored.runs);
  return stored;
}

std::vector<db::VerdictRecord> judge_anew(analysis::Runs& runs, const analysis::SensorModel& fit,
                                          const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                          std::vector<analysis::JudgedUncertainty>* uncertainties) {
  const analysis::ReferenceUncertainty reference = analysis::reference_uncertainty(runs.record(evaluation.run));
  JudgedFigures figures = judged_figures(runs, fit, evaluation, limits, reference);
  std::vector<db::VerdictRecord> verdicts =
      analysis::judge(evaluation, fit, limits, figures.uncertainties, figures.mpe);
  for (db::VerdictRecord& verdict : verdicts) verdict.model_run = fit.run;
  analysis::withhold_untraced(verdicts, evaluation.run, reference);
  if (uncertainties != nullptr)
    uncertainties->insert(uncertainties->end(), figures.uncertainties.begin(), figures.uncertainties.end());
  return verdicts;
}

Judgement judge_runs(analysis::Runs& runs, const analysis::SensorModel& fit,
                     const std::vector<NamedEvaluation>& evaluations, const analysis::Limits& limits, bool void_too,
                     const StoredJudgement& stored) {
  Judgement judgement;
  if (evaluations.empty()) return judgement;
  const std::vector<std::int64_t> sources = source_runs(runs.store(), fit);
  bool models_count = true;
  for (const std::int64_t source : sources) {
    const db::RunRecord& models = runs.record(source);
    if (!models.is_void()) continue;
    if (run_counts(models, void_too)) {
      judgement.void_runs.push_back(models);
    } else if (models_count) {
      models_count = false;
      judgement.notes.not_judged = void_in_words(models) + ", and the models were made from it";
    }
  }
  std::vector<std::string> left_out = stored.lost;
  for (const NamedEvaluation& named : evaluations) {
    const std::int64_t number = named.evaluation.run;
    if (is_among(sources, number) || !models_count) continue;
    const db::RunRecord& run = runs.record(number);
    if (!run_counts(run, void_too)) {
      left_out.push_back(fmt::format("run {} is not judged: {}", number, void_in_words(run)));
      continue;
    }
    if (run.is_void()) judgement.void_runs.push_back(run);
    std::vector<db::VerdictRecord> rows = stored_on(stored, number, limits.sha256);
    if (rows.empty()) rows = judge_anew(runs, fit, named.evaluation, limits, &judgement.uncertainties);
    judgement.verdicts.insert(judgement.verdicts.end(), rows.begin(), rows.end());
  }
  for (const db::RunRecord& run : judgement.void_runs)
    judgement.notes.remarks.push_back(void_in_words(run) + "; --void-too includes it");
  for (std::string& why : left_out) judgement.notes.remarks.push_back(std::move(why));
  if (judgement.verdicts.empty()) {
    judgement.verdicts = judge_anew(runs, fit, evaluations.front().evaluation, limits, &judgement.uncertainties);
    analysis::withhold_verdicts(judgement.verdicts);
    const bool report_only = limits.rule == analysis::DecisionRule::kReportOnly;
    if (judgement.notes.not_judged.empty() && !report_only) judgement.notes.not_judged = kNoIndependentData;
  }
  judgement.notes.stored_worse =
      judgement.notes.not_judged.empty() ? worse_than(judgement.verdicts, stored) : std::vector<db::VerdictRecord>();
  note_conditions(runs, fit, judgement.verdicts, nullptr, {}, judgement.notes);
  return judgement;
}

Judgement judge_and_store(db::RunStore& store, analysis::Runs& runs, const analysis::SensorModel& fit,
                          const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                          bool void_too, const std::vector<analysis::InstrumentNote>& notes) {
  const analysis::Limits limits = read_limits(find_config(limits_file));
  Judgement judgement = judge_runs(runs, fit, evaluations, limits, void_too);
  if (limits.rule == analysis::DecisionRule::kReportOnly) return judgement;
  for (std::string& why : withhold_untraced_runs(runs, judgement.verdicts, notes))
    judgement.notes.remarks.push_back(std::move(why));
  note_conditions(runs, fit, judgement.verdicts, nullptr, notes, judgement.notes);
  for (const analysis::RunVerdict& run : analysis::verdicts_by_run(judgement.verdicts)) {
    std::vector<db::VerdictRecord> rows;
    std::ranges::copy_if(judgement.verdicts, std::back_inserter(rows),
                         [&](const db::VerdictRecord& verdict) { return verdict.run == run.run; });
    store.replace_verdicts(run.run, fit.fit, rows);
  }
  // Verdicts by earlier limits files are reported with it.
  if (judgement.notes.not_judged.empty())
    judgement.notes.stored_worse = worse_than(judgement.verdicts, stored_judgement(runs, fit, void_too));
  return judgement;
}

Judgement judge_for_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                           const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                           const StoredJudgement& stored, bool void_too) {
  if (!limits_file.empty())
    return judge_runs(runs, fit, evaluations, read_limits(find_config(limits_file)), void_too, stored);
  if (stored.limits_toml.empty()) return {};
  return judge_runs(runs, fit, evaluations, parse_limits(stored.limits_toml, "the limits stored with the verdicts"),
                    void_too, stored);
}

std::vector<db::VerdictRecord> standing_verdicts(const db::RunStore& store, std::int64_t run) {
  if (store.run(run).is_void()) return {};
  std::vector<db::VerdictRecord> rows = store.verdicts(run);
  for (db::VerdictRecord& verdict : store.verdicts_of_models(run))
    if (verdict.run != run) rows.push_back(std::move(verdict));
  std::map<std::int64_t, bool> counts{{0, true}, {run, true}};
  const auto stands = [&](std::int64_t number) {
    const auto [known, added] = counts.try_emplace(number, true);
    if (added) known->second = run_counts(store.run(number), false);
    return known->second;
  };
  std::map<std::int64_t, std::vector<std::int64_t>> further;  // by fit
  const auto sources_of = [&](const db::VerdictRecord& v) -> const std::vector<std::int64_t>& {
    const auto [known, added] = further.try_emplace(v.fit);
    if (added) known->second = further_sources(store, v);
    return known->second;
  };
  const auto on_own = [&](const db::VerdictRecord& v) {
    return v.run == v.model_run || is_among(sources_of(v), v.run);
  };
  std::erase_if(rows, [&](const db::VerdictRecord& v) {
    return !stands(v.run) || !stands(v.model_run) || !std::ranges::all_of(sources_of(v), stands);
  });
  const bool independent =
      std::ranges::any_of(rows, [&](const db::VerdictRecord& v) { return v.model_run == run && !on_own(v); });
  std::erase_if(rows, [&](const db::VerdictRecord& v) { return independent && v.model_run == run && on_own(v); });
  for (db::VerdictRecord& verdict : rows)
    if (on_own(verdict)) verdict.verdict = to_string(Verdict::kInconclusive);
  return rows;
}

std::optional<Verdict> standing_verdict(const std::vector<db::VerdictRecord>& standing) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::string> newest;  // limits, by run and models
  for (const db::VerdictRecord& verdict : standing) newest[{verdict.run, verdict.model_run}] = verdict.limits_sha256;
  std::vector<db::VerdictRecord> counting;
  for (const db::VerdictRecord& verdict : standing)
    if (analysis::verdict_in(verdict) == Verdict::kFail ||
        newest[{verdict.run, verdict.model_run}] == verdict.limits_sha256)
      counting.push_back(verdict);
  return analysis::overall_verdict(counting);
}

Judgement judgement_on(const db::RunStore& store, std::int64_t run) {
  Judgement judgement;
  std::vector<db::VerdictRecord> rows = standing_verdicts(store, run);
  std::erase_if(rows, [&](const db::VerdictRecord& verdict) { return verdict.run != run; });
  if (rows.empty()) {
    if (!store.verdicts(run).empty())
      judgement.notes.not_judged = "the run, or the one that the models were made from, was declared void";
    return judgement;
  }
  const db::VerdictRecord newest = rows.back();
  if (newest.model_run == run) judgement.notes.not_judged = kNoIndependentData;
  for (db::VerdictRecord& verdict : rows)
    if (verdict.fit == newest.fit && verdict.limits_sha256 == newest.limits_sha256)
      judgement.verdicts.push_back(verdict);
  const std::optional<Verdict> found = analysis::overall_verdict(judgement.verdicts);
  for (db::VerdictRecord& verdict : rows)
    if (analysis::verdict_in(verdict) > found) judgement.notes.stored_worse.push_back(std::move(verdict));
  return judgement;
}

}  // namespace tactbench::bench
