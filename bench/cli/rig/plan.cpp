#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/cli/rig/recipes.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/calibration_words.h"
#include "bench/rig/device_records.h"
#include "bench/run/recipe_check.h"
#include "bench/run/time_estimate.h"
#include "bench/safety/fail_safe.h"

namespace tactbench::bench {

using nlohmann::ordered_json;
using sequences::Recipe;
using sequences::Step;

namespace {

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
  if (time.runs == 0) return "by the model: no completed run of this recipe on this bench in the store" + prompts;
  return fmt::format("learned from {} completed run{}{}", time.runs, time.runs == 1 ? "" : "s", prompts);
}

ordered_json time_json(const TimeBand& time) {
  return {{"p10_s", time.p10_s},
          {"p50_s", time.p50_s},
          {"p90_s", time.p90_s},
          {"runs", time.runs},
          {"prompts", time.prompts}};
}

ordered_json step_json(const Step& step) {
  return {{"kind", to_string(step.kind)},
          {"sequence", step.sequence},
          {"repeat", step.repeat},
          {"branch", step.branch},
          {"ordinal", step.ordinal},
          {"setpoint_psi", step.setpoint.value()},
          {"force_n", step.force_n},
          {"x_mm", step.x_mm},
          {"y_mm", step.y_mm},
          {"dwell_s", step.dwell_s},
          {"ramp_psi_per_s", step.ramp_psi_per_s},
          {"frame", takes_frame(step)},
          {"line", step_line(step)}};
}

void list_parameters(const std::vector<Recipe>& recipes, bool as_json) {
  ordered_json list = ordered_json::array();
  if (!as_json) {
    tty::print("{:<18}{:<14}{:>10}{:>10}  {:<20}{:<6}{}\n", "recipe", "parameter", "value", "default", "range", "unit",
               "help");
  }
  for (const Recipe& recipe : recipes) {
    for (const sequences::Parameter& p : recipe.parameters) {
      if (as_json) {
        list.push_back({{"recipe", recipe.name},
                        {"name", p.name},
                        {"value", p.value},
                        {"default", p.standard},
                        {"low", p.low},
                        {"high", p.high},
                        {"unit", p.unit},
                        {"help", p.help}});
      } else {
        tty::print("{:<18}{:<14}{:>10g}{:>10g}  {:<20}{:<6}{}\n", recipe.name, p.name, p.value, p.standard,
                   fmt::format("{:g} to {:g}", p.low, p.high), p.unit, p.help);
      }
    }
  }
  if (as_json) print_json("plan.parameters", {{"parameters", list}});
}

TimeEstimate estimate_time(const Plan& plan, const SplitOverrides& overrides, const Session& session) {
  TimeEstimate time(plan.recipes, plan.steps, time_model(plan.bench));
  if (std::filesystem::exists(session.db)) {
    time.learn(db::RunStore::open_read_only(session.db), plan.bench.id, overrides.all, false);
  }
  return time;
}

std::vector<std::string> nearest_texts(const LackingLevel& level, analysis::PressureUnit unit) {
  std::vector<std::string> texts;
  for (const double nearest : level.nearest_psi) texts.push_back(unit.short_text(nearest));
  return texts;
}

void print_lacking(const Plan& plan, const analysis::Limits& limits, analysis::PressureUnit unit) {
  if (plan.lacking.empty()) tty::print("limits '{}': every level to be judged is measured\n", one_line(limits.name));
  for (const LackingLevel& level : plan.lacking) {
    tty::print("limits '{}': {} is not a level of {}{}; non-uniformity there will be inconclusive\n",
               one_line(limits.name), unit.short_text(level.pressure_psi),
               plan.recipes.size() == 1 ? "this recipe" : "these recipes",
               level.nearest_psi.empty()
                   ? std::string()
                   : fmt::format(", whose nearest are {}", fmt::join(nearest_texts(level, unit), " and ")));
  }
}

std::vector<db::DeviceRecord> instruments_of(const Plan& plan) {
  return stated_instruments(plan.bench, needs_press(plan.recipes));
}

ordered_json calibrations_json(const Plan& plan, const std::string& today) {
  ordered_json list = ordered_json::array();
  for (const db::DeviceRecord& record : instruments_of(plan)) {
    const analysis::InstrumentCalibration calibration = analysis::calibration_of(record);
    list.push_back({{"role", record.role},
                    {"model", record.model},
                    {"serial", calibration.serial},
                    {"certificate", calibration.certificate},
                    {"calibrated", calibration.calibrated_on},
                    {"due", calibration.due},
                    {"overdue", due_state(calibration, today) == analysis::DueState::kOverdue}});
  }
  return list;
}

void print_calibrations(const Plan& plan, const std::string& today, analysis::PressureUnit unit) {
  tty::print("instruments that results are traced to:\n");
  for (const db::DeviceRecord& record : instruments_of(plan)) {
    const analysis::InstrumentCalibration calibration = analysis::calibration_of(record);
    tty::print("  - {}, serial {}: {}\n", record.role, calibration.serial.empty() ? "not stated" : calibration.serial,
               calibration_words(calibration, today, unit));
  }
}

void print_plan_json(const Plan& plan, const TimeEstimate& time, bool steps) {
  const sequences::Extremes extremes = sequences::extremes(plan.steps);
  ordered_json axes = ordered_json::array();
  for (const Margin& m : plan.margins) {
    axes.push_back({{"axis", m.axis},
                    {"unit", m.unit},
                    {"lowest", m.lowest},
                    {"highest", m.highest},
                    {"limit", m.high_limit},
                    {"margin", m.margin()}});
  }
  ordered_json recipes = ordered_json::array();
  for (std::size_t i = 0; i < plan.recipes.size(); ++i) {
    recipes.push_back(
        {{"name", plan.recipes[i].name}, {"drawn", plan.recipes[i].drawn}, {"time", time_json(time.total_of(i))}});
  }
  const TimeBand total = time.total();
  ordered_json json = {{"bench", plan.bench.id},
                       {"recipes", recipes},
                       {"steps", plan.estimate.steps},
                       {"frames", plan.estimate.frames},
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
      lacking.push_back({{"pressure_psi", level.pressure_psi}, {"nearest_psi", level.nearest_psi}});
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

void print_plan(const Plan& plan, const TimeEstimate& time, bool steps, analysis::PressureUnit unit) {
  tty::print("{:<18}{:>8}{:>8}{:>12}{:>10}{:>21}\n", "recipe", "steps", "frames", "highest", "time", "10 to 90 %");
  const auto row = [&](const std::string& name, const std::vector<Step>& of, const TimeBand& band) {
    long frames = 0;
    for (const Step& step : of) frames += takes_frame(step) ? 1 : 0;
    const sequences::Extremes e = sequences::extremes(of);
    const std::string highest =
        e.pressurizes ? unit.text(e.highest.value(), 1) : fmt::format("{:.1f} N", e.largest_force_n);
    tty::print("{:<18}{:>8}{:>8}{:>12}{:>10}{:>21}\n", name, of.size(), frames, highest, clock_text(band.p50_s),
               clock_text(band.p10_s) + " - " + clock_text(band.p90_s));
  };
  const TimeBand total = time.total();
  const bool one = plan.recipes.size() == 1;
  for (std::size_t i = 0; !one && i < plan.recipes.size(); ++i) {
    row(one_line(plan.recipes[i].name), sequences::compile(plan.recipes[i], static_cast<int>(i)), time.total_of(i));
  }
  row(one ? one_line(plan.recipes.front().name) : "all", plan.steps, total);
  tty::print("time in h:mm:ss of process time, {}\n", basis(total));
  for (const Recipe& recipe : plan.recipes)
    if (!recipe.drawn.empty()) tty::print("{}: {}\n", one_line(recipe.name), recipe.drawn);
  for (const Margin& m : plan.margins) {
    const bool pressure = m.unit == "psi";
    const auto in = [&](double value) { return pressure ? unit.fixed(value, 2) : fmt::format("{:.2f}", value); };
    const std::string of = pressure ? unit.symbol() : m.unit;
    tty::print("{:<10}{:>8} to {} {}, limit {} {}, margin {} {}\n", m.axis, in(m.lowest), in(m.highest), of,
               in(m.high_limit), of, in(m.margin()), of);
  }
  if (const double force = sequences::extremes(plan.steps).largest_force_n; force > 0.0) {
    tty::print("{:<10}{:>8.2f} N; the sensor's calibrated range is checked once it is open\n", "force up to", force);
  }
  tty::print("about {:.1f} MB in the store\n", plan.estimate.bytes / 1e6);
  tty::print("devices needed: {}\n", fmt::join(devices_needed(plan.recipes), ", "));
  print_calibrations(plan, utc_now().substr(0, 10), unit);
  tty::print("fail-safe layers of bench '{}':\n", plan.bench.id);
  for (const std::string& line : fail_safe_layers(plan.bench, unit)) tty::print("  - {}\n", line);
  if (plan.limits) print_lacking(plan, *plan.limits, unit);
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
    if (!plan.lacking.empty()) session.code = ExitCode::kInconclusive;
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
    print_plan(plan, time, options.steps, session.unit());
  }
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* verb = app.add_subcommand("plan", "check recipes without a device: levels, margins, time; none: list them");
  verb->add_option("recipe", options->recipes,
                   "recipe files or names of shipped ones (descending, ring, ...); none: lists the shipped ones");
  verb->add_option(
          "--set", options->set,
          "override table.key=value, or recipe.key=value (a parameter or a key); a pressure in the key's unit, or with "
          "its own: recipe.step=20kPa")
      ->take_all();
  verb->add_option("--limits", options->limits,
                   "limits file: list levels to be judged that are not measured; exit code 6 when there are any");
  verb->add_flag("--steps", options->steps, "list every step in the order of the run");
  verb->add_flag("--parameters", options->parameters, "list the recipes' parameters instead");
  verb->add_flag("--print", options->print, "print the recipe's file instead, with its comments");
  verb->add_option("--copy", options->copy, "begin a recipe of your own as a copy of this one: NAME, or NAME.toml")
      ->type_name("NAME");
  add_replace(*verb, session);
  verb->callback([options, &session] { plan(*options, session); });
}

}  // namespace tactbench::bench
