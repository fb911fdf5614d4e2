#include "bench/cli/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "analysis/statistics/evaluation.h"
#include "bench/cli/named_evaluation.h"
#include "db/record.h"

namespace tactbench::bench {

using nlohmann::ordered_json;

void print_json(const std::string& verb, const ordered_json& body) {
  ordered_json document;
  document["schema"] = "tactbench." + verb;
  document["version"] = 1;
  document.update(body);
  fmt::print("{}\n", analysis::printable_json(document, 2));
}

SplitOverrides split_overrides(const std::vector<std::string>& set) {
  SplitOverrides split;
  const std::string prefix = "recipe.";
  for (const std::string& text : set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error(ExitCode::kUsage, "TB-USAGE", fmt::format("'{}' is not key=value", text), "--set " + text,
                  "write --set table.key=value, for a recipe --set recipe.key=value");
    }
    const sequences::Override item{text.substr(0, equals), text.substr(equals + 1)};
    split.all.push_back(item);
    if (item.key.starts_with(prefix)) {
      split.recipe.push_back({item.key.substr(prefix.size()), item.value});
    } else {
      split.bench.push_back(item);
    }
  }
  return split;
}

ExitCode exit_code_of(const std::vector<db::VerdictRecord>& verdicts) {
  ExitCode code = ExitCode::kPass;
  for (const db::VerdictRecord& verdict : verdicts) {
    if (verdict.verdict == "fail") return ExitCode::kCriterionFailed;
    if (verdict.verdict == "inconclusive" || verdict.verdict == "conditional fail") code = ExitCode::kInconclusive;
  }
  return code;
}

std::string shown_verdict(const std::string& verdict, const std::string& origin) {
  return origin == "simulated" ? "simulated " + verdict : verdict;
}

namespace {

std::string with_unit(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "not measured";  // e.g. the run has no such level
  return unit == "FS" ? fmt::format("{:.3g} % FS", 100.0 * value) : fmt::format("{:.3g} {}", value, unit);
}

}  // namespace

std::string verdict_table(const std::vector<db::VerdictRecord>& verdicts, const std::string& origin) {
  std::string text = fmt::format("{:<26}{:<14}{:>14}{:>14}  {}\n", "criterion", "scope", "value", "limit", "verdict");
  for (const db::VerdictRecord& row : verdicts) {
    text += fmt::format("{:<26}{:<14}{:>14}{:>14}  {}\n", row.criterion, row.scope, with_unit(row.value, row.unit),
                        with_unit(row.limit, row.unit), shown_verdict(row.verdict, origin));
  }
  std::vector<std::string> rules;
  for (const db::VerdictRecord& row : verdicts)
    if (std::ranges::find(rules, row.rule) == rules.end()) rules.push_back(row.rule);
  return text + fmt::format("decision rule (ILAC-G8): {}\n", fmt::join(rules, ", "));
}

