#include "bench/reporting/judgement.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/judgement/mpe.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "bench/config/config.h"
#include "bench/reporting/evidence.h"
#include "bench/reporting/report_budget.h"

namespace tactbench::bench {

namespace {

using analysis::JudgedFigure;
using analysis::Judgement;
using analysis::Verdict;

// Source runs of a stored verdict's models in addition to its model_run: only a dynamic model has more. Unreadable
// models are skipped: `verify` reports them.
std::vector<std::int64_t> further_sources(const db::RunStore& store, std::int64_t fit) {
  if (fit == 0) return {};
  const db::FitRecord record = store.fit(fit);
  if (record.model != analysis::kDynamicModel) return {};
  try {
    return source_runs(store, analysis::load_fit(record));
  } catch (const analysis::AnalysisError&) {
    return {};
  }
}

void store_judgement(db::Models& store, std::int64_t fit, const Judgement& judgement) {
  std::map<std::int64_t, std::vector<db::VerdictRecord>> rows;  // by run
  for (const JudgedFigure& figure : judgement.figures)
    rows[figure.run].push_back(analysis::record_of(figure, judgement.limits_toml));
  for (const auto& [run, own] : rows) store.replace_verdicts(run, fit, own);
}

}  // namespace

JudgementRecord judge_and_store(db::RunStore& store, analysis::Runs& runs, const analysis::SensorModel& fit,
                                const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                                bool void_too, const std::vector<analysis::InstrumentNote>& notes) {
  JudgementRecord out{{}, read_limits(find_config(limits_file)), {}};
  out.evidence = gather_evidence(runs, fit, evaluations, out.limits, void_too, notes);
  out.judgement = judge(out.evidence, out.limits);
  if (out.limits.rule == analysis::DecisionRule::kReportOnly) return out;
  store_judgement(store, fit.fit, out.judgement);
  out.evidence.stored = stored_verdicts(runs, fit, void_too).figures;
  out.judgement = judge(out.evidence, out.limits);
  return out;
}

JudgementRecord judge_for_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                                 const std::vector<NamedEvaluation>& evaluations, const std::string& limits_file,
                                 bool void_too, const std::vector<analysis::InstrumentNote>& notes,
                                 const StoredVerdicts& stored) {
  JudgementRecord out;
  if (limits_file.empty() && stored.limits_toml.empty()) return out;
  out.limits = limits_file.empty() ? parse_limits(stored.limits_toml, "the limits stored with the verdicts")
                                   : read_limits(find_config(limits_file));
  out.evidence = gather_evidence(runs, fit, evaluations, out.limits, void_too, notes, stored);
  out.judgement = judge(out.evidence, out.limits);
  return out;
}

Standing standing(const db::RunStore& store, std::int64_t run) {
  Standing out;
  if (store.run(run).is_void()) return out;
  std::vector<JudgedFigure>& rows = out.figures = analysis::figures_of(store.verdicts(run));
  for (const db::VerdictRecord& verdict : store.verdicts_of_models(run))
    if (verdict.run != run) rows.push_back(analysis::figure_of(verdict));
  std::map<std::int64_t, bool> counts{{0, true}, {run, true}};
  const auto stands = [&](std::int64_t number) {
    const auto [known, added] = counts.try_emplace(number, true);
    if (added) known->second = !store.run(number).is_void();
    return known->second;
  };
  std::map<std::int64_t, std::vector<std::int64_t>> further;  // by fit
  const auto sources_of = [&](const JudgedFigure& v) -> const std::vector<std::int64_t>& {
    const auto [known, added] = further.try_emplace(v.fit);
    if (added) known->second = further_sources(store, v.fit);
    return known->second;
  };
  const auto on_own = [&](const JudgedFigure& v) {
    return v.run == v.model_run || std::ranges::find(sources_of(v), v.run) != sources_of(v).end();
  };
  std::erase_if(rows, [&](const JudgedFigure& v) {
    return !stands(v.run) || !stands(v.model_run) || !std::ranges::all_of(sources_of(v), stands);
  });
  const bool independent =
      std::ranges::any_of(rows, [&](const JudgedFigure& v) { return v.model_run == run && !on_own(v); });
  std::erase_if(rows, [&](const JudgedFigure& v) { return independent && v.model_run == run && on_own(v); });
  for (JudgedFigure& figure : rows)
    if (on_own(figure)) figure.verdict = Verdict::kInconclusive;
  std::map<std::pair<std::int64_t, std::int64_t>, std::string> newest;  // limits, by run and models
  for (const JudgedFigure& figure : rows) newest[{figure.run, figure.model_run}] = figure.limits_sha256;
  bool is_per_reading = false;
  for (const JudgedFigure& figure : rows) {
    if (figure.verdict != Verdict::kFail && newest[{figure.run, figure.model_run}] != figure.limits_sha256) continue;
    out.verdict = std::max(out.verdict, std::optional(figure.verdict));
    is_per_reading = is_per_reading || analysis::is_per_reading(figure.criterion);
  }
  out.rests_on_means_alone = analysis::passes(out.verdict) && !is_per_reading;
  return out;
}

