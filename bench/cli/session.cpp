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
#include "db/record.h"
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

std::string figure_text(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "not measured";  // e.g. the run has no such level
  return unit == "FS" ? fmt::format("{:.3g} % FS", 100.0 * value) : fmt::format("{:.3g} {}", value, unit);
}

std::string verdict_table(const std::vector<db::VerdictRecord>& verdicts, const std::string& origin) {
  std::string text =
      fmt::format("{:>5}  {:<26}{:<14}{:>14} {:>13}  {}\n", "run", "criterion", "scope", "value", "limit", "verdict");
  for (const db::VerdictRecord& row : verdicts) {
    text += fmt::format("{:>5}  {}{}{:>14} {:>13}  {}\n", row.run, cell(row.criterion, 26), cell(row.scope, 14),
                        figure_text(row.value, row.unit), figure_text(row.limit, row.unit),
                        one_line(shown_verdict(row.verdict, origin)));
  }
  std::vector<std::string> rules;
  for (const db::VerdictRecord& row : verdicts)
    if (std::ranges::find(rules, row.rule) == rules.end()) rules.push_back(row.rule);
  return text + fmt::format("decision rule (ILAC-G8): {}\n", fmt::join(rules, ", "));
}

ordered_json verdicts_json(const std::vector<db::VerdictRecord>& verdicts, const std::string& origin) {
  ordered_json list = ordered_json::array();
  for (const db::VerdictRecord& row : verdicts) {
    ordered_json json = {{"run", row.run}, {"model_run", row.model_run}};
    json.update(analysis::verdict_json(row));
    json["shown"] = shown_verdict(row.verdict, origin);
    list.push_back(std::move(json));
  }
  return list;
}

std::string figures_table(const std::vector<NamedEvaluation>& evaluations) {
  std::string text = fmt::format("{:<28}{:>8} |{:<54}|{:>11}\n{:<28}{:>8} |{:>10}{:>16}{:>14}{:>14}|{:>11}\n",
                                 "|up - down|, % FS", "raw", " compensated", "mean", "mean over the levels", "array",
                                 "array", "each taxel (*)", "worst taxel", "worst taxel*", "error, psi");
  for (const NamedEvaluation& named : evaluations) {
    const analysis::Evaluation& e = named.evaluation;
    text += fmt::format("{:<28}{:>8.2f} |{:>10.2f}{:>16}{:>14.2f}{:>14.2f}|{:>11.3f}\n", named.title,
                        100.0 * e.raw_distance, 100.0 * e.comp_distance_of_mean,
                        fmt::format("{:.2f} ({:.2f})", 100.0 * e.comp_distance, 100.0 * e.comp_distance_observable),
                        100.0 * e.worst_taxel_distance, 100.0 * e.worst_taxel_distance_observable, e.mean_error_psi);
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
  throw Error(ExitCode::kUsage, "TB-USAGE", "--operator is empty", "--operator", "give a name: it is recorded");
}

void add_manner(CLI::App& verb, Session& session) {
  verb.add_flag("--json", session.json, "one JSON document on standard output, also for errors");
  verb.add_flag("-q,--quiet", session.quiet, "no progress line");
}

void add_common(CLI::App& verb, Session& session) {
  session.profile.add(verb, "--db", ProfileKey::kDb, session.db, "run store, one SQLite file per bench")
      ->capture_default_str();
  add_manner(verb, session);
}

void add_common_typed(CLI::App& verb, Session& session) {
  verb.add_option("--db", session.db, "run store, one SQLite file per bench")->capture_default_str();
  add_manner(verb, session);
}

void add_replace(CLI::App& verb, Session& session) {
  verb.add_flag("--replace", session.replace,
                "also overwrite a file of another kind; one of the same kind is replaced anyway, a store never");
}

void add_void_too(CLI::App& verb, Session& session) {
  verb.add_flag("--void-too", session.void_too, "also use void runs; the results are marked");
}

}  // namespace tactbench::bench