ordered_json verdicts_json(const std::vector<db::VerdictRecord>& verdicts, const std::string& origin) {
  ordered_json list = ordered_json::array();
  for (const db::VerdictRecord& row : verdicts) {
    list.push_back({{"criterion", row.criterion},
                    {"scope", row.scope},
                    {"value", row.value},
                    {"limit", row.limit},
                    {"unit", row.unit},
                    {"rule", row.rule},
                    {"verdict", row.verdict},
                    {"shown", shown_verdict(row.verdict, origin)}});
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
         "array: the outputs (pressures) of all taxels averaged first; *: without the levels flagged unobservable\n";
}

ordered_json evaluation_json(const NamedEvaluation& named) {
  const analysis::Evaluation& e = named.evaluation;
  ordered_json json = {{"title", named.title},
                       {"run", e.run},
                       {"model_run", e.model_run},
                       {"frames", e.frames},
                       {"full_scale_v", e.full_scale_v},
                       {"full_scale_psi", e.full_scale_psi},
                       {"hysteresis_max_fs", e.hysteresis_max_fs},
                       {"hysteresis_mean_fs", e.hysteresis_mean_fs},
                       {"mean_error_psi", e.mean_error_psi},
                       {"max_error_psi", e.max_error_psi},
                       {"mean_error_observable_psi", e.mean_error_observable_psi},
                       {"max_error_observable_psi", e.max_error_observable_psi},
                       {"worst_taxel_mean_error_psi", e.worst_taxel_mean_error_psi},
                       {"worst_taxel", e.worst_taxel},
                       {"raw_distance_fs", e.raw_distance},
                       {"comp_distance_of_mean_fs", e.comp_distance_of_mean},
                       {"comp_distance_fs", e.comp_distance},
                       {"comp_distance_observable_fs", e.comp_distance_observable},
                       {"worst_taxel_distance_fs", e.worst_taxel_distance},
                       {"worst_taxel_distance_observable_fs", e.worst_taxel_distance_observable},
                       {"flat_share", e.flat_share}};
  ordered_json worse = ordered_json::array();
  for (const analysis::LevelFigures& level : e.levels) {
    if (level.made_worse) worse.push_back(level.pressure_psi);
  }
  json["levels_made_worse_psi"] = worse;
  return json;
}

ordered_json run_json(const db::RunRecord& run) {
  ordered_json json = {{"run", run.run},
                       {"uuid", run.uuid},
                       {"origin", run.origin},
                       {"state", run.state},
                       {"outcome", db::to_string(run.outcome)},
                       {"reason", run.reason},
                       {"safe_state", db::to_string(run.safe_state)},
                       {"operator", run.operator_name},
                       {"purpose", run.purpose},
                       {"sensor", run.sensor_serial},
                       {"scanner", run.scanner_serial},
                       {"bench", run.bench_id},
                       {"seed", run.seed},
                       {"sensor_seed", run.sensor_seed},
                       {"started_utc", run.started_utc},
                       {"ended_utc", run.ended_utc},
                       {"program_version", run.program_version},
                       {"git_commit", run.git_commit},
                       {"content_sha256", run.content_sha256},
                       {"tags", run.tags},
                       {"notes", run.notes},
                       {"void", run.is_void()}};
  if (run.is_void()) {
    json["void_reason"] = run.void_reason;
    json["void_by"] = run.void_by;
    json["void_utc"] = run.void_utc;
  }
  ordered_json recipes = ordered_json::array();
  for (const db::SequenceRecord& sequence : run.sequences) {
    recipes.push_back({{"name", sequence.name},
                       {"sha256", sequence.recipe_sha256},
                       {"repeats", sequence.repeats},
                       {"frames_per_repeat", sequence.frames_per_repeat}});
  }
  if (!recipes.empty()) json["recipes"] = recipes;
  ordered_json devices = ordered_json::array();
  for (const db::DeviceRecord& device : run.devices) {
    devices.push_back({{"role", device.role},
                       {"model", device.model},
                       {"serial", device.serial},
                       {"firmware", device.firmware},
                       {"origin", device.origin}});
  }
  if (!devices.empty()) json["devices"] = devices;
  return json;
}

std::string clock_text(double seconds) {
  const long whole = std::lround(seconds);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

void write_whole(const std::string& path, const std::string& text) {
  namespace fs = std::filesystem;
  std::error_code failed;
  if (fs::path(path).has_parent_path()) fs::create_directories(fs::path(path).parent_path(), failed);
  const std::string partial = path + ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream.fail()) fs::rename(partial, path, failed);
  if (stream.fail() || failed) {
    throw Error(ExitCode::kUsage, "TB-FILE-WRITE", "cannot write the file", path,
                "check folder, space and permissions");
  }
}

void add_common(CLI::App& verb, Session& session) {
  verb.add_option("--db", session.db, "run store, one SQLite file a bench")->capture_default_str();
  verb.add_flag("--json", session.json, "one JSON document on standard output, also for errors");
  verb.add_flag("-q,--quiet", session.quiet, "no progress line");
}

}  // namespace tactbench::bench
