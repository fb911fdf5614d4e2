#include "bench/nightly/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/json_io.h"
#include "analysis/judgement/verdict.h"
#include "bench/common/error.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {
namespace {

using sequences::Key;
using sequences::KeyTable;
using sequences::kOne;
using sequences::Range;
using sequences::TomlDocument;
using sequences::TomlTable;
namespace key = sequences::key;

constexpr std::array kStatuses = {"dead", "stuck", "saturated", "unfit"};

std::vector<int> read_taxels(const TomlTable& table, const std::string& status) {
  if (std::ranges::find(kStatuses, status) == kStatuses.end())
    table.fail(status, fmt::format("'{}' is not a taxel's status", status),
               fmt::format("use one of: {}", fmt::join(kStatuses, ", ")));
  std::vector<int> taxels;
  for (const double number : table.numbers(status)) {
    if (number < 0.0 || number > 1e6 || number != static_cast<double>(static_cast<int>(number)))
      table.fail(status, fmt::format("taxel {} is not a whole number from 0", number),
                 "taxel = row x columns + column");
    taxels.push_back(static_cast<int>(number));
  }
  std::ranges::sort(taxels);
  return taxels;
}

// Keys whose names the file chooses.
Key taxels_key(const std::string& status, Scenario& scenario) {
  return key::made(
      {status, "list of whole numbers", "1", "0 to 1000000", "",
       "Taxels (row x columns + column) expected as dead, stuck, saturated or not modelled: exactly these"},
      [&scenario, status](const TomlTable& table) { scenario.taxels[status] = read_taxels(table, status); });
}

Key verdict_key(const std::string& criterion, Scenario& scenario) {
  return key::made({criterion, "one of", "-", fmt::format("{}", fmt::join(analysis::verdict_names(), ", ")), "",
                    "Expected verdict of a criterion; overall: all together"},
                   [&scenario, criterion](const TomlTable& table) {
                     scenario.verdicts[criterion] = table.word(criterion, analysis::verdict_names());
                   });
}

Key figure_key(const std::string& figure, Scenario& scenario) {
  return key::made(
      {figure, "[low, high]", "of the figure", "low < high", "", "Lowest and highest value expected of a figure"},
      [&scenario, figure](const TomlTable& table) { scenario.figures[figure] = table.span(figure, {}); });
}

using NamedKey = Key (*)(const std::string&, Scenario&);
constexpr std::array<std::pair<const char*, NamedKey>, 3> kChosenNames = {
    {{"taxels", taxels_key}, {"verdicts", verdict_key}, {"figures", figure_key}}};

KeyTable name_keys(Scenario& scenario) {
  return {key::required(
      key::text("name", scenario.name, "Name of the scenario: small letters, digits and hyphens; also a file's name"))};
}

// held_out and held_out_2 as one list of runs.
Key held_out_key(const char* name, Scenario& scenario, const char* meaning) {
  return key::optional(
      key::made({name, "list of texts", "-", "", "", meaning},
                [name, &scenario](const TomlTable& table) { scenario.held_out.push_back(table.texts(name)); }));
}

KeyTable scenario_keys(Scenario& scenario) {
  constexpr Range kSeeds{0, 9007199254740992.0};  // 2^53
  return {
      key::required(key::text("about", scenario.about, "Purpose of the scenario, in a sentence")),
      key::text("bench", scenario.bench, "Bench file, which must be simulated"),
      key::texts("recipes", scenario.recipes, "Recipes of the run; none: descending and ascending"),
      key::texts("set", scenario.set, "Overrides of bench file and recipes, as --set of tactbench run"),
      held_out_key("held_out", scenario,
                   "A further run of the same sensor with these overrides, on which the models are judged"),
      held_out_key("held_out_2", scenario, "One more such run; the worst verdict counts"),
      key::flag("void_held_out", scenario.void_held_out,
                "Declare the first held-out run void before anything is judged"),
      key::flag("own_run", scenario.own_run,
                "Compare the figures of the fitted run itself with the limits: not a verdict on the sensor"),
      key::flag("fits", scenario.fits, "Whether the run is fitted and judged; false for recipes without a loop"),
      key::word("model", scenario.dynamic, {"dynamic", "elam"}, "dynamic",
                "Kind of the models: dynamic, as made by calibrate, or elam"),
      key::text("limits", scenario.limits, "Limits file of the verdicts"),
      key::number("seed", scenario.seed, kOne, kSeeds, "Seed of noise and faults"),
      key::number("sensor_seed", scenario.sensor_seed, kOne, kSeeds, "Seed of the array"),
      key::word("outcome", scenario.outcome, {"completed", "stopped", "aborted", "failed"},
                "Expected end of the last run"),
      key::text("error", scenario.error, "Expected error of the last run, as TB-...; \"\": none"),
      key::word("safe", scenario.safe, {"verified", "unverified", "failed"}, "Expected safe state after the last run")};
}

Scenario read_scenario(const TomlTable& table, const std::set<std::string>& taken) {
  Scenario scenario;
  read_keys(table, name_keys(scenario));
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; };
  if (scenario.name.empty() || !std::ranges::all_of(scenario.name, plain))
    table.fail("name", fmt::format("'{}' names a file too", scenario.name), "use small letters, digits and hyphens");
  if (taken.count(scenario.name) != 0)
    table.fail("name", fmt::format("two scenarios are named '{}'", scenario.name), "rename one of them");
  scenario.label = scenario.name;
  read_keys(table, scenario_keys(scenario));
  if (scenario.recipes.empty()) scenario.recipes = {"descending", "ascending"};
  for (const auto& [part, key_of] : kChosenNames) {
    const TomlTable below = table.table(part);
    for (const std::string& name : below.keys()) read_keys(below, {key_of(name, scenario)});
  }
  if (!scenario.fits && !(scenario.taxels.empty() && scenario.verdicts.empty()))
    table.fail("fits", "verdicts and taxels come from a fit, but fits = false", "omit them, or remove fits = false");
  if (scenario.own_run && !scenario.held_out.empty())
    table.fail("own_run", "own_run and held_out cannot be combined", "leave one out");
  if (!scenario.verdicts.empty() && scenario.held_out.empty() && !scenario.own_run)
    table.fail("verdicts", "the only run to judge is the fitted one",
               "add held_out, or own_run = true to judge the fitted run itself");
  if (scenario.void_held_out && scenario.held_out.empty())
    table.fail("void_held_out", "there is no held-out run to be declared void", "add held_out");
  table.finish();
  return scenario;
}

