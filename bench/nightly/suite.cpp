#include "bench/nightly/suite.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/judgement/figure.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/limits.h"
#include "analysis/statistics/figures/rig_figures.h"
#include "bench/common/error.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/run/characterize.h"
#include "bench/run/recipe_check.h"
#include "db/run_store.h"
#include "sequences/recipe.h"
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

namespace {

constexpr std::uint64_t kHeldOutSeeds =
    1'000'000;  // added to the seed, so that it differs from those of a suite with many seeds
constexpr const char* kSpecimenNote = "simulated array of the nightly suite";
constexpr const char* kNightOperator = "nightly";

db::SensorRecord add_specimen(const Scenario& scenario, db::RunWriter& store) {
  const SensorType type = read_sensor_type(find_config("sensor.toml"));
  db::SensorRecord sensor{fmt::format("SIM-{:04}", scenario.sensor_seed),
                          type.name,
                          type.text,
                          db::sha256_hex(type.text),
                          "",
                          kSpecimenNote,
                          utc_now()};
  store.add_sensor(sensor);
  return sensor;
}

// False when the run did not complete.
bool run_once(const Scenario& scenario, const std::vector<std::string>& set, std::uint64_t seed,
              const db::SensorRecord& sensor, db::RunStore& store, ScenarioResult& result) {
  const SplitOverrides overrides = split_overrides(set);
  RunRequest request;
  request.bench = read_bench(find_config(scenario.bench), overrides.bench, {seed, scenario.sensor_seed});
  if (!request.bench.simulation)
    throw Error("TB-NIGHTLY-BENCH", "the nightly suite runs on simulated rigs only",
                fmt::format("scenario {}, bench {}", scenario.name, scenario.bench));
  request.recipes = read_recipes(scenario.recipes, overrides.recipe);
  check_recipes(request.recipes, request.bench);
  request.overrides = overrides.all;
  request.sensor = sensor;
  request.sensor_type = parse_sensor_type(sensor.type_toml, "sensor type");
  request.operator_name = kNightOperator;
  request.purpose = "nightly: " + scenario.name;
  request.assume_yes = true;
  request.attended = false;
  Progress progress(Progress::Mode::kQuiet);
  const RunResult run = characterize(request, store, progress);
  result.runs.push_back({run.run, db::to_string(run.outcome), run.error ? run.error->id() : "", db::to_string(run.safe),
                         run.content_sha256});
  result.figures["frames"] += run.frames;
  result.figures["branches_redone"] += run.branches_redone;
  if (store.frame_count(run.run) > 0)
    result.figures["flagged_frames"] += static_cast<double>(store.flagged_frame_count(run.run));
  return run.outcome == db::Outcome::kCompleted;
}

// The worst word of each criterion over the runs judged.
std::map<std::string, std::string> words_of(const analysis::Judgement& judgement) {
  std::map<std::string, std::optional<analysis::Verdict>> worst;
  for (const analysis::JudgedFigure& figure : judgement.figures) {
    std::string name = to_string(figure.criterion);
    if (figure.scope.kind != analysis::Scope::Kind::kArray)
      name += " " + display_text(figure.scope, analysis::PressureUnit::kPsi);
    worst[name] = std::max(worst[name], std::optional(figure.verdict));
  }
  std::map<std::string, std::string> text;
  for (const auto& [name, verdict] : worst) text[name] = analysis::verdict_text(verdict);
  return text;
}

void judge(const Scenario& scenario, db::RunStore& store, ScenarioResult& result) {
  std::vector<std::int64_t> held_out;
  for (std::size_t i = 1; i < result.runs.size(); ++i) held_out.push_back(result.runs[i].run);
  if (scenario.void_held_out) store.void_run(held_out.front(), "by the scenario", "nightly", utc_now());
  analysis::Runs runs(store);
  const std::int64_t fitted = result.runs.front().run;
  const analysis::SensorModel fit =
      scenario.dynamic ? fit_run_dynamic(store, runs, fitted) : fit_run(store, runs.dataset(fitted));
  const std::vector<NamedEvaluation> evaluations = evaluate_runs(runs, fit, held_out);
  const std::size_t shown = scenario.held_out.empty() ? 0 : scenario.void_held_out ? evaluations.size() - 1 : 1;
  const analysis::Evaluation& e = evaluations[shown].evaluation;
  if (scenario.own_run) {
    const analysis::Limits limits = read_limits(find_config(scenario.limits));
    analysis::Evidence evidence = gather_evidence(runs, fit, {evaluations[shown]}, limits, true);
    evidence.runs.front().counts = analysis::EvidenceRun::Counts::kYes;
    result.verdicts = words_of(analysis::judge(evidence, limits));
  } else if (!held_out.empty()) {
    const analysis::Judgement judgement = judge_and_store(store, runs, fit, evaluations, scenario.limits).judgement;
    result.verdicts = words_of(judgement);
    result.verdicts["overall"] = analysis::verdict_text(analysis::worst_of(judgement.figures));
  }
  for (std::size_t taxel = 0; taxel < fit.array().size(); ++taxel)
    if (fit.taxels[taxel].status != analysis::TaxelStatus::kFitted)
      result.taxels[to_string(fit.taxels[taxel].status)].push_back(static_cast<int>(taxel));
  result.figures.merge(analysis::figures_of(fit, e));
}

// For a run that is not fitted, the figures of its rig are used.
void add_rig_figures(const db::RunStore& store, ScenarioResult& result) {
  const analysis::StoredRun run = analysis::read_run(store, store.run(result.runs.back().run));
  result.figures["instruments"] = static_cast<double>(run.record.devices.size());
  const std::vector<db::EventRecord> events = store.events(run.record.run);
  const auto busy = std::ranges::count(events, "TB-MODBUS-BUSY", &db::EventRecord::id),
             repeated = std::ranges::count(events, "attempt", &db::EventRecord::kind);
  if (busy > 0) result.figures["module_busy"] = static_cast<double>(busy);
  result.figures["repeated_reads"] = static_cast<double>(repeated);
  result.figures.merge(analysis::chamber_figures(run));
  result.figures.merge(analysis::press_figures(run));
}

void compare(const std::string& what, const std::string& wanted, const std::string& came,
             std::vector<std::string>& lines) {
  if (wanted != came)
    lines.push_back(
        fmt::format("{} is {}, must be {}", what, came.empty() ? "none" : came, wanted.empty() ? "none" : wanted));
}

}  // namespace