const JudgedFigure* Standing::deciding() const {
  const JudgedFigure* found = nullptr;
  for (const JudgedFigure& figure : figures)
    if (figure.verdict == verdict && (found == nullptr || figure.use_of_limit() > found->use_of_limit()))
      found = &figure;
  return found;
}

std::int64_t reporting_run(const db::Models& store, const Standing& of, std::int64_t run) {
  if (const std::int64_t models = of.models_run(); models != 0) return models;
  return store.default_fit(run) ? run : 0;
}

Judgement judgement_on(const db::RunStore& store, std::int64_t run) {
  Judgement out;
  std::vector<JudgedFigure> rows = standing(store, run).figures;
  std::erase_if(rows, [&](const JudgedFigure& figure) { return figure.run != run; });
  const std::vector<db::VerdictRecord> stored = store.verdicts(run);
  if (rows.empty()) {
    if (!stored.empty()) out.not_judged = {analysis::Remark::Kind::kOnVoid};
    conclude(out);
    return out;
  }
  const JudgedFigure newest = rows.back();
  if (newest.model_run == run) out.not_judged = {analysis::Remark::Kind::kNoIndependentData};
  for (const JudgedFigure& figure : rows)
    if (figure.fit == newest.fit && figure.limits_sha256 == newest.limits_sha256) out.figures.push_back(figure);
  const std::optional<Verdict> found = analysis::worst_of(out.figures);
  for (const JudgedFigure& figure : rows)
    if (figure.verdict > found) out.stored_worse.push_back(figure);
  const auto limits = std::ranges::find(stored, newest.limits_sha256, &db::VerdictRecord::limits_sha256);
  out.limits_toml = limits->limits_toml;
  out.limits_sha256 = limits->limits_sha256;
  out.limits_name = parse_limits(out.limits_toml, "the limits stored with the verdicts").name;
  conclude(out);
  return out;
}

std::vector<analysis::Figure> judged_figures(analysis::Runs& runs, const analysis::SensorModel& fit,
                                             const analysis::Evaluation& evaluation, const analysis::Limits& limits,
                                             const analysis::ReferenceUncertainty& reference,
                                             analysis::ModelRunResults& of_models) {
  const analysis::Dataset &judged = runs.dataset(evaluation.run), &models = runs.dataset(fit.run);
  std::vector<analysis::Figure> figures =
      analysis::measured_figures(judged, models, fit, evaluation, reference, 0, &of_models);
  if (limits.mpe.empty()) return figures;
  if (!of_models.sweeps) {
    analysis::SensorModel rising = fit;
    const analysis::Dataset turned = analysis::as_modelled(models, rising);
    rising.falling = false;
    of_models.sweeps = analysis::sweep_errors(turned, rising);
  }
  analysis::Uncertainty readings;
  readings.conditions = analysis::reading_conditions(
      models, fit, runs.record(fit.run), held_out_histories(runs, fit.run, {evaluation.run}), *of_models.sweeps);
  std::ranges::move(analysis::judged_mpe(analysis::mpe_figures(judged, fit, &readings, limits.mpe)),
                    std::back_inserter(figures));
  return figures;
}

}  // namespace tactbench::bench
