#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/report/report_facts.h"
#include "bench/cli/own_copy.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/config/config_calibration.h"
#include "bench/rig/device_records.h"
#include "bench/run/recipe_check.h"
#include "bench/run/time_estimate.h"
#include "bench/safety/safe_state.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace doc = analysis::doc;
using nlohmann::ordered_json;
using sequences::Recipe;
using sequences::RecipeFile;
using sequences::Step;

namespace {

struct ShippedRecipe {
  RecipeFile file;
  std::string path;
};

// In the order of their names; shipped files that are not recipes, such as a suite, are left out.
std::vector<ShippedRecipe> shipped_recipes() {
  std::vector<ShippedRecipe> shipped;
  for (const std::string& file : shipped_files("sequences")) {
    const std::string path = fmt::format("{}/sequences/{}", share_folder(), file);
    try {
      shipped.push_back({read_recipe_file(path), path});
    } catch (const sequences::FileError&) {
      continue;  // the folder also holds a suite
    }
  }
  return shipped;
}

struct RecipeExtent {
  std::size_t steps = 0, frames = 0;
  std::string highest;  // "60.0 psi", "30.0 N"
};

RecipeExtent extent_of(const std::vector<Recipe>& recipes, analysis::PressureUnit unit) {
  const std::vector<sequences::Step> steps = sequences::compile(recipes);
  RecipeExtent extent{steps.size(), 0, {}};
  for (const sequences::Step& step : steps) extent.frames += has_frame(step) ? 1 : 0;
  const sequences::Extremes reached = sequences::extremes(steps);
  extent.highest =
      reached.pressurizes ? unit.text(reached.highest.value(), 1) : fmt::format("{:.1f} N", reached.largest_force_n);
  return extent;
}

// "31 turning points drawn, ..."; empty where none of them are drawn.
std::string drawn_of(const RecipeFile& file) {
  std::string drawn;
  for (const Recipe& recipe : file.recipes)
    if (!recipe.drawn.empty()) drawn += (drawn.empty() ? "" : "; ") + recipe.drawn;
  return drawn;
}

ordered_json recipe_json(const RecipeFile& file, const std::string& path) {
  const RecipeExtent extent = extent_of(file.recipes, analysis::PressureUnit::kPsi);
  auto names = ordered_json::array();
  for (const Recipe& recipe : file.recipes) names.push_back(recipe.name);
  return {JSON_FIELDS(file, name, title),
          {"file", path},
          JSON_FIELDS(extent, steps, frames, highest),
          {"repeats", file.recipes.front().repeats},
          {"drawn", drawn_of(file)},
          {"recipes", names}};
}

void list_recipes(const Session& session) {
  auto json = ordered_json::array();
  analysis::doc::Table table{
      .columns = {{"recipe"}, {"frames", true}, {"highest", true}, {.title = "what it is", .cut = true}}};
  for (const ShippedRecipe& shipped : shipped_recipes()) {
    if (session.json) {
      json.push_back(recipe_json(shipped.file, shipped.path));
      continue;
    }
    const RecipeExtent extent = extent_of(shipped.file.recipes, session.unit());
    table.rows.push_back(
        {{shipped.file.name, std::to_string(extent.frames), extent.highest, one_line(shipped.file.title)}});
  }
  if (session.json) return print_json("plan.recipes", {{"recipes", json}});
  print_table(std::move(table));
  tty::print("tactbench plan NAME shows more; plan NAME --copy MINE copies it as your own\n");
}

void print_recipe(const std::string& name, const Session& session) {
  const std::string path = find_recipe(name);
  const RecipeFile file = read_recipe_file(path);
  if (session.json) {
    ordered_json json = recipe_json(file, path);
    json["text"] = file.text;
    return print_json("plan.recipe", json);
  }
  tty::print("# {}\n{}", path, file.text);
}

void copy_recipe(const std::string& name, const std::string& file, const Session& session) {
  const RecipeFile from = read_recipe_file(name);
  write_own_copy({"plan", "a recipe", from.name, from.text, file}, session);
}

struct PlanOptions {
  std::vector<std::string> recipes, set;
  std::string limits, copy;
  bool steps = false, parameters = false, print = false;
};

struct Plan {
  BenchConfig bench;
  std::vector<Recipe> recipes;
  std::vector<Step> steps;
  std::vector<Margin> margins;
  sequences::Estimate estimate;
  std::optional<analysis::Limits> limits;
  std::vector<LackingLevel> lacking;  // of the limits
};

std::string basis(const TimeBand& time) {
  const std::string prompts = time.prompts == 0 ? ""
                                                : fmt::format("; plus {} prompt{} and the operator's time to answer",
                                                              time.prompts, time.prompts == 1 ? "" : "s");
  if (time.runs == 0) return "estimated (never run here)" + prompts;
  return fmt::format("learned from {} completed run{}{}", time.runs, time.runs == 1 ? "" : "s", prompts);
}

ordered_json time_json(const TimeBand& time) { return {JSON_FIELDS(time, p10_s, p50_s, p90_s, runs, prompts)}; }

ordered_json step_json(const Step& step) {
  return {{"kind", to_string(step.kind)},
          JSON_FIELDS(step, sequence, repeat, branch, ordinal),
          {"setpoint_psi", step.setpoint.value()},
          JSON_FIELDS(step, force_n, x_mm, y_mm, dwell_s, ramp_psi_per_s),
          {"frame", has_frame(step)},
          {"line", step_line(step)}};
}

void list_parameters(const std::vector<Recipe>& recipes, bool as_json) {
  ordered_json list = ordered_json::array();
  doc::Table table{.columns = {{"recipe"},
                               {"parameter"},
                               {"value", true},
                               {"default", true},
                               {"range"},
                               {"unit"},
                               {.title = "help", .cut = true}}};
  for (const Recipe& recipe : recipes) {
    for (const sequences::Parameter& p : recipe.parameters) {
      list.push_back({{"recipe", recipe.name},
                      JSON_FIELDS(p, name, value),
                      {"default", p.standard},
                      JSON_FIELDS(p, low, high, unit, help)});
      table.rows.push_back(
          {{one_line(recipe.name), one_line(p.name), fmt::format("{:g}", p.value), fmt::format("{:g}", p.standard),
            fmt::format("{:g} to {:g}", p.low, p.high), one_line(p.unit), one_line(p.help)}});
    }
  }
  if (as_json) return print_json("plan.parameters", {{"parameters", list}});
  print_table(std::move(table));
}

TimeEstimate estimate_time(const Plan& plan, const SplitOverrides& overrides, const Session& session) {
  TimeEstimate time(plan.recipes, plan.steps, time_model(plan.bench));
  if (std::filesystem::exists(session.db)) {
    time.learn(db::RunStore::open_read_only(session.db), plan.bench.id, overrides.all, false);
  }
  return time;
}

std::string judged_text(const Plan& plan, const analysis::Limits& limits, analysis::PressureUnit unit) {
  const std::string name = one_line(limits.name);
  const NotJudged open = not_judged(plan.steps, {}, limits, unit);
  if (open.why.empty()) return fmt::format("limits '{}': every level to be judged is measured", name);
  std::string text;
  for (const std::string& why : open.why) text += fmt::format("{}limits '{}': {}", text.empty() ? "" : "\n", name, why);
  return text;
}

std::vector<db::DeviceRecord> instruments_of(const Plan& plan) {
  return stated_instruments(plan.bench, needs_press(plan.recipes));
}

ordered_json calibrations_json(const Plan& plan, const std::string& today) {
  ordered_json list = ordered_json::array();
  for (const db::DeviceRecord& record : instruments_of(plan)) {
    const analysis::InstrumentCalibration calibration = analysis::calibration_of(record);
    list.push_back({JSON_FIELDS(record, role, model),
                    JSON_FIELDS(calibration, serial, certificate),
                    {"calibrated", calibration.calibrated_on},
                    {"due", calibration.due},
                    {"overdue", due_state(calibration, today) == analysis::DueState::kOverdue}});
  }
  return list;
}

void print_plan_json(const Plan& plan, const TimeEstimate& time, bool steps) {
  const sequences::Extremes extremes = sequences::extremes(plan.steps);
  ordered_json axes = ordered_json::array();
  for (const Margin& m : plan.margins) {
    axes.push_back({JSON_FIELDS(m, axis, unit, lowest, highest), {"limit", m.high_limit}, {"margin", m.margin()}});
  }
  ordered_json recipes = ordered_json::array();
  for (std::size_t i = 0; i < plan.recipes.size(); ++i) {
    recipes.push_back({JSON_FIELDS(plan.recipes[i], name, drawn), {"time", time_json(time.total_of(i))}});
  }
  const TimeBand total = time.total();
  ordered_json json = {{"bench", plan.bench.id},
                       {"recipes", recipes},
                       JSON_FIELDS(plan.estimate, steps, frames),
                       {"axes", axes},
                       {"lowest_psi", extremes.lowest.value()},
                       {"highest_psi", extremes.highest.value()},
                       {"largest_force_n", extremes.largest_force_n},
                       {"command_limit_psi", plan.bench.limits.command_psi},
                       {"margin_psi", plan.bench.limits.command_psi - extremes.highest.value()},
                       {"process_seconds", total.p50_s},
                       {"time", time_json(total)},
                       {"store_bytes", plan.estimate.bytes},
                       {"devices", devices_needed(plan.recipes)},
                       {"instruments", calibrations_json(plan, utc_now().substr(0, 10))},
                       {"fail_safe", fail_safe_layers(plan.bench)}};
  if (plan.limits) {
    ordered_json lacking = ordered_json::array();
    for (const LackingLevel& level : plan.lacking) {
      lacking.push_back({JSON_FIELDS(level, pressure_psi, nearest_psi)});
    }
    json["limits"] = {{"name", plan.limits->name}, {"levels_lacking", lacking}};
  }
  if (steps) {
    ordered_json list = ordered_json::array();
    for (const Step& step : plan.steps) list.push_back(step_json(step));
    json["step_list"] = list;
  }
  print_json("plan", json);
}

void print_plan(const Plan& plan, const TimeEstimate& time, bool steps, const Session& session) {
  const analysis::PressureUnit unit = session.unit();
  doc::Document out;
  const auto add = [&](const std::string& text) { out.add(doc::Paragraph{{text}}); };
  doc::Table table{
      .columns = {
          {"recipe"}, {"steps", true}, {"frames", true}, {"highest", true}, {"time", true}, {"10 to 90 %", true}}};
  const auto row = [&](const std::string& name, const std::vector<Step>& of, const TimeBand& band) {
    const auto frames = std::ranges::count_if(of, [](const Step& step) { return has_frame(step); });
    const sequences::Extremes e = sequences::extremes(of);
    table.rows.push_back({{name, std::to_string(of.size()), std::to_string(frames),
                           e.pressurizes ? unit.text(e.highest.value(), 1) : fmt::format("{:.1f} N", e.largest_force_n),
                           clock_text(band.p50_s), clock_text(band.p10_s) + " to " + clock_text(band.p90_s)}});
  };
  const TimeBand total = time.total();
  const bool one = plan.recipes.size() == 1;
  for (std::size_t i = 0; !one && i < plan.recipes.size(); ++i)
    row(one_line(plan.recipes[i].name), sequences::compile(plan.recipes[i], static_cast<int>(i)), time.total_of(i));
  row(one ? one_line(plan.recipes.front().name) : "all", plan.steps, total);
  out.add(std::move(table));
  add(fmt::format("process time h:mm:ss, {}; about {:.1f} MB in the store", basis(total), plan.estimate.bytes / 1e6));
  for (const Recipe& recipe : plan.recipes)
    if (!recipe.drawn.empty()) add(fmt::format("{}: {}", one_line(recipe.name), recipe.drawn));
  for (const Margin& m : plan.margins) {
    const auto in = [&](double value) {
      return m.unit == "psi" ? unit.short_text(value) : fmt::format("{:.2f} {}", value, m.unit);
    };
    add(fmt::format("{} {} to {}, limit {}, margin {}", m.axis, in(m.lowest), in(m.highest), in(m.high_limit),
                    in(m.margin())));
  }
  if (const double force = sequences::extremes(plan.steps).largest_force_n; force > 0.0)
    add(fmt::format("force up to {:.2f} N; the sensor's calibrated range is checked once it is open", force));
  add(fmt::format("devices needed: {}", fmt::join(devices_needed(plan.recipes), ", ")));
  const std::vector<std::string> layers = fail_safe_layers(plan.bench, unit);
  if (!session.all) add(fmt::format("fail-safe: {} (--all)", analysis::counted(layers.size(), "layer")));
  for (const std::string& layer : layers)
    if (session.all || layer.starts_with("WARNING")) add("fail-safe: " + layer);
  for (const db::DeviceRecord& record : instruments_of(plan)) {
    const analysis::InstrumentCalibration calibration = analysis::calibration_of(record);
    if (session.all)
      add(fmt::format("{}, serial {}: {}", record.role, analysis::or_not_stated(calibration.serial),
                      calibration_text(calibration, utc_now().substr(0, 10), unit)));
  }
  if (plan.limits) add(judged_text(plan, *plan.limits, unit));
  print_document(out, unit);
  if (!steps) return;
  for (const Step& step : plan.steps) tty::print("{}\n", step_line(step, unit.symbol(), unit.of(1.0)));
}

void plan(const PlanOptions& options, Session& session) {
  if (options.recipes.empty()) return list_recipes(session);
  if (options.print || !options.copy.empty()) {
    if (options.recipes.size() != 1) throw Error("TB-USAGE", "--print and --copy take one recipe", "plan", "name one");
    return options.print ? print_recipe(options.recipes.front(), session)
                         : copy_recipe(options.recipes.front(), options.copy, session);
  }
  const SplitOverrides overrides = split_overrides(options.set);
  Plan plan;
  plan.recipes = read_recipes(options.recipes, overrides.recipe);
  if (options.parameters) {
    list_parameters(plan.recipes, session.json);
    return;
  }
  plan.bench = read_bench(find_config(session.bench_file(kShippedBench)), overrides.bench);
  check_recipes(plan.recipes, plan.bench);
  plan.steps = sequences::compile(plan.recipes);
  plan.margins = margins(plan.steps, plan.bench);
  if (!options.limits.empty()) {
    plan.limits = read_limits(find_config(options.limits));
    plan.lacking = lacking_levels(plan.steps, *plan.limits);
    if (!not_judged(plan.steps, {}, *plan.limits, session.unit()).why.empty()) session.code = ExitCode::kInconclusive;
  }
  const double frame_bytes = 2.0 * plan.bench.scanner.rows * plan.bench.scanner.columns * plan.bench.scans_per_frame;
  plan.estimate = sequences::estimate(plan.recipes, plan.steps, time_model(plan.bench), frame_bytes);
  const TimeEstimate time = estimate_time(plan, overrides, session);
  for (const std::string& line : recipe_warnings(plan.recipes, plan.bench, session.unit()))
    tty::print(stderr, "warning: {}\n", line);
  for (const std::string& line :
       calibration_warnings(plan.bench, instruments_of(plan), utc_now().substr(0, 10), plan.steps, session.unit()))
    tty::print(stderr, "warning: {}\n", line);
  if (session.json) {
    print_plan_json(plan, time, options.steps);
  } else {
    print_plan(plan, time, options.steps, session);
  }
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* verb = app.add_subcommand("plan", "check recipes without a device: levels, margins, time; none: list them");
  verb->add_option("recipe", options->recipes,
                   "recipe files or names of shipped ones (descending, ring, ...); none: lists the shipped ones");
  verb->add_option("--set", options->set,
                   "override table.key=value, or recipe.key=value (a parameter or a key); a pressure in the key's "
                   "unit, or with a unit: recipe.step=20kPa")
      ->take_all();
  verb->add_option("--limits", options->limits,
                   "limits file: list levels to be judged that are not measured; exit code 6 if there are any");
  verb->add_flag("--steps", options->steps, "list every step in the order of the run");
  verb->add_flag("--parameters", options->parameters, "list the recipes' parameters instead");
  add_all(*verb, session);
  verb->add_flag("--print", options->print, "print the recipe's file instead, with its comments");
  verb->add_option("--copy", options->copy, "copy this recipe as your own: NAME, or NAME.toml")->type_name("NAME");
  add_replace(*verb, session);
  verb->callback([options, &session] { plan(*options, session); });
}

}  // namespace tactbench::bench
