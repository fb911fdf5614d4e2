#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/report/overview.h"
#include "analysis/statistics/evaluation.h"
#include "bench/cli/evaluation.h"
#include "bench/cli/named_evaluation.h"
#include "bench/cli/report_pdf.h"
#include "bench/config.h"
#include "bench/config_laboratory.h"
#include "bench/utc.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct ReportOptions {
  std::vector<std::int64_t> runs, held_out;
  std::int64_t model_run = 0;  // 0: the run's own models
  std::string format = "html", limits, lab, output, approve_by, issued, paper = "a4", pdf_with;
  bool compare = false, batch = false;
  ReportExtras extras;
};

void check_report_options(const ReportOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error(ExitCode::kUsage, "TB-USAGE", what, "report", remedy);
  };
  if (options.compare && options.batch) refuse("--compare and --batch are two pages", "ask for one of them");
  if (options.compare && options.runs.size() != 2)
    refuse(fmt::format("--compare takes two runs, not {}", options.runs.size()), "tactbench report --compare 1 2");
  const bool several = options.compare || options.batch;
  if (several && (!options.approve_by.empty() || !options.held_out.empty() || !options.lab.empty() ||
                  !options.extras.previous.empty() || !options.extras.studies.empty()))
    refuse("--approve-by, --held-out, --lab, --previous and --studies belong to the report of one run",
           "report each run by itself, then compare");
  if (!options.issued.empty() && !is_iso_date(options.issued))
    refuse(fmt::format("'{}' is not a date", options.issued), "write it as 2026-01-31");
}

// Models of `model_run`, none where it has none: then the report says what it does not show.
analysis::ArrayFit models_for(const db::RunStore& store, std::int64_t model_run) {
  if (!store.latest_fit(model_run, analysis::kElamFit)) return {};
  return analysis::load_fit(store, model_run);
}

// A run that sweeps no full loop is not evaluated, and has no figure after compensation.
std::vector<NamedEvaluation> evaluations_for(const db::RunStore& store, const analysis::ArrayFit& fit, std::int64_t run,
                                             const std::vector<std::int64_t>& held_out) {
  std::vector<NamedEvaluation> evaluations;
  if (fit.taxels.empty()) return evaluations;
  try {
    if (run == fit.run) return evaluate_runs(store, fit, held_out);
    evaluations.push_back({fmt::format("run {}, models of run {}", run, fit.run),
                           analysis::evaluate(analysis::load_dataset(store, run), fit)});
    for (const std::int64_t other : held_out)
      evaluations.push_back(
          {fmt::format("held-out run {}", other), analysis::evaluate(analysis::load_dataset(store, other), fit)});
  } catch (const analysis::AnalysisError& error) {
    if (error.id() != "TB-ANALYSIS-NO-LOOP" || !held_out.empty()) throw;
    evaluations.clear();
  }
  return evaluations;
}

// --limits judges anew without storing (contract.md, "Words on the command line").
std::vector<db::VerdictRecord> verdicts_for(const db::RunStore& store, const std::vector<NamedEvaluation>& evaluations,
                                            const analysis::ArrayFit& fit, std::int64_t run,
                                            const std::string& limits) {
  if (evaluations.empty()) return limits.empty() ? store.verdicts(run) : std::vector<db::VerdictRecord>();
  const analysis::Evaluation& evaluation = judged(evaluations);
  return limits.empty() ? store.verdicts(evaluation.run)
                        : judge_anew(store, fit, evaluation, read_limits(find_config(limits)));
}

analysis::ReportInput input_for(const db::RunStore& store, const ReportOptions& options, std::int64_t run) {
  (void)store.run(run);  // says which runs there are before anything else is said
  const bool several = options.compare || options.batch;
  const std::int64_t model_run = options.model_run != 0 ? options.model_run : run;
  const analysis::ArrayFit fit = models_for(store, model_run);
  if (fit.taxels.empty())
    fmt::print(stderr,
               "note: run {} has no models: the report shows what was measured, nothing compensated; `tactbench fit "
               "{}` makes some\n",
               model_run, model_run);
  const std::vector<NamedEvaluation> evaluations = evaluations_for(store, fit, run, options.held_out);
  const std::vector<std::int64_t> further =
      several ? std::vector<std::int64_t>() : std::vector<std::int64_t>(options.runs.begin() + 1, options.runs.end());
  analysis::ReportInput input =
      report_input(store, run, fit, evaluations, verdicts_for(store, evaluations, fit, run, options.limits), further,
                   several ? nullptr : &options.extras);
  if (!options.lab.empty()) input.laboratory = read_laboratory(find_config(options.lab));
  input.issued = options.issued;
  input.paper = options.paper == "letter" ? analysis::PaperSize::kLetter : analysis::PaperSize::kA4;
  return input;
}

// The second run's data with the first run's models: what the sensor was worth before it was adjusted.
void add_as_found(const db::RunStore& store, analysis::ReportInput& first, const analysis::ReportInput& second) {
  if (first.fit.taxels.empty() || second.run.sensor_serial != first.run.sensor_serial) return;
  const std::vector<NamedEvaluation> found = evaluations_for(store, first.fit, second.run.run, {});
  if (!found.empty()) first.held_out.push_back({"as found", second.run, found.front().evaluation});
}

struct WrittenReport {
  analysis::Report report;
  std::vector<db::VerdictRecord> verdicts;
  std::string origin, started_utc, name;  // name: of the file, without its ending
};

