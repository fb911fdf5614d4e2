#include "bench/nightly/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "analysis/statistics/conformity/overall_verdict.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {
namespace {

using sequences::TomlDocument;
using sequences::TomlTable;

constexpr long kLargestSeed = 1L << 53;

std::vector<int> read_taxels(const TomlTable& table, const std::string& status) {
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

Scenario read_scenario(const TomlTable& table, const std::set<std::string>& taken) {
  Scenario scenario;
  scenario.name = table.text("name");
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; };
  if (scenario.name.empty() || !std::ranges::all_of(scenario.name, plain))
    table.fail("name", fmt::format("'{}' names a file too", scenario.name), "use small letters, digits and hyphens");
  if (taken.count(scenario.name) != 0)
    table.fail("name", fmt::format("two scenarios are named '{}'", scenario.name), "rename one of them");
  scenario.label = scenario.name;
  scenario.about = table.text("about");
  scenario.bench = table.text("bench", scenario.bench);
  scenario.recipes = table.texts("recipes");
  if (scenario.recipes.empty()) scenario.recipes = {"descending", "ascending"};
  scenario.set = table.texts("set");
  for (const char* key : {"held_out", "held_out_2"})
    if (table.has(key)) scenario.held_out.push_back(table.texts(key));
  scenario.void_held_out = table.boolean("void_held_out", false);
  scenario.own_run = table.boolean("own_run", false);
  scenario.fits = table.boolean("fits", true);
  scenario.limits = table.text("limits", scenario.limits);
  scenario.seed = static_cast<std::uint64_t>(table.integer("seed", 1, 0, kLargestSeed));
  scenario.sensor_seed = static_cast<std::uint64_t>(table.integer("sensor_seed", 1, 0, kLargestSeed));
  scenario.outcome = table.word("outcome", scenario.outcome, {"completed", "stopped", "aborted", "failed"});
  scenario.error = table.text("error", "");
  scenario.safe = table.word("safe", scenario.safe, {"verified", "unverified", "failed"});
  const TomlTable taxels = table.table("taxels");
  for (const std::string& status : taxels.keys()) {
    if (const std::vector<std::string> known = {"dead", "stuck", "saturated", "unfit"};
        std::ranges::find(known, status) == known.end())
      taxels.fail(status, fmt::format("'{}' is not a taxel's status", status),
                  "use one of: " + fmt::format("{}", fmt::join(known, ", ")));
    scenario.taxels[status] = read_taxels(taxels, status);
  }
  const TomlTable verdicts = table.table("verdicts");
  for (const std::string& criterion : verdicts.keys())
    scenario.verdicts[criterion] = verdicts.word(criterion, analysis::verdict_words());
  const TomlTable figures = table.table("figures");
  for (const std::string& figure : figures.keys()) scenario.figures[figure] = figures.span(figure, {});
  if (!scenario.fits && !(scenario.taxels.empty() && scenario.verdicts.empty()))
    table.fail("fits", "verdicts and taxels come from a fit, and fits = false", "omit them, or remove fits = false");
  if (scenario.own_run && !scenario.held_out.empty())
    table.fail("own_run", "own_run and held_out cannot be combined", "leave one out");
  if (!scenario.verdicts.empty() && scenario.held_out.empty() && !scenario.own_run)
    table.fail("verdicts", "there is no run to be judged except the fit's own",
               "add held_out, or own_run = true to judge the own figures");
  if (scenario.void_held_out && scenario.held_out.empty())
    table.fail("void_held_out", "there is no held-out run to be declared void", "add held_out");
  for (const TomlTable* part : {&taxels, &verdicts, &figures}) part->finish();
  table.finish();
  return scenario;
}

Suite suite_from(const TomlDocument& document) {
  Suite suite;
  suite.file = document.name();
  suite.text = document.text();
  const TomlTable root = document.root();
  (void)root.integer("schema", 1, 1);
  suite.name = root.name("name");
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

}  // namespace tactbench::bench
