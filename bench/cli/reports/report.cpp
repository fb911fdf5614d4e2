#include "bench/cli/reports/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/report/dcc/dcc.h"
#include "analysis/report/overview/overview.h"
#include "analysis/report/overview/table_report.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/reports/report_sign.h"
#include "bench/cli/runs/source.h"
#include "bench/common/output_file.h"
#include "bench/common/utc.h"
#include "bench/common/work_progress.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/evidence.h"
#include "bench/reporting/report_pdf.h"
#include "bench/reporting/report_results.h"
#include "bench/reporting/signed_reports.h"
#include "db/remarks.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

// The models named: for a run its current fit, if that is of the whole array; else none, and the report says what it
// does not show.
analysis::SensorModel models_for(analysis::Runs& runs, const ModelReference& named) {
  const db::RunStore& store = runs.store();
  const std::int64_t model_run = named.run;
  if (named.fit != 0) {
    analysis::SensorModel fit = analysis::load_model(fmt::format("{}:{}", model_run, named.fit), &store);
    check_models_of_array(runs, fit, named);
    return fit;
  }
  if (runs.record(model_run).origin == "imported") check_models_of_array(runs, {}, named);
  const std::optional<db::FitRecord> record = store.default_fit(model_run);
  if (!record) return {};
  analysis::SensorModel fit = analysis::load_fit(*record);
  return fit.fitted().empty() ? analysis::SensorModel{} : fit;
}

// By position, "held-out run B", because the same runs have other numbers in another store and a report's content has
// no run numbers.
std::vector<std::string> titles_of(const std::vector<std::int64_t>& held_out) {
  std::vector<std::string> titles;
  for (std::size_t i = 0; i < held_out.size(); ++i) {
    const std::string letter(1 + i / 26, static_cast<char>('A' + i % 26));  // A to Z, AA to ZZ, AAA
    titles.push_back(held_out.size() == 1 ? "held-out run" : "held-out run " + letter);
  }
  return titles;
}

// A run without a full loop is not evaluated and has no compensated figures.
std::vector<NamedEvaluation> evaluations_for(analysis::Runs& runs, const analysis::SensorModel& fit, std::int64_t run,
                                             const std::vector<std::int64_t>& held_out) {
  std::vector<NamedEvaluation> evaluations;
  if (fit.taxels.empty()) return evaluations;
  try {
    const std::vector<std::string> titles = titles_of(held_out);
    if (run == fit.run) return evaluate_runs(runs, fit, held_out, titles);
    evaluations.push_back(
        {fmt::format("run {}, models of run {}", run, fit.run), analysis::evaluate(runs.dataset(run), fit)});
    for (std::size_t i = 0; i < held_out.size(); ++i)
      evaluations.push_back({titles[i], analysis::evaluate(runs.dataset(held_out[i]), fit)});
  } catch (const analysis::AnalysisError& error) {
    if (error.id() != "TB-ANALYSIS-NO-LOOP" || !held_out.empty()) throw;  // nothing was evaluated before
  }
  return evaluations;
}

