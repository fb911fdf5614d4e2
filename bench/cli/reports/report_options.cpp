#include "bench/cli/reports/report_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <optional>

#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "bench/cli/runs/source.h"
#include "bench/reporting/named_runs.h"
#include "bench/reporting/source_runs.h"
#include "db/utf8.h"

namespace tactbench::bench {

ModelNamed model_named(const std::string& text, std::int64_t run) {
  if (text.empty()) return {run, 0};
  ModelNamed named;
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
      throw Error("TB-USAGE", fmt::format("'{}' is no run", word), "report", "a number; with --batch also 1-99");
    ranges.insert(ranges.end(), own.begin(), own.end());
  }
  const bool single = std::ranges::all_of(ranges, [](const RunRange& range) { return range.first == range.last; });
  if (single && !by_metadata && !ranges.empty()) {
    for (const RunRange& range : ranges) options.runs.push_back(range.first);
    return;
  }
  if (!options.batch)
    throw Error("TB-USAGE",
                ranges.empty() && !by_metadata ? "no run is named" : "one run has one report, and many are named",
                "report", "one run: tactbench report 3; a page on many: --batch with --lot, --order or 1-99");
  for (const db::RunRecord& run : store.runs()) {
    const auto holds = [&](const RunRange& range) { return range.holds(run.run); };
    if ((!ranges.empty() && std::ranges::none_of(ranges, holds)) || !fits_metadata(metadata, run)) continue;
    if ((run.is_void() && !void_too) || run.origin == "imported") continue;
    if (const std::optional<db::FitRecord> fit = store.standing_fit(run.run); fit && fit->fitted > 0)
      options.runs.push_back(run.run);
  }
  if (options.runs.empty())
    throw Error("TB-USAGE", "none of the runs asked for has models", "report --batch",
                "tactbench runs list --lot LOT shows them; tactbench fit RUN makes models");
}

void check_report_options(const ReportOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error("TB-USAGE", what, "report", remedy);
  };
  if (options.runs.empty()) refuse("no run is named", "e.g. tactbench report 3; tactbench runs list shows all");
  if (options.compare && options.batch) refuse("--compare and --batch cannot be combined", "give one of them");
  if (options.compare && options.runs.size() != 2)
    refuse(fmt::format("--compare takes two runs, not {}", options.runs.size()), "tactbench report --compare 1 2");
  const bool several = options.compare || options.batch;
  if (several && (!options.held_out.empty() || !options.extras.previous.empty() || !options.extras.studies.empty() ||
                  !options.annexes.empty()))
    refuse("--held-out, --previous, --studies and --annex belong to the report of one run",
           "report each run by itself, then compare");
  if (several && options.format == "dcc")
    refuse("a digital calibration certificate is of one run", "write another --format, or report each run by itself");
  if (!options.issued.empty() && !analysis::is_date(options.issued))
    refuse(fmt::format("'{}' is not a date", options.issued), "write it as 2026-01-31");
}

