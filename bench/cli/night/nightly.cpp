#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/counted.h"
#include "analysis/json_io.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "bench/common/stop_request.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/nightly/followed_page.h"
#include "bench/nightly/night.h"
#include "bench/nightly/night_store.h"
#include "bench/reporting/evaluation.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

struct NightlyOptions {
  std::string suite, only, junit, metrics, html, stores, result;
  std::optional<std::uint64_t> seed;
  int jobs = 2, seeds = 1;
  double limit_s = 300.0;
  bool list = false, stop_on_red = false, keeps = false;  // keeps: --db was given
};

// A name without a folder is a shipped suite unless such a file lies here.
Suite suite_of(const NightlyOptions& options) {
  Suite suite = read_suite(find_recipe(options.suite));
  if (options.only.empty()) return suite;
  std::erase_if(suite.scenarios, [&](const Scenario& scenario) { return scenario.name != options.only; });
  if (suite.scenarios.empty())
    throw Error(ExitCode::kUsage, "TB-NIGHTLY-SCENARIO", fmt::format("there is no scenario '{}'", options.only),
                suite.file, "tactbench nightly SUITE --list shows them");
  return suite;
}

void list_scenarios(const Suite& suite, const Session& session) {
  auto json = nlohmann::ordered_json::array();
  for (const Scenario& scenario : suite.scenarios) {
    json.push_back({{"name", scenario.name}, {"about", scenario.about}, {"seed", scenario.seed}});
    if (!session.json) tty::print("{:<28} {}\n", one_line(scenario.name), one_line(scenario.about));
  }
  if (session.json) print_json("nightly.list", {{"suite", suite.name}, {"scenarios", json}});
}

void show_result(const ScenarioResult& result) {
  const char* state = !result.wrong.empty() ? "RED" : result.remarks.empty() ? "green" : "moved";
  tty::print("{:<6}{:<28}{:>7.1f} s  {}{}{}\n", state, one_line(result.name), result.seconds, one_line(result.about),
             result.compared.empty() ? "" : "; ", result.compared);
  for (const std::string& line : result.wrong) tty::print("        {}\n", line);
  for (const std::string& line : result.remarks) tty::print("        {}\n", line);
}

void nightly(const NightlyOptions& options, Session& session) {
  Suite suite = suite_of(options);
  if (options.list) return list_scenarios(suite, session);
  if (options.seed)
    for (Scenario& scenario : suite.scenarios) scenario.seed = *options.seed;
  if (!options.result.empty()) {  // one scenario, in a process that a night started
    write_output(options.result, to_json(carry_out(suite.scenarios.front(), session.db)) + "\n", session.replace);
    return;
  }
  suite = with_seeds(suite, options.seeds);
  const StopRequest signals;  // active until the last folder is removed
  NightOptions night{options.jobs, options.limit_s, options.stop_on_red, options.stores, "", &signals, session.replace};
  std::optional<ScratchFolder> scratch;
  if (night.stores.empty()) night.stores = scratch.emplace("tactbench-nightly").path();
  const auto write_files = [&](const std::vector<ScenarioResult>& results) {
    if (!options.junit.empty()) write_output(options.junit, junit_xml(suite, results), session.replace);
    if (!options.metrics.empty()) write_output(options.metrics, metrics_text(suite, results), session.replace);
  };
  const std::string begun = utc_now();
  const auto write_page = [&](const std::vector<ScenarioResult>& results, std::vector<Followed> followed) {
    if (options.html.empty()) return;
    write_output(options.html, night_page(suite, {begun, this_build(), results, std::move(followed)}), session.replace);
  };
  write_files({});
  write_page({}, {});
  if (!session.json)
    tty::print("SIMULATED DATA. {}: {}\n", suite.name, analysis::counted(suite.scenarios.size(), "scenario"));
  std::vector<ScenarioResult> results = carry_out_night(suite, night, [&](const std::vector<ScenarioResult>& so_far) {
    write_files(so_far);
    if (session.quiet || session.json) return;
    tty::print(stderr, "{} of {}\n", so_far.size(), suite.scenarios.size());
  });
  std::vector<Followed> followed;
  if (options.keeps) {
    db::RunStore store = db::RunStore::open(session.db, db::Durability::kNormal);
    followed = keep_night(suite, results, night.stores, store);
    write_files(results);
  }
  write_page(results, std::move(followed));
  scratch.reset();
  const auto red = std::ranges::count_if(results, [](const ScenarioResult& r) { return !r.wrong.empty(); });
  const std::size_t missing = suite.scenarios.size() - results.size();
  const bool moved = std::ranges::any_of(results, [](const ScenarioResult& r) { return !r.remarks.empty(); });
  if (red > 0 || missing > 0)
    session.code = ExitCode::kCriterionFailed;
  else if (moved)
    session.code = ExitCode::kInconclusive;
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const ScenarioResult& result : results) json.push_back(analysis::parse_ordered_json(to_json(result)));
    print_json(
        "nightly",
        {{"suite", suite.name}, {"origin", "simulated"}, {"red", red}, {"not_run", missing}, {"scenarios", json}});
    return;
  }
  for (const ScenarioResult& result : results) show_result(result);
  tty::print("{} green, {} red, {} not run\n", results.size() - static_cast<std::size_t>(red), red, missing);
}

}  // namespace

void add_nightly(CLI::App& app, Session& session) {
  auto options = std::make_shared<NightlyOptions>();
  CLI::App* verb = app.add_subcommand(
      "nightly", "carry out a suite of scenarios on simulated rigs and compare the results with the expected ones");
  verb->add_option("suite", options->suite, "suite file; nightly is the shipped one")->required();
  verb->add_option("--jobs", options->jobs, "scenarios at once")->check(CLI::Range(1, 64))->capture_default_str();
  verb->add_option("--junit", options->junit, "write JUnit XML, updated after each scenario");
  verb->add_option("--metrics", options->metrics, "write metrics in Prometheus's text format");
  verb->add_option("--html", options->html, "write a page: changes and figures over the nights");
  add_replace(*verb, session);
  verb->add_option(
      "--stores", options->stores,
      "folder for each scenario's store (NAME.db) and output (NAME.log); those of an earlier night are replaced");
  verb->add_flag("--list", options->list, "name the scenarios and end");
  verb->add_option("--only", options->only, "this scenario alone");
  verb->add_option("--seed", options->seed, "seed of noise and faults, instead of the scenarios' own");
  verb->add_option("--seeds", options->seeds,
                   "carry out each scenario this many times, with its seed and the following ones")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--limit", options->limit_s, "seconds of real time a scenario may take")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb->add_flag("--stop-on-red", options->stop_on_red, "start no scenario after the first red one");
  verb->add_option("--result", options->result)->group("");
  add_common_typed(*verb, session);
  verb->get_option("--db")->description("keep the night in this store, and compare it with the baselines");
  verb->callback([options, verb, &session] {
    options->keeps = verb->count("--db") > 0;
    nightly(*options, session);
  });
}

}  // namespace tactbench::bench