KeyTable suite_rows(Suite& suite) { return {key::schema(), key::name("name", suite.name, "Name of the suite")}; }

Suite suite_from(const TomlDocument& document) {
  Suite suite;
  suite.file = document.name();
  suite.text = document.text();
  const TomlTable root = document.root();
  read_keys(root, suite_rows(suite));
  std::set<std::string> names;
  for (const TomlTable& table : root.tables("scenario")) {
    suite.scenarios.push_back(read_scenario(table, names));
    names.insert(suite.scenarios.back().name);
  }
  if (suite.scenarios.empty()) root.fail("scenario", "the suite has no scenario", "add [[scenario]]");
  root.finish();
  return suite;
}

}  // namespace

Suite read_suite(const std::string& path) { return suite_from(TomlDocument::from_file(path)); }
Suite parse_suite(const std::string& text, const std::string& file) {
  return suite_from(TomlDocument::from_text(text, file));
}

std::vector<sequences::KeyFacts> suite_keys() {
  Suite suite;
  Scenario scenario;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", suite_rows(suite));
  add_facts(all, "scenario[]", name_keys(scenario));
  add_facts(all, "scenario[]", scenario_keys(scenario));
  for (const auto& [part, key_of] : kChosenNames)
    add_facts(all, std::string("scenario[].") + part, {key_of("NAME", scenario)});
  return all;
}

Suite with_seeds(const Suite& suite, int seeds) {
  Suite many = suite;
  many.scenarios.clear();
  for (const Scenario& scenario : suite.scenarios) {
    for (int i = 0; i < seeds; ++i) {
      Scenario& own = many.scenarios.emplace_back(scenario);
      own.seed += static_cast<std::uint64_t>(i);
      if (seeds > 1) own.label = fmt::format("{}-seed-{}", own.name, own.seed);
    }
  }
  return many;
}

// Selection of scenarios for a night.

Suite selected(Suite suite, const Selection& selection) {
  for (const std::string& name : selection.only)
    if (std::ranges::find(suite.scenarios, name, &Scenario::name) == suite.scenarios.end())
      throw Error("TB-NIGHTLY-SCENARIO", fmt::format("there is no scenario '{}'", name), suite.file,
                  "tactbench nightly SUITE --list shows them");
  if (!selection.only.empty())
    std::erase_if(suite.scenarios, [&](const Scenario& scenario) {
      return std::ranges::find(selection.only, scenario.name) == selection.only.end();
    });
  if (selection.seed)
    for (Scenario& scenario : suite.scenarios) scenario.seed = *selection.seed;
  return with_seeds(suite, selection.seeds);
}

std::string to_json(const Selection& selection) {
  nlohmann::ordered_json json = {{"only", selection.only}, {"seed", nullptr}, {"seeds", selection.seeds}};
  if (selection.seed) json["seed"] = *selection.seed;
  return analysis::json_line(json);
}

Selection selection_from_json(const std::string& text) {
  try {
    const auto json = analysis::parse_json(text);
    Selection selection{json.at("only"), std::nullopt, json.at("seeds")};
    if (!json.at("seed").is_null()) selection.seed = json.at("seed").get<std::uint64_t>();
    return selection;
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(fmt::format("a night's choice of scenarios cannot be read: {}", error.what()));
  }
}

Suite part_of(const Suite& whole, const Shard& shard) {
  Suite part = whole;
  part.scenarios.clear();
  for (std::size_t i = 0; i < whole.scenarios.size(); ++i)
    if (shard.holds(i)) part.scenarios.push_back(whole.scenarios[i]);
  return part;
}

}  // namespace tactbench::bench
