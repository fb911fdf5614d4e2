#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "bench/safety/fail_safe.h"

namespace tactbench::bench {

namespace {

struct Options {
  std::vector<std::string> recipes, set;
  std::string bench = "simulated.toml";
  bool steps = false;
};

constexpr double kSlewPsiPerSecond = 60.0;  // the chamber's, until the store has timings to learn from

void plan(const Options& options, const Session& session) {
  const SplitOverrides overrides = split_overrides(options.set);
  const BenchConfig bench = read_bench(find_config(options.bench), overrides.bench);
  std::vector<sequences::Recipe> recipes;
  recipes.reserve(options.recipes.size());
  for (const std::string& name : options.recipes) {
    recipes.push_back(sequences::read_recipe(find_recipe(name), overrides.recipe));
  }
  check_limits(recipes, bench.limits);
  const std::vector<sequences::Step> steps = sequences::compile(recipes);
  const double frame_bytes = 2.0 * bench.scanner.rows * bench.scanner.columns * bench.scans_per_frame;
  // A small step is in band at the second look: one feeding and one poll after the command.
  const double settle_s = static_cast<double>(bench.regulator.feed_interval.count()) * 1e-9 + bench.settling.poll_s;
  const sequences::Estimate all = sequences::estimate(steps, kSlewPsiPerSecond, settle_s, frame_bytes);
  if (session.json) {
    nlohmann::ordered_json json = {{"bench", bench.id},
                                   {"steps", all.steps},
                                   {"frames", all.frames},
                                   {"lowest_psi", all.lowest.value()},
                                   {"highest_psi", all.highest.value()},
                                   {"command_limit_psi", bench.limits.command_psi},
                                   {"margin_psi", bench.limits.command_psi - all.highest.value()},
                                   {"process_seconds", all.seconds},
                                   {"store_bytes", all.bytes},
                                   {"fail_safe", fail_safe_layers(bench)}};
    if (options.steps) {
      nlohmann::ordered_json list = nlohmann::ordered_json::array();
      for (const sequences::Step& step : steps) {
        list.push_back({{"kind", step.kind == sequences::StepKind::kMeasure ? "measure" : "conditioning"},
                        {"sequence", step.sequence},
                        {"repeat", step.repeat},
                        {"branch", step.branch},
                        {"ordinal", step.ordinal},
                        {"setpoint_psi", step.setpoint.value()},
                        {"dwell_s", step.dwell_s}});
      }
      json["step_list"] = list;
    }
    print_json("plan", json);
    return;
  }
  fmt::print("{:<16}{:>8}{:>8}{:>10}{:>9}\n", "recipe", "steps", "frames", "highest", "time");
  const auto row = [](const std::string& name, const sequences::Estimate& e) {
    const long minutes = std::lround(e.seconds / 60.0);
    fmt::print("{:<16}{:>8}{:>8}{:>6.1f} psi{:>6}:{:02}\n", name, e.steps, e.frames, e.highest.value(), minutes / 60,
               minutes % 60);
  };
  for (const sequences::Recipe& recipe : recipes) {
    row(recipe.name, sequences::estimate(sequences::compile(recipe, 0), kSlewPsiPerSecond, settle_s, frame_bytes));
  }
  row("all", all);
  fmt::print(
      "command limit {:.1f} psi, margin {:.1f} psi; about {:.1f} MB in the store; time in h:mm of process time\n",
      bench.limits.command_psi, bench.limits.command_psi - all.highest.value(), all.bytes / 1e6);
  fmt::print("fail-safe layers of bench '{}':\n", bench.id);
  for (const std::string& line : fail_safe_layers(bench)) fmt::print("  - {}\n", line);
  if (options.steps) {
    for (const sequences::Step& step : steps) {
      fmt::print("{} sequence {} repeat {} branch {} step {}: {:g} psi, dwell {:g} s\n",
                 step.kind == sequences::StepKind::kMeasure ? "measure" : "condition", step.sequence, step.repeat,
                 step.branch, step.ordinal, step.setpoint.value(), step.dwell_s);
    }
  }
}

}  // namespace

void add_plan(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("plan", "compile recipes without touching a device: steps, extremes, margins, time, bytes");
  verb->add_option("recipe", options->recipes, "recipe files or names of shipped ones (descending, ascending)")
      ->required();
  verb->add_option("--bench", options->bench, "bench file, for its limits")->capture_default_str();
  verb->add_option("--set", options->set, "override table.key=value, or recipe.key=value")->take_all();
  verb->add_flag("--steps", options->steps, "list every step");
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { plan(*options, session); });
}

}  // namespace tactbench::bench