// --limits judges without storing.
analysis::ReportInput input_for(analysis::Runs& runs, const ReportOptions& options, std::int64_t run,
                                const Session& session) {
  const bool several = options.compare || options.batch;
  const ModelReference named = parse_model_reference(options.model, run);
  const std::int64_t model_run = named.run;
  const analysis::SensorModel fit = models_for(runs, named);
  check_independent_of_dynamics(runs.store(), fit, options.held_out);
  if (fit.taxels.empty())
    tty::print(stderr,
               "note: run {} has no models: the report shows the measurements without correction; `tactbench fit {}` "
               "makes models\n",
               model_run, model_run);
  const StoredVerdicts stored = stored_verdicts(runs, fit, session.void_too);
  // A fit keeps the runs that it was judged on.
  const bool by_store = options.held_out.empty() && run == fit.run;
  const std::vector<NamedEvaluation> evaluations =
      evaluations_for(runs, fit, run, by_store ? stored.runs : options.held_out);
  JudgementRecord judged;
  if (evaluations.empty() && options.limits.empty())
    judged.judgement = judgement_on(runs.store(), run);
  else
    judged = judge_for_report(runs, fit, evaluations, options.limits, session.void_too,
                              options.extras.laboratory.instruments, stored);
  const std::vector<std::int64_t> further =
      several ? std::vector<std::int64_t>() : std::vector<std::int64_t>(options.runs.begin() + 1, options.runs.end());
  ReportExtras extras = options.extras;
  if (extras.previous == kNoPrevious)
    extras.previous.clear();
  else if (extras.previous.empty() && !several && run == fit.run && !evaluations.empty())
    extras.previous = models_before(runs, run);
  analysis::ReportInput input = report_input(runs, run, fit, evaluations, judged, further, several ? nullptr : &extras);
  if (const auto worst = std::ranges::max_element(
          input.held_out, {}, [](const analysis::HeldOut& own) { return own.evaluation.mean_error_psi; });
      options.batch && worst != input.held_out.end())
    input.evaluation = worst->evaluation;  // sensors are ranked by the runs on which they were judged
  if (several) input.held_out.clear();     // each run's own report has their figures
  input.issued = options.issued;
  input.unit = session.page_unit();
  input.paper = options.paper == "letter" ? analysis::PaperSize::kLetter : analysis::PaperSize::kA4;
  return input;
}

// The second run's data with the first run's models: the sensor as found, before adjustment.
void add_as_found(analysis::Runs& runs, analysis::ReportInput& first, const analysis::ReportInput& second) {
  if (first.fit.taxels.empty() || second.run.sensor_serial != first.run.sensor_serial) return;
  const std::vector<NamedEvaluation> found = evaluations_for(runs, first.fit, second.run.run, {});
  if (!found.empty()) first.held_out.push_back({"as found", second.run, found.front().evaluation});
}

// Whose report, and its file; `name` and `numbered` without their ending.
void place(WrittenReport& out, const db::RunStore& store, const ReportOptions& options, const db::RunRecord& first,
           const std::string& name, const std::string& numbered) {
  const std::string ending = options.format == "dcc" ? "xml" : options.format;
  out.origin = first.origin;
  out.run_uuid = first.uuid;
  out.path = !options.output.empty() ? options.output
                                     : free_report_path(store, fmt::format("{}.{}", name, ending),
                                                        fmt::format("{}.{}", numbered, ending), first.uuid);
  out.written = may_be_written(out.path, out.report.number, store);
}

// Of a comparison or a batch.
std::string report_stage_of(std::int64_t run) { return fmt::format("run {}", run); }

WrittenReport several_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session) {
  const db::RunStore& store = runs.store();
  std::vector<analysis::ReportInput> inputs;
  for (const std::int64_t run : options.runs) {
    // For many runs, only the samples of one row at a time are in memory.
    std::optional<analysis::Runs> of_row;
    begin_stage(report_stage_of(run));
    inputs.push_back(input_for(options.batch ? of_row.emplace(store) : runs, options, run, session));
  }
  WrittenReport out;
  if (options.compare) add_as_found(runs, inputs[0], inputs[1]);
  out.report = options.compare ? analysis::render_comparison(inputs[0], inputs[1]) : analysis::render_batch(inputs);
  std::vector<std::size_t> rows = options.compare ? std::vector<std::size_t>{0, 1} : analysis::batch_rows(inputs);
  for (const std::size_t row : rows) {
    out.judgements.push_back(inputs[row].judgement);
    out.started_utc = std::max(out.started_utc, inputs[row].run.started_utc);
  }
  place(out, store, options, inputs.front().run,
        options.compare ? fmt::format("compare-{}-{}", options.runs[0], options.runs[1])
                        : fmt::format("batch-{}", out.report.number),
        fmt::format("{}-{}", options.compare ? "compare" : "batch", out.report.number));
  return out;
}

