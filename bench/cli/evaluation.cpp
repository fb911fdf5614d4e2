#include "bench/cli/evaluation.h"

#include <fmt/format.h>

#include <filesystem>

#include "analysis/identify/lanes.h"
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

std::string write_report(const db::RunStore& store, const analysis::ArrayFit& fit,
                         const std::vector<NamedEvaluation>& evaluations,
                         const std::vector<db::VerdictRecord>& verdicts, std::string path, std::string* number,
                         const ReportExtras& extras) {
  analysis::ReportInput input;
  input.run = store.run(fit.run);
  input.sensor = store.sensor(input.run.sensor_serial);
  input.fit = fit;
  input.evaluation = evaluations.front().evaluation;
  for (std::size_t i = 1; i < evaluations.size(); ++i) {
    input.held_out.push_back(
        {evaluations[i].title, store.run(evaluations[i].evaluation.run), evaluations[i].evaluation});
  }
  input.verdicts = verdicts;
  input.program_version = TACTBENCH_VERSION;
  input.frame_count = store.frame_count(fit.run);
  add_results(input, store, extras);
  const analysis::Report report = analysis::render_report(input);
  namespace fs = std::filesystem;
  if (path.empty()) {
    path = (fs::path(store.path()).parent_path() / "reports" / fmt::format("run-{}.html", fit.run)).string();
  }
  write_whole(path, report.html);
  if (number != nullptr) *number = report.number;
  return path;
}

}  // namespace tactbench::bench
