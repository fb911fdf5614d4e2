#include "bench/reporting/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/report/gather.h"
#include "analysis/statistics/figures/evaluation.h"
#include "bench/common/build_info.h"
#include "bench/common/output_file.h"
#include "bench/common/utc.h"
#include "bench/common/work_progress.h"
#include "bench/config/config.h"
#include "bench/reporting/report_budget.h"
#include "bench/reporting/report_results.h"
#include "bench/reporting/signed_reports.h"
#include "bench/reporting/study_roles.h"
#include "db/run_store.h"

namespace tactbench::bench {

std::string this_build() {
  return fmt::format("commit {}; {}; {}", commit_text(), build_info().build, processor_class());
}

std::int64_t keep_fit(db::RunStore& store, const analysis::SensorModel& fit) {
  return analysis::store_fit(store, fit, build_info().version, utc_now(), this_build());
}

analysis::SensorModel fit_run(db::RunStore& store, const analysis::Dataset& dataset) {
  analysis::SensorModel fit = analysis::fit_array(dataset);
  fit.fit = keep_fit(store, fit);
  return fit;
}

analysis::SensorModel fit_run_dynamic(db::RunStore& store, analysis::Runs& runs, std::int64_t run) {
  analysis::SensorModel fit = analysis::fit_dynamic_single_run(runs.dataset(run));
  fit.content_sha256 = runs.record(run).content_sha256;
  fit.program_version = build_info().version;
  fit.fit = keep_fit(store, fit);
  return fit;
}

std::vector<NamedEvaluation> evaluate_runs(analysis::Runs& runs, const analysis::SensorModel& fit,
                                           const std::vector<std::int64_t>& held_out,
                                           const std::vector<std::string>& titles) {
  std::vector<NamedEvaluation> evaluations;
  evaluations.push_back(
      {fmt::format("run {}, the fit's own", fit.run), analysis::evaluate(runs.dataset(fit.run), fit)});
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    const std::string title = i < titles.size() ? titles[i] : fmt::format("held-out run {}", held_out[i]);
    evaluations.push_back({title, analysis::evaluate(runs.dataset(held_out[i]), fit)});
  }
  return evaluations;
}

std::string record_sensor_trend(db::Models& store, const db::RunRecord& run, const analysis::SensorModel& fit,
                                const analysis::Evaluation& own) {
  if (run.sensor_serial.empty()) return {};
  std::string recipes;
  for (const db::SequenceRecord& sequence : run.sequences)
    recipes += fmt::format("{}{}", recipes.empty() ? "" : "+", sequence.name);
  std::string subject = fmt::format("sensor/{}/{}{}", run.sensor_serial, recipes, fit.dynamics ? "/dynamic" : "");
  store.replace_figures(fit.run, subject, analysis::figures_of(fit, own));
  return subject;
}

void record_fit_trend(db::RunStore& store, const analysis::SensorModel& fit, const analysis::Evaluation& own) {
  const std::string kind = store.fit(fit.fit).model;
  if (kind == analysis::kElamFit || kind == analysis::kDynamicModel)
    (void)record_sensor_trend(store, store.run(fit.run), fit, own);
}

analysis::ReportInput report_input(analysis::Runs& runs, std::int64_t run, const analysis::SensorModel& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const JudgementRecord& judged,
                                   const std::vector<std::int64_t>& further, const ReportExtras* extras) {
  analysis::ReportInput input;
  input.fit = fit;
  if (!evaluations.empty()) input.evaluation = evaluations.front().evaluation;
  for (std::size_t i = 1; i < evaluations.size(); ++i) {
    input.held_out.push_back(
        {evaluations[i].title, runs.record(evaluations[i].evaluation.run), evaluations[i].evaluation});
  }
  if (extras != nullptr) {
    input.laboratory = extras->laboratory;
    input.unit = extras->unit;
  }
  input.judgement = judged.judgement;
  input.program_version = build_info().version;
  analysis::gather_run(input, runs, run, further);
  input.method = method_descriptions(input.run);
  if (extras == nullptr) return input;
  begin_stage("models");
  add_results(input, runs, *extras);
  judge_as_found(runs, input, extras->previous, judged.limits);
  if (!evaluations.empty() && fit.run == run) {
    begin_stage("uncertainty");
    const analysis::UncertaintyInputs inputs = budget_inputs(runs, input, further, extras->studies);
    input.uncertainty = analysis::assess_uncertainty(runs.dataset(run), fit, runs.record(run), inputs);
    analysis::Evidence evidence = judged.evidence;
    const auto studied = [&](bool assessed, analysis::Source source) {
      if (assessed) evidence.studied.insert(source);
    };
    studied(inputs.mounting.has_value(), analysis::Source::kRemounting);
    studied(inputs.temperature.assessed(), analysis::Source::kTemperature);
    studied(inputs.creep.assessed(), analysis::Source::kCreep);
    if (!evidence.runs.empty()) input.judgement = judge(evidence, judged.limits);
  }
  return input;
}

std::string report_path(const db::RunReader& store, const std::string& name) {
  return (std::filesystem::path(store.path()).parent_path() / "reports" / name).string();
}

std::string write_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                         const std::vector<NamedEvaluation>& evaluations, const JudgementRecord& judged,
                         std::string path, std::string* number, const ReportExtras& extras, bool replace) {
  const analysis::Report report =
      analysis::render_report(report_input(runs, fit.run, fit, evaluations, judged, {}, &extras));
  const db::RunStore& store = runs.store();
  if (path.empty())
    path = free_report_path(store, fmt::format("run-{}.html", fit.run), fmt::format("run-{}.html", report.number),
                            runs.record(fit.run).uuid);
  if (may_be_written(path, report.number, store)) write_output(path, report.html, replace);
  if (number != nullptr) *number = report.number;
  return path;
}

}  // namespace tactbench::bench
