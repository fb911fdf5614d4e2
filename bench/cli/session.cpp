#include "bench/cli/session.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/documents/run_json.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/report/document/document.h"
#include "bench/common/terminal.h"
#include "bench/reporting/named_evaluation.h"
#include "db/remarks.h"

namespace tactbench::bench {

using analysis::Verdict;
using nlohmann::ordered_json;

void print_json(const std::string& verb, const ordered_json& body) {
  ordered_json document;
  document["schema"] = "tactbench." + verb;
  document["version"] = 1;
  document.update(body);
  tty::print("{}\n", analysis::printable_json(document, 2));
}

void print_document(const analysis::doc::Document& document, analysis::PressureUnit unit) {
  tty::print("{}", to_text(document, unit, line_columns()));
}
void print_table(analysis::doc::Table table, analysis::PressureUnit unit) {
  analysis::doc::Document document;
  document.add(std::move(table));
  print_document(document, unit);
}

ExitCode exit_code_of(std::optional<Verdict> verdict) {
  if (!verdict) return ExitCode::kPass;
  switch (*verdict) {
    case Verdict::kReportOnly:
    case Verdict::kPass:
    case Verdict::kConditionalPass:
      return ExitCode::kPass;
    case Verdict::kConditionalFail:
    case Verdict::kInconclusive:
      return ExitCode::kInconclusive;
    case Verdict::kFail:
      break;
  }
  return ExitCode::kCriterionFailed;
}

std::string shown_verdict(const std::string& word, const std::string& origin) {
  return origin == "simulated" ? "simulated " + word : word;
}
std::string shown_verdict(Verdict verdict, const std::string& origin) {
  return shown_verdict(std::string(to_string(verdict)), origin);
}

analysis::PressureUnit Session::unit() const {
  return analysis::PressureUnit::from(units).value_or(analysis::PressureUnit::kPsi);
}

analysis::PressureUnit Session::page_unit() const {
  return analysis::PressureUnit::from(units).value_or(analysis::PressureUnit::kKilopascal);
}

ordered_json verdicts_json(const std::vector<analysis::JudgedFigure>& figures, const std::string& origin) {
  ordered_json list = ordered_json::array();
  for (const analysis::JudgedFigure& row : figures) {
    ordered_json json = {JSON_FIELDS(row, run, model_run)};
    json.update(analysis::figure_json(row));
    json["shown"] = shown_verdict(row.verdict, origin);
    list.push_back(std::move(json));
  }
  return list;
}

ordered_json evaluation_json(const NamedEvaluation& named) {
  ordered_json json = {{"title", named.title}, JSON_FIELDS(named.evaluation, run, model_run)};
  json.update(analysis::evaluation_json(named.evaluation));
  return json;
}

void check_operator(const std::string& name) {
  if (!db::is_blank(name)) return;
  throw Error("TB-USAGE", "--operator is empty", "--operator", "give a name, which is recorded");
}

std::string Session::bench_file(const char* otherwise) const {
  if (!bench.empty()) {
    const auto given = profile.values().find(ProfileKey::kBench);
    const bool found = given != profile.values().end() && given->second.origin == kBenchHereOrigin;
    if (found && !typed("--bench") && !quiet && !json) tty::print(stderr, "bench: {} in this folder\n", bench);
    return bench;
  }
  if (otherwise != nullptr) return otherwise;
  throw Error("TB-USAGE", "no bench file is named, and this folder has no bench.toml", "--bench",
              "name it: --bench FILE; or write one: tactbench init");
}

void Session::use_db_only_if_typed() {
  if (!typed("--db")) db = kDefaultStore;
}

void add_global_options(CLI::App& app, Session& session) {
  app.fallthrough();
  session.profile.add(app, "--db", ProfileKey::kDb, session.db, "run store, one SQLite file per bench")
      ->capture_default_str();
  session.profile.add(app, "--bench", ProfileKey::kBench, session.bench,
                      "bench file; for a live run also the id of its bench [bench.toml, if it is here]");
  session.profile
      .add(app, "--units", ProfileKey::kUnits, session.units,
           "unit of the printed gauge pressures; files, CSV and JSON keep psi. A typed pressure may be followed by a "
           "unit (20kPa)")
      ->check(CLI::IsMember({"kPa", "bar", "psi"}, CLI::ignore_case))
      ->default_str("psi");
  app.add_flag("--json", session.json, "one JSON document on standard output, also for errors");
  app.add_flag("-q,--quiet", session.quiet, "print only the result");
  session.typed = [&app](const char* option) { return app.count(option) > 0; };
}

void add_all(CLI::App& verb, Session& session) {
  verb.add_flag("--all", session.all, "print every check and detail, not only those that decide");
}

void add_replace(CLI::App& verb, Session& session) {
  verb.add_flag("--replace", session.replace,
                "also overwrite a file of another kind; a file of the same kind is always replaced, a store never");
}

void add_void_too(CLI::App& verb, Session& session) {
  verb.add_flag("--void-too", session.void_too, "also use void runs; the results are marked");
}

}  // namespace tactbench::bench
