#include "bench/reporting/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <set>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/elam/dispatch.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/report/gather.h"
#include "analysis/statistics/conformity/overall_verdict.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/figures.h"
#include "bench/common/build_info.h"
#include "bench/common/for_people.h"
#include "bench/common/long_work.h"
#include "bench/common/output_file.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/as_found.h"
#include "bench/reporting/conditions.h"
#include "bench/reporting/judged_figures.h"
#include "bench/reporting/method_words.h"
#include "bench/reporting/report_budget.h"
#include "bench/reporting/signed_reports.h"
#include "db/run_store.h"

namespace tactbench::bench {

std::string this_build() {
  return fmt::format("commit {}; {}; {}", commit_text(), build_info().build,
                     analysis::to_string(analysis::best_dispatch()));
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
  analysis::SensorModel fit = analysis::fit_dynamic_alone(runs.dataset(run));
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

void warn_of_conditional(const std::vector<db::VerdictRecord>& verdicts) {
  const auto count = [&](analysis::Verdict verdict) {
    return std::ranges::count(verdicts, verdict, analysis::verdict_in);
  };
  if (const auto passes = count(analysis::Verdict::kConditionalPass); passes > 0)
    tty::print(stderr, "warning: {} of {} {} conditionally: within U below the limit\n", passes,
               analysis::counted(verdicts.size(), "criterion", "criteria"), passes == 1 ? "passes" : "pass");
  if (const auto fails = count(analysis::Verdict::kConditionalFail); fails > 0)
    tty::print(stderr, "warning: {} of {} {} conditionally: within U above the limit\n", fails,
               analysis::counted(verdicts.size(), "criterion", "criteria"), fails == 1 ? "fails" : "fail");
}

std::string follow_sensor(db::RunStore& store, const db::RunRecord& run, const analysis::SensorModel& fit,
                          const analysis::Evaluation& own) {
  if (run.sensor_serial.empty()) return {};
  std::string recipes;
  for (const db::SequenceRecord& sequence : run.sequences)
    recipes += fmt::format("{}{}", recipes.empty() ? "" : "+", sequence.name);
  std::string subject = fmt::format("sensor/{}/{}", run.sensor_serial, recipes);
  store.replace_figures(fit.run, subject, analysis::figures_of(fit, own));
  return subject;
}

void follow_fit(db::RunStore& store, analysis::Runs& runs, const analysis::SensorModel& fit,
                const analysis::Evaluation& own) {
  const std::string kind = store.fit(fit.fit).model;
  const db::RunRecord& run = runs.record(fit.run);
  if (kind == analysis::kElamFit) {
    (void)follow_sensor(store, run, fit, own);
  } else if (kind == analysis::kDynamicModel && !run.sensor_serial.empty()) {
    const analysis::Dataset& dataset = runs.dataset(fit.run);
    const analysis::SensorModel elam = analysis::fit_array(dataset);
    if (!elam.fitted().empty()) (void)follow_sensor(store, run, elam, analysis::evaluate(dataset, elam));
  }
}

namespace {

// Of the rows' limits file what U depends on: its [[mpe]]. U is shown by any rule.
analysis::Limits limits_of(const std::vector<db::VerdictRecord>& verdicts) {
  analysis::Limits limits;
  const bool some = std::ranges::any_of(verdicts, [](const db::VerdictRecord& row) { return row.criterion == "mpe"; });
  if (some) limits = parse_limits(verdicts.front().limits_toml, "the limits kept with the verdicts");
  limits.rule = analysis::DecisionRule::kDefault;
  return limits;
}

}  // namespace

void add_uncertainty(analysis::Runs& runs, const analysis::SensorModel& fit,
                     const std::vector<NamedEvaluation>& evaluations, analysis::ReportInput& input,
                     const analysis::UncertaintyInputs& inputs, std::vector<analysis::JudgedUncertainty> known) {
  input.uncertainty = analysis::assess_uncertainty(runs.dataset(fit.run), fit, runs.record(fit.run), inputs);
  input.judged = std::move(known);
  for (const analysis::RunVerdict& judged : analysis::verdicts_by_run(input.verdicts)) {
    if (std::ranges::find(input.judged, judged.run, &analysis::JudgedUncertainty::run) != input.judged.end()) continue;
    const analysis::ReferenceUncertainty reference =
        analysis::reference_uncertainty(runs.record(judged.run), input.laboratory.instruments);
    for (const NamedEvaluation& named : evaluations) {
      if (named.evaluation.run != judged.run) continue;
      JudgedFigures figures = judged_figures(runs, fit, named.evaluation, limits_of(input.verdicts), reference);
      std::ranges::move(figures.uncertainties, std::back_inserter(input.judged));
    }
  }
}

std::vector<std::string> withhold_untraced_runs(analysis::Runs& runs, std::vector<db::VerdictRecord>& verdicts,
                                                const std::vector<analysis::InstrumentNote>& notes) {
  std::set<std::int64_t> judged;
  for (const db::VerdictRecord& verdict : verdicts) judged.insert(verdict.run);
  std::vector<std::string> untraced;
  for (const std::int64_t run : judged) {
    const analysis::ReferenceUncertainty reference = analysis::reference_uncertainty(runs.record(run), notes);
    const std::string why = reference.untraced();
    if (why.empty()) continue;
    analysis::withhold_untraced(verdicts, run, reference);
    untraced.push_back(fmt::format("run {}: {}; verdicts on errors against the reference are inconclusive", run, why));
  }
  return untraced;
}

analysis::ReportInput report_input(analysis::Runs& runs, std::int64_t run, const analysis::SensorModel& fit,
                                   const std::vector<NamedEvaluation>& evaluations, const Judgement& judgement,
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
  input.verdicts = judgement.verdicts;
  input.judgement = judgement.notes;
  // Stored verdicts may predate the rules on traceability, or the laboratory file.
  (void)withhold_untraced_runs(runs, input.verdicts, input.laboratory.instruments);
  input.program_version = build_info().version;
  analysis::gather_run(input, runs, run, further);
  input.method = method_words(input.run);
  note_conditions(runs, fit, input.verdicts, nullptr, input.laboratory.instruments, input.judgement);
  if (extras == nullptr) return input;
  begin_stage("models");
  add_results(input, runs, *extras);
  judge_as_found(runs, input, extras->previous);
  if (!evaluations.empty() && fit.run == run) {
    begin_stage("uncertainty");
    const analysis::UncertaintyInputs inputs = budget_inputs(runs, input, further, extras->studies);
    add_uncertainty(runs, fit, evaluations, input, inputs, judgement.uncertainties);
    note_conditions(runs, fit, input.verdicts, &inputs, input.laboratory.instruments, input.judgement);
  }
  return input;
}

std::string report_path(const db::RunStore& store, const std::string& name) {
  return (std::filesystem::path(store.path()).parent_path() / "reports" / name).string();
}

std::string write_report(analysis::Runs& runs, const analysis::SensorModel& fit,
                         const std::vector<NamedEvaluation>& evaluations, const Judgement& judgement, std::string path,
                         std::string* number, const ReportExtras& extras, bool replace) {
  const analysis::Report report =
      analysis::render_report(report_input(runs, fit.run, fit, evaluations, judgement, {}, &extras));
  const db::RunStore& store = runs.store();
  if (path.empty())
    path = free_report_path(store, fmt::format("run-{}.html", fit.run), fmt::format("run-{}.html", report.number),
                            runs.record(fit.run).uuid);
  if (may_be_written(path, report.number, store)) write_output(path, report.html, replace);
  if (number != nullptr) *number = report.number;
  return path;
}

}  // namespace tactbench::bench