std::string as_found_text(const analysis::AsFound& found, bool by_store, analysis::PressureUnit unit) {
  return fmt::format("as found, by the models {}{}: mean |error| {}{}", found.model,
                     by_store ? " (--previous none leaves it out)" : "", unit.text(found.evaluation.mean_error_psi, 2),
                     found.judgement.overall ? fmt::format(", {}", to_string(*found.judgement.overall)) : "");
}

// The runs on which the report is based, its own first.
std::vector<db::ReportRecord::Evidence> evidence_of(analysis::Runs& runs, const analysis::ReportInput& input,
                                                    const std::vector<std::string>& studies) {
  std::vector<std::int64_t> numbers = {input.run.run};
  std::ranges::copy(source_runs(runs.store(), input.fit), std::back_inserter(numbers));
  for (const analysis::HeldOut& held_out : input.held_out) numbers.push_back(held_out.run.run);
  for (const analysis::JudgedFigure& figure : input.judgement.figures) numbers.push_back(figure.run);
  for (const db::RunRecord& run : input.further) numbers.push_back(run.run);
  for (const StudyRun& study : study_runs_of(studies)) numbers.push_back(study.run);
  std::vector<db::ReportRecord::Evidence> evidence;
  for (const std::int64_t number : numbers)
    if (std::ranges::find(evidence, number, &db::ReportRecord::Evidence::run) == evidence.end())
      evidence.push_back({number, runs.record(number).content_sha256});
  return evidence;
}

// Attached to a PDF; if a laboratory file was named, a note says why it is not attached.
std::string dcc_wanted(const analysis::ReportInput& input, const analysis::Report& report,
                       const ReportOptions& options) {
  if (options.format != "dcc" && options.format != "pdf") return {};
  const std::string lacking = options.format == "pdf" ? analysis::dcc_lacks(input) : "";
  if (lacking.empty()) return analysis::render_dcc(input, report);
  if (!options.lab.empty())
    tty::print(stderr, "note: no digital calibration certificate is attached: it needs {}\n", lacking);
  return {};
}

WrittenReport one_run(db::RunStore& store, analysis::Runs& runs, const ReportOptions& options, const Session& session) {
  analysis::ReportInput input = input_for(runs, options, options.runs.front(), session);
  input.reason = options.reason;
  input.annexes = options.annexes;
  if (std::ranges::find(input.annexes, "all") != input.annexes.end())
    input.annexes.assign(analysis::kAnnexes.begin(), analysis::kAnnexes.end());
  WrittenReport out;
  out.report = analysis::render_report(input);
  out.dcc = dcc_wanted(input, out.report, options);
  const bool signing = !options.signed_by.empty();
  check_reason(input.approvals, out.report.number, options.reason, signing);
  // A signed report has a separate file, named by its number.
  const std::string numbered = "run-" + out.report.number;
  place(out, store, options, input.run,
        signing || analysis::is_signed(input, out.report.number) ? numbered : fmt::format("run-{}", input.run.run),
        numbered);
  if (signing) {
    pause_progress();  // it may ask
    check_signature(input.judgement, input.run.run, input.run.origin, options.without_verdict, session);
    const std::vector<db::ReportRecord> before = store.reports(input.run.run);
    store.add_report({input.run.run, out.report.number, out.report.content_sha256, options.signed_by, utc_now(),
                      before.empty() ? "" : before.back().number, options.reason,
                      evidence_of(runs, input, options.extras.studies)});
    input.approvals = store.reports(input.run.run);
    out.report = analysis::render_report(input);
    out.dcc = dcc_wanted(input, out.report, options);
  }
  out.started_utc = input.run.started_utc;
  if (input.more.previous)
    out.as_found = as_found_text(*input.more.previous, options.extras.previous.empty(), session.unit());
  out.judgements.push_back(std::move(input.judgement));
  return out;
}