void check_independent_of_dynamics(const db::RunStore& store, const analysis::SensorModel& fit,
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

void check_models_of_array(analysis::Runs& runs, const analysis::SensorModel& fit, const ModelNamed& named) {
  const auto refuse = [&](const char* why) {
    throw Error("TB-USAGE",
                fmt::format("a report cannot use {} {}{}: {}", named.fit == 0 ? "the models of run" : "fit", named.run,
                            named.fit == 0 ? "" : fmt::format(":{}", named.fit), why),
                "--model",
                "name a fit of the whole array of a run that the bench made (tactbench runs show lists them), or "
                "make one: tactbench fit RUN");
  };
  if (runs.record(named.run).origin == "imported") refuse("it came from an imported table");
  if (fit.fitted().empty()) refuse("it has a model of no single taxel of the array");
}

void check_report_runs(analysis::Runs& runs, const ReportOptions& options, const Session& session) {
  const std::int64_t run = options.runs.front();
  const bool alone = options.runs.size() == 1 && options.held_out.empty() && options.model.empty() &&
                     options.limits.empty() && options.signed_by.empty() && options.annexes.empty() &&
                     options.extras.previous.empty() && options.extras.studies.empty() && !options.batch;
  for (const std::int64_t own : options.runs)
    if (runs.record(own).origin == "imported" && !alone)
      throw Error(
          "TB-USAGE", fmt::format("run {} came from a table, which no other run goes with", own), "report",
          fmt::format("its report has loop, models and errors alone, and is not signed: tactbench report {}", own));
  if (runs.record(run).origin == "imported") {
    if (options.format == "dcc")
      throw Error("TB-REPORT-DCC",
                  "a digital calibration certificate needs U of a reading, which a table does not give",
                  fmt::format("report {} --format dcc", run), "take another --format");
    return;
  }
  if (options.compare || options.batch) {
    (void)named_runs(runs, options.runs, {"report --compare and --batch"}, session.void_too);
    return;
  }
  const ModelNamed named = model_named(options.model, run);
  const std::int64_t model_run = named.run;
  if (model_run != run) (void)named_runs(runs, {model_run}, {"--model"}, session.void_too);
  (void)named_runs(runs, {options.runs.begin() + 1, options.runs.end()}, {"runs after the report's own"},
                   session.void_too);
  std::vector<std::int64_t> independent = options.held_out;
  (void)named_runs(runs, independent, {"--held-out", model_run}, session.void_too);
  if (std::ranges::find(independent, run) != independent.end())
    throw Error("TB-RUN-TWICE", fmt::format("run {} is the report's own", run), "--held-out",
                "name only further runs: this one is included in any case");
  if (!options.extras.previous.empty() && options.extras.previous != kNoPrevious)
    check_model_named(runs, options.extras.previous, "--previous", session);
  std::vector<std::int64_t> studied;
  for (const StudyRun& study : study_runs_of(options.extras.studies))
    if (study.run != run) studied.push_back(study.run);
  (void)named_runs(runs, studied, {"--studies", model_run != run ? model_run : 0}, session.void_too);
}

void add_report_options(CLI::App& verb, ReportOptions& options, Session& session) {
  verb.add_option("runs", options.named,
                  "the run; further runs of the same sensor add creep and temperature to the uncertainty; with --batch "
                  "many, e.g. 1-99")
      ->take_all();
  verb.add_option("--held-out", options.held_out,
                  "runs of the same sensor to correct with the models and to judge, each by itself: the worst "
                  "verdict counts (default: those that the models were judged on)")
      ->take_all();
  verb.add_option("--limits", options.limits,
                  "judge by this limits file, without storing (default: the limits that the models were judged by)");
  session.profile.add(verb, "--lab", ProfileKey::kLab, options.lab,
                      "laboratory file: facts that no instrument knows (init writes one)");
  verb.add_option("--format", options.format,
                  "html; pdf with the data attached (needs chromium or weasyprint); json: the data alone; dcc: a "
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
          "what the six pages leave out: maps of every level, taxels, models, parameters, events, hashes, or all")
      ->delimiter(',')
      ->check(CLI::IsMember(std::move(annexes)));
  verb.add_option(
          "--previous", options.extras.previous,
          "earlier models by which the report says how the sensor was found: a .json file, RUN or RUN:FIT, or none "
          "(default: those that the store has of the sensor's runs before)")
      ->group(kRareOptions);
  verb.add_option("--studies", options.extras.studies,
                  "further runs of the sensor: under objects, at several rates, held (recognised by their recipes), "
                  "at another temperature (recognised by their thermometer), re-mounted (RUN:mount), turned in the "
                  "chamber (RUN:90, RUN:180, RUN:270); held levels and temperature enter the uncertainty")
      ->take_all()
      ->group(kRareOptions);
  verb.add_option("--model", options.model,
                  "use the models of this run, or RUN:FIT (default: the run's own: its newest dynamic model or ELAM)")
      ->group(kRareOptions);
  verb.add_option("--paper", options.paper, "a4 or letter")
      ->check(CLI::IsMember({"a4", "letter"}))
      ->capture_default_str()
      ->group(kRareOptions);
  verb.add_option("--pdf-with", options.pdf_with, "the program that prints it: chromium or weasyprint")
      ->check(CLI::IsMember({"chromium", "weasyprint"}))
      ->group(kRareOptions);
  add_replace(verb, session);
  add_void_too(verb, session);
  verb.footer("Pressures on the page are in kPa with psi, in the terminal in psi, or as --units says.");
}

void add_sign_options(CLI::App& verb, ReportOptions& options) {
  const auto filled = [](const std::string& text) { return std::string(db::is_blank(text) ? "it is empty" : ""); };
  verb.add_option("--by", options.signed_by, "who signs; the signed report is not overwritten")->check(filled);
  verb.add_option("--key", options.signer.key,
                  "private key (PEM): writes FILE.p7s beside the file, a signature that openssl checks");
  verb.add_option("--certificate", options.signer.certificate, "its certificate (PEM), then those of its issuers");
  verb.add_option("--pkcs12", options.signer.pkcs12, "key and certificate in one file, in place of both");
  verb.add_option("--password-file", options.signer.password, "file whose first line opens the key");
  verb.add_option("--reason", options.reason,
                  "what changed since the signed report that this one replaces, and why; printed on page 1, and needed "
                  "to sign it")
      ->check(filled);
  verb.add_option("--issued-at", options.issued, "date of issue, as 2026-01-31 (default: today)");
  verb.add_flag("--without-verdict", options.without_verdict, "sign a report that has no verdict");
}

}  // namespace tactbench::bench
