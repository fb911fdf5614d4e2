#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
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
  std::string bench = "simulated.toml";
  bool steps = false, parameters = false;
};

struct Plan {
  BenchConfig bench;
  std::vector<Recipe> recipes;
  std::vector<Step> steps;
  std::vector<Margin> margins;
  sequences::Estimate estimate;
};

std::string basis(const TimeBand& time) {
  if (time.runs == 0) return "by the model: no completed run of this recipe on this bench in the store";
  return fmt::format("learned from {} completed run{}", time.runs, time.runs == 1 ? "" : "s");
}

ordered_json time_json(const TimeBand& time) {
  return {{"p10_s", time.p10_s}, {"p50_s", time.p50_s}, {"p90_s", time.p90_s}, {"runs", time.runs}};
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
    fmt::print("{:<18}{:<14}{:>10}{:>10}  {:<20}{:<6}{}\n", "recipe", "parameter", "value", "default", "range", "unit",
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
        fmt::print("{:<18}{:<14}{:>10g}{:>10g}  {:<20}{:<6}{}\n", recipe.name, p.name, p.value, p.standard,
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
    recipes.push_back({{"name", plan.recipes[i].name}, {"time", time_json(time.total_of(i))}});
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
                       {"fail_safe", fail_safe_layers(plan.bench)}};
  if (steps) {
    ordered_json list = ordered_json::array();
    for (const Step& step : plan.steps) list.push_back(step_json(step));
    json["step_list"] = list;
  }
  print_json("plan", json);
}

void print_plan(const Plan& plan, const TimeEstimate& time, bool steps) {
  fmt::print("{:<18}{:>8}{:>8}{:>12}{:>10}{:>21}\n", "recipe", "steps", "frames", "highest", "time", "10 to 90 %");
  const auto row = [](const std::string& name, const std::vector<Step>& of, const TimeBand& band) {
    long frames = 0;
    for (const Step& step : of) frames += takes_frame(step) ? 1 : 0;
    const sequences::Extremes e = sequences::extremes(of);
    const std::string highest =
        e.pressurizes ? fmt::format("{:.1f} psi", e.highest.value()) : fmt::format("{:.1f} N", e.largest_force_n);
    fmt::print("{:<18}{:>8}{:>8}{:>12}{:>10}{:>21}\n", name, of.size(), frames, highest, clock_text(band.p50_s),
               clock_text(band.p10_s) + " - " + clock_text(band.p90_s));
  };
  for (std::size_t i = 0; i < plan.recipes.size(); ++i) {
    row(plan.recipes[i].name, sequences::compile(plan.recipes[i], static_cast<int>(i)), time.total_of(i));
  }
  const TimeBand total = time.total();
  if (plan.recipes.size() > 1) row("all", plan.steps, total);
  fmt::print("time in h:mm:ss of process time, {}\n", basis(total));
  for (const Margin& m : plan.margins) {
    fmt::print("{:<10}{:>8.2f} to {:.2f} {}, limit {:.2f} {}, margin {:.2f} {}\n", m.axis, m.lowest, m.highest, m.unit,
               m.high_limit, m.unit, m.margin(), m.unit);
  }
  if (const double force = sequences::extremes(plan.steps).largest_force_n; force > 0.0) {
    fmt::print("{:<10}{:>8.2f} N; the sensor's calibrated range is checked when it answers\n", "force up to", force);
  }
  fmt::print("about {:.1f} MB in the store\n", plan.estimate.bytes / 1e6);
  fmt::print("devices needed: {}\n", fmt::join(devices_needed(plan.recipes), ", "));
  fmt::print("fail-safe layers of bench '{}':\n", plan.bench.id);
  for (const std::string& line : fail_safe_layers(plan.bench)) fmt::print("  - {}\n", line);
  if (!steps) return;
  for (const Step& step : plan.steps) fmt::print("{}\n", step_line(step));
}

void plan(const PlanOptions& options, const Session& session) {
  const SplitOverrides overrides = split_overrides(options.set);
  Plan plan;
  plan.recipes.reserve(options.recipes.size());
  for (const std::string& name : options.recipes) {
    plan.recipes.push_back(sequences::read_recipe(find_recipe(name), overrides.recipe));
  }
  if (options.parameters) {
    list_parameters(plan.recipes, session.json);
    return;
  }
  plan.bench = read_bench(find_config(options.bench), overrides.bench);
  check_recipes(plan.recipes, plan.bench);
  plan.steps = sequences::compile(plan.recipes);
  plan.margins = margins(plan.steps, plan.bench);
  const double frame_bytes = 2.0 * plan.bench.scanner.rows * plan.bench.scanner.columns * plan.bench.scans_per_frame;
  plan.estimate = sequences::estimate(plan.recipes, plan.steps, time_model(plan.bench), frame_bytes);
  const TimeEstimate time = estimate_time(plan, overrides, session);
  if (session.json) {
    print_plan_json(plan, time, options.steps);
  } else {
    print_plan(plan, time, options.steps);
  }
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* verb =
      app.add_subcommand("plan", "compile recipes without touching a device: steps, extremes, margins, time, bytes");
  verb->add_option("recipe", options->recipes, "recipe files or names of shipped ones (descending, ring, ...)")
      ->required();
  verb->add_option("--bench", options->bench, "bench file, for its limits and devices")->capture_default_str();
  verb->add_option("--set", options->set, "override table.key=value, or recipe.key=value (a parameter or a key)")
      ->take_all();
  verb->add_flag("--steps", options->steps, "list every step, as run carries it out");
  verb->add_flag("--parameters", options->parameters, "list the recipes' parameters instead");
  verb->add_option("--db", session.db, "store to learn times from")->capture_default_str();
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { plan(*options, session); });
}

}  // namespace tactbench::bench
