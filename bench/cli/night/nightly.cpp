#include "bench/cli/night/nightly.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/workers.h"
#include "bench/cli/own_copy.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "bench/common/stop_request.h"
#include "bench/common/utc.h"
#include "bench/common/work_progress.h"
#include "bench/config/config.h"
#include "bench/nightly/night_store.h"
#include "bench/reporting/evaluation.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

struct NightlyOptions {
  std::string suite, stores, result, shard, copy;
  NightFiles files;
  Selection selection;
  int jobs = 2;
  double limit_s = 300.0;
  bool list = false, stop_on_red = false, keeps = false;  // keeps: --db was given
};

void list_scenarios(const Suite& suite, const Session& session) {
  auto json = nlohmann::ordered_json::array();
  analysis::doc::Table table{.columns = {{"scenario"}, {.title = "about", .cut = true}}};
  for (const Scenario& scenario : suite.scenarios) {
    json.push_back({JSON_FIELDS(scenario, name, about, seed)});
    table.rows.push_back({{one_line(scenario.name), one_line(scenario.about)}});
  }
  if (!session.json) return print_table(std::move(table));
  print_json("nightly.list", {{"suite", suite.name}, {"scenarios", json}});
}

// With all of its scenarios, or the named ones; the text above the first one is kept.
void copy_suite(const Suite& suite, const NightlyOptions& options, const Session& session) {
  const Suite chosen = selected(suite, {options.selection.only, std::nullopt, 1});
  constexpr std::string_view kBegin = "\n[[scenario]]\n";
  std::string text;
  for (std::size_t at = 0, end = 0; at < suite.text.size(); at = end) {
    end = std::min(suite.text.find(kBegin, at + 1), suite.text.size());
    const std::string part = suite.text.substr(at, end - at);
    const auto is_of = [&](const Scenario& own) {
      return part.find(fmt::format("\nname = \"{}\"\n", own.name)) != std::string::npos;
    };
    if (at == 0 || std::ranges::any_of(chosen.scenarios, is_of)) text += part;
  }
  if (!text.ends_with('\n')) text += "\n";
  write_own_copy({"nightly", "a suite", suite.name, text, options.copy}, session);
}

// The store of one part of a night must hold only that part, because parts are merged by the contents of their stores.
void check_store_of_part(const NightlyOptions& options, const Session& session) {
  if (!options.keeps)
    throw Error("TB-USAGE", "one part of a night must be kept in a store, but none is named", "--shard",
                "add --db FILE, one for each part; tactbench runs merge combines them");
  if (!options.files.html.empty())
    throw Error("TB-USAGE", "a page needs a whole night, but this is one part of it", "--html",
                "leave it out; tactbench runs merge --html writes the page of the whole night");
  if (db::RunStore::open(session.db, db::Durability::kNormal).runs().empty()) return;
  throw Error("TB-SHARD-STORE", "this store holds runs, but one part of a night needs an empty store", session.db);
}

// In a terminal one line that is overwritten, otherwise one line per scenario, for the log of a night.
std::vector<ScenarioResult> carry_out_showing(const Suite& suite, const NightOptions& night,
                                              const std::function<void(const std::vector<ScenarioResult>&)>& on_result,
                                              const Session& session) {
  const std::size_t count = suite.scenarios.size();
  WorkProgress progress("nightly", session.quiet || session.json, {{analysis::counted(count, "scenario"), 1.0}});
  analysis::Work carried_out(count);
  return carry_out_night(suite, night, [&](const std::vector<ScenarioResult>& so_far) {
    carried_out.add();
    on_result(so_far);
    if (!session.quiet && !session.json && !progress.shows()) tty::print(stderr, "{} of {}\n", so_far.size(), count);
  });
}