WrittenReport several_runs(const db::RunStore& store, const ReportOptions& options) {
  std::vector<analysis::ReportInput> inputs;
  for (const std::int64_t run : options.runs) inputs.push_back(input_for(store, options, run));
  WrittenReport out;
  if (options.compare) add_as_found(store, inputs[0], inputs[1]);
  out.report = options.compare ? analysis::render_comparison(inputs[0], inputs[1]) : analysis::render_batch(inputs);
  for (const analysis::ReportInput& input : inputs) {
    out.verdicts.insert(out.verdicts.end(), input.verdicts.begin(), input.verdicts.end());
    out.started_utc = std::max(out.started_utc, input.run.started_utc);
  }
  out.origin = inputs.front().run.origin;
  out.name = options.compare ? fmt::format("compare-{}-{}", options.runs[0], options.runs[1])
                             : fmt::format("batch-{}", out.report.number);
  return out;
}

WrittenReport one_run(db::RunStore& store, const ReportOptions& options) {
  analysis::ReportInput input = input_for(store, options, options.runs.front());
  WrittenReport out;
  out.report = analysis::render_report(input);
  if (!options.approve_by.empty()) {
    const std::vector<db::ReportRecord> before = store.reports(input.run.run);
    store.add_report({input.run.run, out.report.number, out.report.content_sha256, options.approve_by, utc_now(),
                      before.empty() ? "" : before.back().number});
    input.approvals = store.reports(input.run.run);
    out.report = analysis::render_report(input);
  }
  out.verdicts = input.verdicts;
  out.origin = input.run.origin;
  out.started_utc = input.run.started_utc;
  out.name = fmt::format("run-{}", input.run.run);
  return out;
}

void report_runs(const ReportOptions& options, Session& session) {
  check_report_options(options);
  if (!options.lab.empty()) (void)read_laboratory(find_config(options.lab));  // before anything is approved
  db::RunStore store =
      options.approve_by.empty() ? db::RunStore::open_read_only(session.db) : db::RunStore::open(session.db);
  const WrittenReport written =
      options.compare || options.batch ? several_runs(store, options) : one_run(store, options);
  const std::string path =
      options.output.empty() ? report_path(store, fmt::format("{}.{}", written.name, options.format)) : options.output;
  if (options.format == "pdf") {
    write_pdf({written.report.html, written.report.json, path, options.pdf_with, written.started_utc});
  } else {
    write_whole(path, options.format == "json" ? written.report.json + "\n" : written.report.html);
  }
  session.code = exit_code_of(written.verdicts);
  warn_of_conditional(written.verdicts);
  if (session.json) {
    print_json("report", {{"run", options.runs.front()},
                          {"runs", options.runs},
                          {"number", written.report.number},
                          {"path", path},
                          {"origin", written.origin},
                          {"verdicts", verdicts_json(written.verdicts, written.origin)}});
    return;
  }
  const bool one = !options.compare && !options.batch;
  if (one && !written.verdicts.empty()) fmt::print("{}\n", verdict_table(written.verdicts, written.origin));
  fmt::print("report {}: {}\n", written.report.number, path);
}

}  // namespace

void add_report(CLI::App& app, Session& session) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand(
      "report", "write the calibration report of a run, a comparison of two, or a page on many, as one file");
  verb->add_option("runs", options->runs,
                   "the run; further runs of the same sensor after it add what one does not tell (creep, temperature)")
      ->required()
      ->take_all();
  verb->add_option("--held-out", options->held_out, "runs of the same sensor to show compensated with the models")
      ->take_all();
  verb->add_option("--previous", options->extras.previous,
                   "models used before: the report says how this run is found with them (a .json file, or RUN[:FIT])");
  verb->add_option(
          "--studies", options->extras.studies,
          "further runs of the sensor: under objects, at several rates, held (their recipes tell), at another "
          "temperature (their thermometer tells), mounted anew (RUN:mount), turned in the chamber (RUN:90, RUN:180, "
          "RUN:270); held levels and temperature enter the uncertainty")
      ->take_all();
  verb->add_option("--model", options->model_run, "take the models of this run (default: the run's own)");
  verb->add_option("--format", options->format, "html, pdf (needs chromium or weasyprint), or json: the data alone")
      ->check(CLI::IsMember({"html", "pdf", "json"}))
      ->capture_default_str();
  verb->add_option("--limits", options->limits, "judge anew by this limits file, without storing");
  verb->add_option("--lab", options->lab, "laboratory file: what no instrument knows (init writes one)");
  verb->add_option("--approve-by", options->approve_by,
                   "store that this person signs for the report; a changed one names the number that it replaces");
  verb->add_option("--issued-at", options->issued, "date of issue, as 2026-01-31 (default: the day of the approval)");
  verb->add_option("--paper", options->paper, "a4 or letter")
      ->check(CLI::IsMember({"a4", "letter"}))
      ->capture_default_str();
  verb->add_option("--pdf-with", options->pdf_with, "chromium, or weasyprint, which attaches the data (PDF/A-3b)")
      ->check(CLI::IsMember({"chromium", "weasyprint"}));
  verb->add_flag("--compare", options->compare, "one page on two runs: as found and as left, or two sensors");
  verb->add_flag("--batch", options->batch, "one page on many runs: yield, ranks, distributions, outliers");
  verb->add_option("-o,--output", options->output, "file to write (default: reports/run-N.html beside the store)");
  add_common(*verb, session);
  verb->callback([options, &session] { report_runs(*options, session); });
}

}  // namespace tactbench::bench