// Loop, models and errors.
WrittenReport table_report(analysis::Runs& runs, const ReportOptions& options, const Session& session) {
  const db::RunRecord run = runs.record(options.runs.front());
  analysis::TableReportInput input;
  input.run = run;
  input.histories = read_run(runs, run.run, "report", {}, session);
  input.unit = session.page_unit();
  input.paper = options.paper == "letter" ? analysis::PaperSize::kLetter : analysis::PaperSize::kA4;
  for (const db::FitRecord& fit : runs.store().fits(run.run)) {
    input.models.push_back(analysis::load_fit(fit));
    input.scores.push_back(analysis::score_model(input.models.back(), input.histories, {}));
  }
  WrittenReport out;
  out.report = analysis::render_table_report(input);
  out.summary = summary_of(input, session.unit());
  out.started_utc = run.started_utc;
  out.judgements.emplace_back();
  place(out, runs.store(), options, run, fmt::format("run-{}", run.run), "run-" + out.report.number);
  return out;
}

std::string kind_written(const ReportOptions& options, bool table) {
  if (options.format != "json")
    return options.format == "pdf" ? kPdfFile : options.format == "dcc" ? kDccFile : kPageFile;
  return fmt::format("a tactbench.{} document (JSON)", options.compare ? "comparison"
                                                       : options.batch ? "batch"
                                                       : table         ? "table-report"
                                                                       : "report");
}

// The PDF contains the data, and the digital certificate if the laboratory file states what it requires.
std::vector<PdfAttachment> attachments_of(const WrittenReport& written) {
  std::vector<PdfAttachment> all = {
      {"report.json", "application/json", "all data of the report", written.report.json + "\n"}};
  if (!written.dcc.empty())
    all.push_back({"certificate.xml", "application/xml", "digital calibration certificate (DCC)", written.dcc});
  return all;
}

std::optional<analysis::Verdict> worst_of(const std::vector<analysis::Judgement>& judgements) {
  std::optional<analysis::Verdict> worst;  // none is better than any
  for (const analysis::Judgement& judgement : judgements) worst = std::max(worst, judgement.overall);
  return worst;
}

// Checks that all runs on the command line exist and may be used (evidence.h). The report's own run may be void.
void check_report_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session) {
  const std::int64_t run = options.runs.front();
  const bool alone = options.runs.size() == 1 && options.held_out.empty() && options.model.empty() &&
                     options.limits.empty() && options.signed_by.empty() && options.annexes.empty() &&
                     options.extras.previous.empty() && options.extras.studies.empty() && !options.batch;
  for (const std::int64_t own : options.runs)
    if (runs.record(own).origin == "imported" && !alone)
      throw Error(
          "TB-USAGE", fmt::format("run {} came from a table and cannot be combined with other runs", own), "report",
          fmt::format("its report has only loop, models and errors, and is not signed: tactbench report {}", own));
  if (runs.record(run).origin == "imported") {
    if (options.format == "dcc")
      throw Error("TB-REPORT-DCC",
                  "a digital calibration certificate needs U of a reading, which a table does not give",
                  fmt::format("report {} --format dcc", run), "choose another --format");
    return;
  }
  if (options.compare || options.batch) {
    (void)named_runs(runs, options.runs, {"report --compare and --batch"}, session.void_too);
    return;
  }
  const ModelReference named = parse_model_reference(options.model, run);
  const std::int64_t model_run = named.run;
  if (model_run != run) (void)named_runs(runs, {model_run}, {"--model"}, session.void_too);
  (void)named_runs(runs, {options.runs.begin() + 1, options.runs.end()}, {"runs after the report's own"},
                   session.void_too);
  std::vector<std::int64_t> independent = options.held_out;
  (void)named_runs(runs, independent, {"--held-out", model_run}, session.void_too);
  if (std::ranges::find(independent, run) != independent.end())
    throw Error("TB-RUN-TWICE", fmt::format("run {} is the run of the report", run), "--held-out",
                "name only further runs: this one is always included");
  if (!options.extras.previous.empty() && options.extras.previous != kNoPrevious)
    check_model_named(runs, options.extras.previous, "--previous", session);
  std::vector<std::int64_t> studied;
  for (const StudyRun& study : study_runs_of(options.extras.studies))
    if (study.run != run) studied.push_back(study.run);
  (void)named_runs(runs, studied, {"--studies", model_run != run ? model_run : 0}, session.void_too);
}