ScenarioResult carry_out(const Scenario& scenario, const std::string& path) {
  const auto begun = std::chrono::steady_clock::now();
  ScenarioResult result;
  result.name = scenario.label;
  result.about = scenario.about;
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  const db::SensorRecord sensor = add_specimen(scenario, store);
  bool completed = run_once(scenario, scenario.set, scenario.seed, sensor, store, result);
  std::uint64_t seed = scenario.seed;
  for (const std::vector<std::string>& own : scenario.held_out) {
    if (!completed) break;
    std::vector<std::string> set = scenario.set;
    set.insert(set.end(), own.begin(), own.end());
    seed += kHeldOutSeeds;
    completed = run_once(scenario, set, seed, sensor, store, result);
  }
  if (completed) {
    try {
      scenario.fits ? judge(scenario, store, result) : add_rig_figures(store, result);
    } catch (const std::exception&) {
      const Error error = as_error(std::current_exception());
      result.wrong.push_back(fmt::format("the analysis ended with {}: {}", error.id(), error.what()));
    }
  }
  for (std::string& line : differences(scenario, result)) result.wrong.push_back(std::move(line));
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

bool is_scenario_store(const std::string& store) try {
  const db::RunStore found = db::RunStore::open_read_only(store);
  return std::ranges::all_of(found.sensors(), [](const auto& sensor) { return sensor.note == kSpecimenNote; }) &&
         std::ranges::all_of(found.runs(), [](const auto& run) {
           return run.operator_name == kNightOperator && run.tags.empty() && run.notes.empty();
         });
} catch (const db::StoreError&) {
  return false;
}

std::vector<std::string> differences(const Scenario& scenario, const ScenarioResult& result) {
  std::vector<std::string> lines;
  const ScenarioRun& last = result.runs.back();
  compare("the outcome", scenario.outcome, last.outcome, lines);
  compare("the error", scenario.error, last.error, lines);
  compare("the safe state", scenario.safe, last.safe, lines);
  if (scenario.fits && last.outcome == "completed") {
    for (const char* status : {"dead", "stuck", "saturated", "unfit"}) {
      const auto wanted = scenario.taxels.find(status), came = result.taxels.find(status);
      const auto text = [](const auto& found, const auto& map) {
        return found == map.end() ? std::string() : fmt::format("{}", fmt::join(found->second, ", "));
      };
      compare(fmt::format("the list of {} taxels", status), text(wanted, scenario.taxels), text(came, result.taxels),
              lines);
    }
  }
  for (const auto& [criterion, wanted] : scenario.verdicts) {
    const auto own = [&](const auto& verdict) {
      return verdict.first == criterion || verdict.first.starts_with(criterion + " ");
    };
    if (std::ranges::none_of(result.verdicts, own))
      lines.push_back(fmt::format("there is no verdict by {}, must be {}", criterion, wanted));
    for (const auto& [name, word] : result.verdicts)
      if (own(std::pair(name, word))) compare("the verdict on " + name, wanted, word, lines);
  }
  for (const auto& [figure, limits] : scenario.figures) {
    const auto came = result.figures.find(figure);
    if (came == result.figures.end())
      lines.push_back(fmt::format("there is no figure {}", figure));
    else if (!(came->second >= limits.first && came->second <= limits.second))
      lines.push_back(
          fmt::format("{} is {:.6g}, must be {:g} to {:g}", figure, came->second, limits.first, limits.second));
  }
  return lines;
}

std::string to_json(const ScenarioResult& result) {
  nlohmann::ordered_json json = {
      JSON_FIELDS(result, name, about, wrong, remarks, compared, figures, verdicts, taxels, seconds)};
  json["runs"] = nlohmann::ordered_json::array();
  for (const ScenarioRun& run : result.runs)
    json["runs"].push_back({JSON_FIELDS(run, run, outcome, error, safe, content_sha256)});
  return analysis::json_line(json);
}

ScenarioResult result_from_json(const std::string& text) {
  try {
    const auto json = analysis::parse_json(text);
    ScenarioResult result;
    result.name = json.at("name");
    result.about = json.at("about");
    result.wrong = json.at("wrong").get<std::vector<std::string>>();
    result.remarks = json.at("remarks").get<std::vector<std::string>>();
    result.compared = json.at("compared");
    for (const auto& [name, value] : json.at("figures").items())
      result.figures[name] = value.is_null() ? std::nan("") : value.get<double>();
    result.verdicts = json.at("verdicts").get<std::map<std::string, std::string>>();
    result.taxels = json.at("taxels").get<std::map<std::string, std::vector<int>>>();
    result.seconds = json.at("seconds");
    for (const auto& run : json.at("runs"))
      result.runs.push_back(
          {run.at("run"), run.at("outcome"), run.at("error"), run.at("safe"), run.at("content_sha256")});
    return result;
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(fmt::format("a scenario's result cannot be read: {}", error.what()));
  }
}

}  // namespace tactbench::bench
