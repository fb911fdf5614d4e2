#include "bench/cli/night/night_results.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {
namespace {

std::size_t red_of(const std::vector<ScenarioResult>& results) {
  return static_cast<std::size_t>(
      std::ranges::count_if(results, [](const ScenarioResult& r) { return !r.wrong.empty(); }));
}

void show_result(const ScenarioResult& result) {
  const char* state = !result.wrong.empty() ? "RED" : result.remarks.empty() ? "green" : "moved";
  tty::print("{:<6}{:<28}{:>7.1f} s  {}{}{}\n", state, one_line(result.name), result.seconds, one_line(result.about),
             result.compared.empty() ? "" : "; ", result.compared);
  for (const std::string& line : result.wrong) tty::print("        {}\n", line);
  for (const std::string& line : result.remarks) tty::print("        {}\n", line);
}

}  // namespace

void add_night_files(CLI::App& verb, NightFiles& files) {
  verb.add_option("--junit", files.junit, "write JUnit XML, updated after each scenario");
  verb.add_option("--metrics", files.metrics, "write metrics in Prometheus's text format");
  verb.add_option("--html", files.html, "write a page: changes and figures over the nights");
}

void write_night_lists(const NightFiles& files, const Suite& suite, const std::vector<ScenarioResult>& results,
                       const Session& session) {
  if (!files.junit.empty()) write_output(files.junit, junit_xml(suite, results), session.replace);
  if (!files.metrics.empty()) write_output(files.metrics, metrics_text(suite, results), session.replace);
}

void write_night_page(const NightFiles& files, const Suite& suite, const NightPage& night, const Session& session) {
  if (!files.html.empty()) write_output(files.html, night_page(suite, night), session.replace);
}

ExitCode code_of_night(const Suite& suite, const std::vector<ScenarioResult>& results) {
  if (red_of(results) > 0 || results.size() < suite.scenarios.size()) return ExitCode::kCriterionFailed;
  const bool moved = std::ranges::any_of(results, [](const ScenarioResult& r) { return !r.remarks.empty(); });
  return moved ? ExitCode::kInconclusive : ExitCode::kPass;
}

nlohmann::ordered_json night_json(const Suite& suite, const std::vector<ScenarioResult>& results) {
  auto json = nlohmann::ordered_json::array();
  for (const ScenarioResult& result : results) json.push_back(analysis::parse_ordered_json(to_json(result)));
  return {{"suite", suite.name},
          {"origin", "simulated"},
          {"red", red_of(results)},
          {"not_run", suite.scenarios.size() - results.size()},
          {"scenarios", json}};
}

void print_night(const Suite& suite, const std::vector<ScenarioResult>& results) {
  for (const ScenarioResult& result : results) show_result(result);
  tty::print("{} green, {} red, {} not run\n", results.size() - red_of(results), red_of(results),
             suite.scenarios.size() - results.size());
}

}  // namespace tactbench::bench