// For one run: its figures, then "models" and "uncertainty" (bench/reporting/evaluation.cpp).
// Shares of the time as on the demonstration's runs; they only divide the time left.
std::vector<WorkStage> report_stages(const ReportOptions& options) {
  std::vector<WorkStage> stages;
  if (options.compare || options.batch)
    for (const std::int64_t run : options.runs) stages.push_back({report_stage_of(run), 2.0, false});
  else
    stages = {{"figures", 2.0, false}, {"models", 4.0, false}, {"uncertainty", 4.0, false}};
  stages.push_back({kWritingReport, options.format == "pdf" ? 8.0 : 1.0, false});
  return stages;
}

}  // namespace

WrittenReport write_reports(ReportOptions options, Session& session) {
  check_report_options(options);
  if (!options.lab.empty()) options.extras.laboratory = read_laboratory(find_config(options.lab));
  db::RunStore store =
      options.signed_by.empty() ? db::RunStore::open_read_only(session.db) : db::RunStore::open(session.db);
  analysis::Runs runs(store);
  const bool table = runs.record(options.runs.front()).origin == "imported";
  const std::shared_ptr<const SigningKey> key = options.signer.named() ? read_signing_key(options.signer) : nullptr;
  if (std::error_code unknown; key && std::filesystem::exists(options.output, unknown) &&
                               !std::filesystem::is_regular_file(options.output, unknown))
    throw Error("TB-USAGE", "a signature is written next to a file, but the output is not a file", options.output,
                "name a file with -o");
  if (!options.output.empty()) check_output(options.output, kind_written(options, table), session.replace);
  check_report_runs(runs, options, session);
  const bool one = !options.compare && !options.batch;
  WorkProgress progress("report", session.quiet || session.json, report_stages(options));
  WrittenReport written = table ? table_report(runs, options, session)
                          : one ? one_run(store, runs, options, session)
                                : several_runs(runs, options, session);
  const std::string& path = written.path;
  progress.begin(kWritingReport);
  if (written.written && options.format == "pdf") {
    write_pdf({written.report.html, attachments_of(written), path, options.pdf_with, written.started_utc,
               written.run_uuid, session.replace});
  } else if (written.written) {
    write_output(path,
                 options.format == "json"  ? written.report.json + "\n"
                 : options.format == "dcc" ? written.dcc
                                           : written.report.html,
                 session.replace);
  }
  session.code = exit_code_of(worst_of(written.judgements));
  if (key && written.written) written.signature = sign_file(*key, path, written.report.number);
  if (written.written && one) record_signed_file(written.path, written.report.number, options.runs.front(), session);
  return written;
}