void nightly(const NightlyOptions& options, Session& session) {
  // A name without a folder is a shipped suite unless such a file lies here.
  const Suite file = read_suite(find_recipe(options.suite));
  if (!options.copy.empty()) return copy_suite(file, options, session);
  if (options.list) return list_scenarios(selected(file, {options.selection.only, std::nullopt, 1}), session);
  const Suite whole = selected(file, options.selection);
  if (!options.result.empty()) {  // one scenario, in a process that a night started
    write_output(options.result, to_json(carry_out(whole.scenarios.front(), session.db)) + "\n", session.replace);
    return;
  }
  const Shard shard = options.shard.empty() ? Shard{} : shard_from(options.shard);
  if (!shard.is_whole()) check_store_of_part(options, session);
  const Suite suite = part_of(whole, shard);
  const StopRequest signals;  // active until the last folder is removed
  NightOptions night{options.jobs, options.limit_s, options.stop_on_red, options.stores, "", &signals, session.replace};
  std::optional<ScratchFolder> scratch;
  if (night.stores.empty()) night.stores = scratch.emplace("tactbench-nightly").path();
  const std::string begun = utc_now();
  write_night_lists(options.files, suite, {}, session);
  write_night_page(options.files, suite, {begun, this_build(), {}, {}}, session);
  if (!session.json)
    tty::print("SIMULATED DATA. {}: {}{}, seconds of wall time\n", suite.name,
               analysis::counted(suite.scenarios.size(), "scenario"),
               shard.is_whole() ? "" : fmt::format(", part {} of {}", shard.text(), whole.scenarios.size()));
  const auto write_lists = [&](const std::vector<ScenarioResult>& so_far) {
    write_night_lists(options.files, suite, so_far, session);
  };
  std::vector<ScenarioResult> results = carry_out_showing(suite, night, write_lists, session);
  std::vector<SubjectTrend> followed;
  if (options.keeps) {
    db::RunStore store = db::RunStore::open(session.db, db::Durability::kNormal);
    store_night({0,
                 whole.name,
                 whole.file,
                 whole.text,
                 to_json(options.selection),
                 shard.number,
                 shard.of,
                 begun,
                 utc_now(),
                 this_build(),
                 {}},
                whole, results, in_stores_of(night.stores), store);
    // Parts are compared only when all are merged.
    if (shard.is_whole()) followed = compare_night(suite, results, store);
    write_night_lists(options.files, suite, results, session);
  }
  write_night_page(options.files, suite, {begun, this_build(), results, std::move(followed)}, session);
  scratch.reset();
  session.code = code_of_night(suite, results);
  if (session.json) return print_json("nightly", night_json(suite, results));
  print_night(suite, results);
}

void add_nightly_options(CLI::App& verb, NightlyOptions& options, Session& session) {
  verb.add_option("suite", options.suite, "suite file; nightly is the shipped one")->required();
  verb.add_option("--jobs", options.jobs, "number of scenarios in parallel")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  add_night_files(verb, options.files);
  add_replace(verb, session);
  verb.add_option(
      "--stores", options.stores,
      "folder for each scenario's store (NAME.db) and output (NAME.log); those of an earlier night are replaced");
  verb.add_flag("--list", options.list, "list the scenarios and end");
  verb.add_option("--copy", options.copy,
                  "copy this suite, or the scenarios of --only, as your own: NAME, or NAME.toml")
      ->type_name("NAME");
  verb.add_option("--only", options.selection.only, "only these scenarios: --only A --only B")->allow_extra_args(false);
  verb.add_option("--seed", options.selection.seed, "seed of noise and faults, instead of the scenarios' own");
  verb.add_option("--seeds", options.selection.seeds,
                  "carry out each scenario this many times, with its seed and the following ones")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb.add_option("--limit", options.limit_s, "limit of real time per scenario, in seconds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb.add_flag("--stop-on-red", options.stop_on_red, "start no scenario after the first red one");
  verb.add_option("--shard", options.shard,
                  "K/N: part K of N of the night, for several machines; needs --db FILE, one for each part; runs merge "
                  "combines the parts and compares")
      ->type_name("K/N");
  verb.add_option("--result", options.result)->group("");
  verb.footer("--db FILE, as typed, keeps the night in that store and compares it with the baselines.");
}

}  // namespace

void add_nightly(CLI::App& app, Session& session) {
  auto options = std::make_shared<NightlyOptions>();
  CLI::App* verb = app.add_subcommand(
      "nightly", "run a suite of scenarios on simulated rigs and compare the results with the expected ones");
  add_nightly_options(*verb, *options, session);
  verb->callback([options, &session] {
    options->keeps = session.typed("--db");
    session.use_db_only_if_typed();
    nightly(*options, session);
  });
}

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
  verb.add_option("--html", files.html, "write a page of changes and figures over the nights");
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
