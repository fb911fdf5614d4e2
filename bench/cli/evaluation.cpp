#include "bench/cli/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "analysis/identify/lanes.h"
#include "analysis/report/gather.h"
#include "analysis/statistics/evaluation.h"
#include "analysis/statistics/figures.h"
#include "analysis/statistics/limits.h"
#include "bench/build_info.h"
#include "bench/cli/report_budget.h"
#include "bench/config.h"
#include "bench/utc.h"
#include "db/run_store.h"

namespace tactbench::bench {

std::string this_build() {
  return fmt::format("commit {}; {}; {}", commit_text(), build_info().build,
                     analysis::to_string(analysis::lane_levels().back()));
}

analysis::ArrayFit fit_run(db::RunStore& store, std::int64_t run) {
  analysis::ArrayFit fit = analysis::fit_array(analysis::load_dataset(store, run));
  analysis::store_fit(store, fit, build_info().version, utc_now(), this_build());
  return fit;
}

std::vector<NamedEvaluation> evaluate_runs(const db::RunStore& store, const analysis::ArrayFit& fit,
                                           const std::vector<std::int64_t>& held_out,
                                           const std::vector<std::string>& titles) {
  std::vector<NamedEvaluation> evaluations;
  evaluations.push_back(
      {fmt::format("run {}, the fit's own", fit.run), analysis::evaluate(analysis::load_dataset(store, fit.run), fit)});
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    const std::string title = i < titles.size() ? titles[i] : fmt::format("held-out run {}", held_out[i]);
    evaluations.push_back({title, analysis::evaluate(analysis::load_dataset(store, held_out[i]), fit)});
  }
  return evaluations;
}

const analysis::Evaluation& judged(const std::vector<NamedEvaluation>& evaluations) {
  return evaluations[evaluations.size() > 1 ? 1 : 0].evaluation;
}

std::vector<analysis::JudgedUncertainty> uncertainties_of(const db::RunStore& store, const analysis::ArrayFit& fit,
                                                          const analysis::Evaluation& evaluation) {
  const analysis::Dataset judged = analysis::load_dataset(store, evaluation.run);
  const analysis::ReferenceUncertainty reference = analysis::reference_uncertainty(store.run(evaluation.run));
  if (evaluation.run == fit.run) return analysis::judged_uncertainties(judged, judged, fit, evaluation, reference);
  return analysis::judged_uncertainties(judged, analysis::load_dataset(store, fit.run), fit, evaluation, reference);
}

std::vector<db::VerdictRecord> judge_anew(const db::RunStore& store, const analysis::ArrayFit& fit,
                                          const analysis::Evaluation& evaluation, const analysis::Limits& limits) {
  if (!analysis::needs_uncertainty(limits.rule)) return analysis::judge(evaluation, fit, limits);
  return analysis::judge(evaluation, fit, limits, uncertainties_of(store, fit, evaluation));
}

void warn_of_conditional(const std::vector<db::VerdictRecord>& verdicts) {
  const auto count = [&](const char* word) { return std::ranges::count(verdicts, word, &db::VerdictRecord::verdict); };
  if (const auto passes = count("conditional pass"); passes > 0)
    fmt::print(stderr, "warning: {} of {} criteria pass conditionally: within U below the limit\n", passes,
               verdicts.size());
  if (const auto fails = count("conditional fail"); fails > 0)
    fmt::print(stderr, "warning: {} of {} criteria fail conditionally: within U above the limit\n", fails,
               verdicts.size());
}

std::vector<db::VerdictRecord> judge_and_store(db::RunStore& store, const analysis::ArrayFit& fit,
                                               const analysis::Evaluation& evaluation, const std::string& limits_file) {
  const analysis::Limits limits = read_limits(find_config(limits_file));
  std::vector<db::VerdictRecord> verdicts = judge_anew(store, fit, evaluation, limits);
  const std::optional<db::FitRecord> record = store.latest_fit(fit.run, analysis::kElamFit);
  const bool stated = limits.rule != analysis::DecisionRule::kReportOnly;
  store.replace_verdicts(evaluation.run, record ? record->fit : 0,
                         stated ? verdicts : std::vector<db::VerdictRecord>());
  return verdicts;
}

std::string follow_sensor(db::RunStore& store, const analysis::ArrayFit& fit, const analysis::Evaluation& own) {
  const db::RunRecord run = store.run(fit.run);
  if (run.sensor_serial.empty()) return {};
  std::string recipes;
  for (const db::SequenceRecord& sequence : run.sequences)
    recipes += fmt::format("{}{}", recipes.empty() ? "" : "+", sequence.name);
  std::string subject = fmt::format("sensor/{}/{}", run.sensor_serial, recipes);
  store.replace_figures(fit.run, subject, analysis::figures_of(fit, own));
  return subject;
}

void add_uncertainty(const db::RunStore& store, const analysis::ArrayFit& fit,
                     const std::vector<NamedEvaluation>& evaluations, analysis::ReportInput& input,
                     const analysis::UncertaintyInputs& inputs) {
  input.uncertainty =
      analysis::assess_uncertainty(analysis::load_dataset(store, fit.run), fit, store.run(fit.run), inputs);
  if (input.verdicts.empty()) return;
  for (const NamedEvaluation& named : evaluations) {
    if (named.evaluation.run != input.verdicts.front().run) continue;
    input.judged = uncertainties_of(store, fit, named.evaluation);
    return;
  }
}

analysis::ReportInput report_input(const db::RunStore& store, std::int64_t run, const analysis::ArrayFit& fit,
                                   const std::vector<NamedEvaluation>& evaluations,
                                   const std::vector<db::VerdictRecord>& verdicts,
                                   const std::vector<std::int64_t>& further, const ReportExtras* extras) {
  analysis::ReportInput input;
  input.fit = fit;
  if (!evaluations.empty()) input.evaluation = evaluations.front().evaluation;
  for (std::size_t i = 1; i < evaluations.size(); ++i) {
    input.held_out.push_back(
        {evaluations[i].title, store.run(evaluations[i].evaluation.run), evaluations[i].evaluation});
  }
  input.verdicts = verdicts;
  input.program_version = build_info().version;
  analysis::gather_run(input, store, run, further);
  if (extras == nullptr) return input;
  add_results(input, store, *extras);
  if (!evaluations.empty() && fit.run == run)
    add_uncertainty(store, fit, evaluations, input, budget_inputs(store, input, further, extras->studies));
  return input;
}

std::string report_path(const db::RunStore& store, const std::string& name) {
  return (std::filesystem::path(store.path()).parent_path() / "reports" / name).string();
}

std::string write_report(const db::RunStore& store, const analysis::ArrayFit& fit,
                         const std::vector<NamedEvaluation>& evaluations,
                         const std::vector<db::VerdictRecord>& verdicts, std::string path, std::string* number,
                         const ReportExtras& extras) {
  const analysis::Report report =
      analysis::render_report(report_input(store, fit.run, fit, evaluations, verdicts, {}, &extras));
  if (path.empty()) path = report_path(store, fmt::format("run-{}.html", fit.run));
  write_whole(path, report.html);
  if (number != nullptr) *number = report.number;
  return path;
}

}  // namespace tactbench::bench