namespace {

void report_runs(ReportOptions options, Session& session) {
  choose_runs(options, db::RunStore::open_read_only(session.db), session.void_too);
  const WrittenReport written = write_reports(options, session);
  const std::string& path = written.path;
  const bool one = !options.compare && !options.batch;
  std::vector<analysis::JudgedFigure> verdicts;
  for (const analysis::Judgement& judgement : written.judgements)
    verdicts.insert(verdicts.end(), judgement.figures.begin(), judgement.figures.end());
  if (session.json) {
    nlohmann::ordered_json json = {
        {"run", options.runs.front()},         {"runs", options.runs},
        {"number", written.report.number},     {"path", path},
        JSON_FIELDS(written, written, origin), {"verdicts", verdicts_json(verdicts, written.origin)}};
    if (!written.signature.empty()) json["signature"] = written.signature;
    if (one) {
      json["judgement"] = judgement_json(written.judgements.front(), written.origin);
    } else {
      for (const analysis::Judgement& judgement : written.judgements)
        json["judgements"].push_back(judgement_json(judgement, written.origin));
    }
    print_json("report", json);
    return;
  }
  print_document(written.summary, session.unit());
  for (std::size_t i = 0; one && i < written.judgements.size(); ++i) {
    const analysis::Judgement& judgement = written.judgements[i];
    analysis::doc::Document out = judgement_document(judgement, written.origin, session.unit(), session.all);
    if (session.quiet && out.blocks.size() > 1) out.blocks.resize(1);
    print_document(out, session.unit());
  }
  if (!written.as_found.empty() && !session.quiet) tty::print("{}\n", written.as_found);
  tty::print("report {}: {}{}\n", written.report.number, path,
             written.written ? "" : " (signed: the file is unchanged)");
  if (!written.signature.empty()) tty::print("signature {}\n", one_line(written.signature));
}

void add_report_options(CLI::App& verb, ReportOptions& options, Session& session) {
  verb.add_option("runs", options.named,
                  "the run; further runs of the same sensor add creep and temperature to the uncertainty; with --batch "
                  "many, e.g. 1-99")
      ->take_all();
  verb.add_option("--held-out", options.held_out,
                  "runs of the same sensor to correct with the models and to judge separately: the worst verdict "
                  "counts (default: those on which the models were judged)")
      ->take_all();
  verb.add_option("--limits", options.limits,
                  "judge by this limits file, without storing (default: the limits by which the models were judged)");
  session.profile.add(verb, "--lab", ProfileKey::kLab, options.lab,
                      "laboratory file: facts that no instrument can supply (init writes one)");
  verb.add_option("--format", options.format,
                  "html; pdf with the data attached (needs chromium or weasyprint); json: only the data; dcc: a "
                  "digital calibration "
                  "certificate (XML)")
      ->check(CLI::IsMember({"html", "pdf", "json", "dcc"}))
      ->capture_default_str();
  verb.add_option("-o,--output", options.output,
                  "file to write (default: reports/run-N.html in the store's folder, by its number when signed)");
  std::vector<std::string> annexes(analysis::kAnnexes.begin(), analysis::kAnnexes.end());
  annexes.emplace_back("all");
  verb.add_option(
          "--annex", options.annexes,
          "annexes beyond the six pages: maps of every level, taxels, models, parameters, events, hashes, or all")
      ->delimiter(',')
      ->check(CLI::IsMember(std::move(annexes)));
  verb.add_option("--previous", options.extras.previous,
                  "earlier models with which the report judges the sensor as found: a .json file, RUN or RUN:FIT, or "
                  "none (default: those of the sensor's earlier runs in the store)")
      ->group(kRareOptions);
  verb.add_option("--studies", options.extras.studies,
                  "further runs of the sensor: under objects, at several rates, held (recognised by their recipes), "
                  "at another temperature (recognised by their thermometer), re-mounted (RUN:mount), turned in the "
                  "chamber (RUN:90, RUN:180, RUN:270); held levels and temperature enter the uncertainty")
      ->take_all()
      ->group(kRareOptions);
  verb.add_option(
          "--model", options.model,
          "use the models of this run, or RUN:FIT (default: the newest dynamic model or ELAM of the run itself)")
      ->group(kRareOptions);
  verb.add_option("--paper", options.paper, "a4 or letter")
      ->check(CLI::IsMember({"a4", "letter"}))
      ->capture_default_str()
      ->group(kRareOptions);
  verb.add_option("--pdf-with", options.pdf_with, "program that makes the PDF: chromium or weasyprint")
      ->check(CLI::IsMember({"chromium", "weasyprint"}))
      ->group(kRareOptions);
  add_replace(verb, session);
  add_void_too(verb, session);
  verb.footer("Pressures on the page are in kPa with psi, in the terminal in psi, or in the unit of --units.");
}

// The options of `report`, and those of signing one. `options` must outlive the parsing.
void add_sign_options(CLI::App& verb, ReportOptions& options) {
  const auto filled = [](const std::string& text) { return std::string(db::is_blank(text) ? "it is empty" : ""); };
  verb.add_option("--by", options.signed_by, "name of the signer; the signed report is not overwritten")->check(filled);
  verb.add_option("--key", options.signer.key,
                  "private key (PEM): writes FILE.p7s next to the file, a signature that openssl can check");
  verb.add_option("--certificate", options.signer.certificate, "its certificate (PEM), then those of its issuers");
  verb.add_option("--pkcs12", options.signer.pkcs12, "key and certificate in one file (PKCS#12), instead of both");
  verb.add_option("--password-file", options.signer.password, "file with the key's password in its first line");
  verb.add_option("--reason", options.reason,
                  "what changed since the signed report that this one replaces, and why; printed on page 1, and needed "
                  "to sign it")
      ->check(filled);
  verb.add_option("--issued-at", options.issued, "date of issue, as 2026-01-31 (default: today)");
  verb.add_flag("--without-verdict", options.without_verdict, "sign a report that has no verdict");
}

}  // namespace

