#include "bench/nightly/scenario.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
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

namespace tactbench::bench {
namespace {

constexpr std::uint64_t kHeldOutSeeds =
    1'000'000;  // added to the seed, so that it differs from those of a suite with many seeds
constexpr const char* kSpecimenNote = "simulated array of the nightly suite";
constexpr const char* kNightOperator = "nightly";

db::SensorRecord add_specimen(const Scenario& scenario, db::RunStore& store) {
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
  std::map<std::string, std::string> words;
  for (const auto& [name, verdict] : worst) words[name] = analysis::verdict_text(verdict);
  return words;
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
