#include "bench/cli/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/documents/evaluation_json.h"
#include "analysis/json_io.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "bench/reporting/named_evaluation.h"
#include "db/utf8.h"

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

std::size_t verdict_columns() {
  std::size_t longest = 0;
  for (const Verdict verdict : analysis::kVerdicts)
    longest = std::max(longest, shown_verdict(verdict, "simulated").size());
  return longest + 2;
}

analysis::PressureUnit Session::unit() const {
  return analysis::PressureUnit::from(units).value_or(analysis::PressureUnit::kPsi);
}

analysis::PressureUnit Session::page_unit() const {
  return analysis::PressureUnit::from(units).value_or(analysis::PressureUnit::kKilopascal);
}

std::string verdict_table(const std::vector<analysis::JudgedFigure>& figures, const std::string& origin,
                          analysis::PressureUnit shown) {
  std::vector<std::string> scopes, rules;
  std::size_t widest = 12;
  for (const analysis::JudgedFigure& row : figures) {
    scopes.push_back(in_words(row.scope, shown));
    widest = std::max(widest, scopes.back().size());
    const std::string rule = to_string(row.rule);
    if (std::ranges::find(rules, rule) == rules.end()) rules.push_back(rule);
  }
  std::string text = fmt::format("{:>5}  {:<27}{}{:>14} {:>16}  {}\n", "run", "requirement", cell("scope", widest + 2),
                                 "value", "tolerance limit", "verdict");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const analysis::JudgedFigure& row = figures[i];
    text += fmt::format("{:>5}  {}{}{:>14} {:>16}  {}\n", row.run, cell(in_words(row.criterion), 27),
                        cell(scopes[i], widest + 2), figure_text(row.criterion, row.value, shown),
                        figure_text(row.criterion, row.limit, shown), shown_verdict(row.verdict, origin));
  }
  return text + fmt::format("decision rule (ILAC-G8): {}\n", fmt::join(rules, ", "));
}

ordered_json verdicts_json(const std::vector<analysis::JudgedFigure>& figures, const std::string& origin) {
  ordered_json list = ordered_json::array();
  for (const analysis::JudgedFigure& row : figures) {
    ordered_json json = {{"run", row.run}, {"model_run", row.model_run}};
    json.update(analysis::figure_json(row));
    json["shown"] = shown_verdict(row.verdict, origin);
    list.push_back(std::move(json));
  }
  return list;
}

std::string figures_table(const std::vector<NamedEvaluation>& evaluations, analysis::PressureUnit shown) {
  std::string text =
      fmt::format("{:<28}{:>11} |{:<54}|{:>13}\n{:<28}{:>11} |{:>10}{:>16}{:>14}{:>14}|{:>13}\n", "hysteresis, % FS",
                  "indication", " corrected indication", "mean", "mean over the levels", "array", "array",
                  "each taxel (*)", "worst taxel", "worst taxel*", fmt::format("|error|, {}", shown.symbol()));
  for (const NamedEvaluation& named : evaluations) {
    const analysis::Evaluation& e = named.evaluation;
    text += fmt::format("{:<28}{:>11.2f} |{:>10.2f}{:>16}{:>14.2f}{:>14.2f}|{:>13}\n", named.title,
                        100.0 * e.raw_distance, 100.0 * e.comp_distance_of_mean,
                        fmt::format("{:.2f} ({:.2f})", 100.0 * e.comp_distance, 100.0 * e.comp_distance_observable),
                        100.0 * e.worst_taxel_distance, 100.0 * e.worst_taxel_distance_observable,
                        shown.fixed(e.mean_error_psi, 3));
  }
  return text +
         "array: the outputs (pressures) of all taxels are averaged first; *: without levels flagged unobservable\n";
}

ordered_json evaluation_json(const NamedEvaluation& named) {
  ordered_json json = {
      {"title", named.title}, {"run", named.evaluation.run}, {"model_run", named.evaluation.model_run}};
  json.update(analysis::evaluation_json(named.evaluation));
  return json;
}

void check_operator(const std::string& name) {
  if (!db::is_blank(name)) return;
  throw Error("TB-USAGE", "--operator is empty", "--operator", "give a name: it is recorded");
}

std::string Session::bench_file(const char* otherwise) const {
  if (!bench.empty()) {
    const auto given = profile.values().find(ProfileKey::kBench);
    const bool found = given != profile.values().end() && given->second.origin == kBenchHereOrigin;
    if (found && !typed("--bench") && !quiet && !json) tty::print(stderr, "bench: {} of this folder\n", bench);
    return bench;
  }
  if (otherwise != nullptr) return otherwise;
  throw Error("TB-USAGE", "no bench file is named, and this folder has no bench.toml", "--bench",
              "name it: --bench FILE; or write one: tactbench init");
}

void Session::take_db_only_as_typed() {
  if (!typed("--db")) db = kUsualStore;
}

void add_global_options(CLI::App& app, Session& session) {
  app.fallthrough();
  session.profile.add(app, "--db", ProfileKey::kDb, session.db, "run store, one SQLite file per bench")
      ->capture_default_str();
  session.profile.add(app, "--bench", ProfileKey::kBench, session.bench,
                      "bench file; of a live run also the id of its bench [bench.toml, if it is here]");
  session.profile
      .add(
          app, "--units", ProfileKey::kUnits, session.units,
          "unit of the pressures printed, all gauge; files, CSV and JSON keep psi. A pressure that is typed may have a "
          "unit behind it (20kPa)")
      ->check(CLI::IsMember({"kPa", "bar", "psi"}, CLI::ignore_case))
      ->default_str("psi");
  app.add_flag("--json", session.json, "one JSON document on standard output, also for errors");
  app.add_flag("-q,--quiet", session.quiet, "the result alone");
  session.typed = [&app](const char* option) { return app.count(option) > 0; };
}

void add_replace(CLI::App& verb, Session& session) {
  verb.add_flag("--replace", session.replace,
                "also overwrite a file of another kind; one of the same kind is replaced anyway, a store never");
}

void add_void_too(CLI::App& verb, Session& session) {
  verb.add_flag("--void-too", session.void_too, "also use void runs; the results are marked");
}

}  // namespace tactbench::bench