void add_report(CLI::App& app, Session& session) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand("report",
                                      "a run's calibration report; list, sign or verify reports\n"
                                      "It is a test report if the run states no uncertainty. Also a comparison of two "
                                      "runs, or a page on many. One file.");
  add_report_options(*verb, *options, session);
  add_all(*verb, session);
  verb->add_flag("--compare", options->compare, "one page on two runs: as found and as left, or two sensors");
  verb->add_flag("--batch", options->batch, "one page on many runs: yield, ranks, distributions, outliers");
  add_metadata_options(*verb, options->metadata, true);
  verb->callback([options, verb, &session] {
    if (verb->get_subcommands().empty()) report_runs(*options, session);
  });
  CLI::App* sign = verb->add_subcommand("sign", "sign a run's report: it gets a file named by its number");
  auto signed_one = std::make_shared<ReportOptions>();
  add_report_options(*sign, *signed_one, session);
  add_sign_options(*sign, *signed_one);
  sign->footer(
      "With files of signed reports instead of a run: writes only their signatures, with --key and --certificate or "
      "--pkcs12.");
  sign->callback([signed_one, &session] {
    const auto is_file = [](const std::string& word) { return std::filesystem::is_regular_file(word); };
    if (signed_one->signed_by.empty() && !signed_one->named.empty() && std::ranges::all_of(signed_one->named, is_file))
      return sign_files(signed_one->named, signed_one->signer, session);
    if (signed_one->signed_by.empty()) throw Error("TB-USAGE", "no signer is named", "report sign", "--by NAME");
    report_runs(*signed_one, session);
  });
  add_subverbs(*verb, session);
}

ModelReference parse_model_reference(const std::string& text, std::int64_t run) {
  if (text.empty()) return {run, 0};
  ModelReference named;
  const char* const end = text.data() + text.size();
  auto read = std::from_chars(text.data(), end, named.run);
  bool good = read.ec == std::errc() && named.run > 0;
  if (good && read.ptr != end) {
    good = *read.ptr == ':';
    if (good) read = std::from_chars(read.ptr + 1, end, named.fit);
    good = good && read.ec == std::errc() && read.ptr == end && named.fit > 0;
  }
  if (good) return named;
  throw Error("TB-USAGE", fmt::format("'{}' names no stored models", text), "--model",
              "RUN, or RUN:FIT (tactbench runs show RUN lists its fits)");
}

