#include "bench/cli/evaluation.h"

#include <fmt/format.h>

#include <filesystem>

#include "analysis/identify/lanes.h"
#include "analysis/report/gather.h"
#include "analysis/statistics/figures.h"
#include "bench/utc.h"
#include "build_info.h"

namespace tactbench::bench {

std::string this_build() {
  return fmt::format("commit {}{}; {}; {}", TACTBENCH_COMMIT, TACTBENCH_DIRTY ? ", modified" : "", TACTBENCH_BUILD,
                     analysis::to_string(analysis::lane_levels().back()));
}

analysis::ArrayFit fit_run(db::RunStore& store, std::int64_t run) {
  analysis::ArrayFit fit = analysis::fit_array(analysis::load_dataset(store, run));
  analysis::store_fit(store, fit, TACTBENCH_VERSION, utc_now(), this_build());
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

std::vector<db::VerdictRecord> judge_and_store(db::RunStore& store, const analysis::ArrayFit& fit,
                                               const analysis::Evaluation& evaluation, const std::string& limits_file) {
  std::vector<db::VerdictRecord> verdicts = analysis::judge(evaluation, fit, read_limits(find_config(limits_file)));
  const std::optional<db::FitRecord> record = store.latest_fit(fit.run, analysis::kElamFit);
  store.replace_verdicts(evaluation.run, record ? record->fit : 0, verdicts);
  return verdicts;
}

std::string follow_sensor(db::RunStore& store, const analysis::ArrayFit& fit, const analysis::Evaluation& own) {
  const db::RunRecord run = store.run(fit.run);
  if (run.sensor_serial.empty()) return {};
  std::string recipes;
  for (const db::SequenceRecord& sequence : run.sequences)
    recipes += fmt::format("{}{}", recipes.empty() ? "" : "+", sequence.name);
  const std::string subject = fmt::format("sensor/{}/{}", run.sensor_serial, recipes);
  store.replace_figures(fit.run, subject, analysis::figures_of(fit, own));
  return subject;
}

analysis::ReportInput report_input(const db::RunStore& store, std::int64_t run, const analysis::ArrayFit& fit,
                                   const std::vector<NamedEvaluation>& evaluations,
                                   const std::vector<db::VerdictRecord>& verdicts,
                                   const std::vector<std::int64_t>& further) {
  analysis::ReportInput input;
  input.fit = fit;
  if (!evaluations.empty()) input.evaluation = evaluations.front().evaluation;
  for (std::size_t i = 1; i < evaluations.size(); ++i) {
    input.held_out.push_back(
        {evaluations[i].title, store.run(evaluations[i].evaluation.run), evaluations[i].evaluation});
  }
  input.verdicts = verdicts;
  input.program_version = TACTBENCH_VERSION;
  analysis::gather_run(input, store, run, further);
  return input;
}

std::string report_path(const db::RunStore& store, const std::string& name) {
  return (std::filesystem::path(store.path()).parent_path() / "reports" / name).string();
}

std::string write_report(const db::RunStore& store, const analysis::ArrayFit& fit,
                         const std::vector<NamedEvaluation>& evaluations,
                         const std::vector<db::VerdictRecord>& verdicts, std::string path, std::string* number) {
  const analysis::Report report = analysis::render_report(report_input(store, fit.run, fit, evaluations, verdicts));
  if (path.empty()) path = report_path(store, fmt::format("run-{}.html", fit.run));
  write_whole(path, report.html);
  if (number != nullptr) *number = report.number;
  return path;
}

}  // namespace tactbench::bench