void choose_runs(ReportOptions& options, const db::RunStore& store, bool void_too) {
  const MetadataOptions& metadata = options.metadata;
  const bool by_metadata = !metadata.lot.empty() || !metadata.order.empty() || !metadata.pairs.empty();
  std::vector<RunRange> ranges;
  for (const std::string& word : options.named) {
    const std::vector<RunRange> own = run_ranges(word);
    if (own.empty())
      throw Error("TB-USAGE", fmt::format("'{}' is not a run", word), "report", "a number; with --batch also 1-99");
    ranges.insert(ranges.end(), own.begin(), own.end());
  }
  const bool single = std::ranges::all_of(ranges, [](const RunRange& range) { return range.first == range.last; });
  if (single && !by_metadata && !ranges.empty()) {
    for (const RunRange& range : ranges) options.runs.push_back(range.first);
    return;
  }
  if (!options.batch)
    throw Error("TB-USAGE",
                ranges.empty() && !by_metadata ? "no run is named" : "a report is about one run, but several are named",
                "report", "one run: tactbench report 3; a page on many: --batch with --lot, --order or 1-99");
  for (const db::RunRecord& run : store.runs()) {
    const auto holds = [&](const RunRange& range) { return range.holds(run.run); };
    if ((!ranges.empty() && std::ranges::none_of(ranges, holds)) || !fits_metadata(metadata, run)) continue;
    if ((run.is_void() && !void_too) || run.origin == "imported") continue;
    if (const std::optional<db::FitRecord> fit = store.default_fit(run.run); fit && fit->fitted > 0)
      options.runs.push_back(run.run);
  }
  if (options.runs.empty())
    throw Error("TB-USAGE", "none of the requested runs has models", "report --batch",
                "tactbench runs list --lot LOT shows them; tactbench fit RUN makes models");
}

void check_report_options(const ReportOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error("TB-USAGE", what, "report", remedy);
  };
  if (options.runs.empty()) refuse("no run is named", "e.g. tactbench report 3; tactbench runs list shows all");
  if (options.compare && options.batch) refuse("--compare and --batch cannot be combined", "give one of them");
  if (options.compare && options.runs.size() != 2)
    refuse(fmt::format("--compare needs two runs, not {}", options.runs.size()), "tactbench report --compare 1 2");
  const bool several = options.compare || options.batch;
  if (several && (!options.held_out.empty() || !options.extras.previous.empty() || !options.extras.studies.empty() ||
                  !options.annexes.empty()))
    refuse("--held-out, --previous, --studies and --annex belong to the report of one run",
           "report each run by itself, then compare");
  if (several && options.format == "dcc")
    refuse("a digital calibration certificate is about one run",
           "write another --format, or report each run by itself");
  if (!options.issued.empty() && !analysis::is_date(options.issued))
    refuse(fmt::format("'{}' is not a date", options.issued), "write it as 2026-01-31");
}

void check_independent_of_dynamics(const db::RunReader& store, const analysis::SensorModel& fit,
                                   const std::vector<std::int64_t>& held_out) {
  if (!fit.dynamics) return;
  for (const std::int64_t run : source_runs(store, fit))
    if (std::ranges::find(held_out, run) != held_out.end())
      throw Error("TB-RUN-OWN",
                  fmt::format("the models, or their lag or creep, were made from run {}: it is not independent data "
                              "for them",
                              run),
                  "--held-out");
}

void check_models_of_array(analysis::Runs& runs, const analysis::SensorModel& fit, const ModelReference& named) {
  const auto refuse = [&](const char* why) {
    throw Error("TB-USAGE",
                fmt::format("a report cannot use {} {}{}: {}", named.fit == 0 ? "the models of run" : "fit", named.run,
                            named.fit == 0 ? "" : fmt::format(":{}", named.fit), why),
                "--model",
                "name a fit of the whole array of a run that the bench made (tactbench runs show lists them), or "
                "make one: tactbench fit RUN");
  };
  if (runs.record(named.run).origin == "imported") refuse("it came from an imported table");
  if (fit.fitted().empty()) refuse("it has no model of a single taxel of the array");
}

}  // namespace tactbench::bench
