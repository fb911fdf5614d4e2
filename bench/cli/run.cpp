#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "bench/run/locks.h"

namespace tactbench::bench {

namespace {

struct Options {
  std::vector<std::string> recipes, set;
  std::string bench, sensor, operator_name, purpose, specimen_state;
  SeedOptions seeds;
};

void run(const Options& options, Session& session) {
  const SplitOverrides overrides = split_overrides(options.set);
  RunRequest request;
  request.bench = read_bench(find_config(options.bench), overrides.bench, options.seeds);
  for (const std::string& name : options.recipes) {
    request.recipes.push_back(sequences::read_recipe(find_recipe(name), overrides.recipe));
  }
  check_limits(request.recipes, request.bench.limits);
  request.overrides = overrides.all;
  request.operator_name = options.operator_name;
  request.purpose = options.purpose;
  request.specimen_state_file = options.specimen_state;
  if (!options.specimen_state.empty() && !request.bench.simulation) {
    throw Error(ExitCode::kUsage, "TB-USAGE", "--specimen-state is for a simulated bench", "--specimen-state",
                "leave it out: real film keeps its own state");
  }
  const BenchLock bench_lock(request.bench);
  db::RunStore store = open_for_running(session.db, request.bench);
  const std::optional<db::SensorRecord> sensor = store.sensor(options.sensor);
  if (!sensor) {
    std::vector<std::string> known;
    for (const db::SensorRecord& record : store.sensors()) known.push_back(record.serial);
    throw Error(
        ExitCode::kUsage, "TB-SENSOR-UNKNOWN",
        fmt::format("sensor '{}' is not registered in '{}'", options.sensor, session.db), "--sensor " + options.sensor,
        known.empty() ? fmt::format("tactbench sensors add {} --type sensor.toml --db {}", options.sensor, session.db)
                      : fmt::format("registered: {}; or tactbench sensors add", fmt::join(known, ", ")));
  }
  request.sensor = *sensor;
  request.sensor_type = parse_sensor_type(sensor->type_toml, "sensor type of " + sensor->serial);
  const RunLock run_lock(session.db);
  Progress progress(Progress::mode_for(session.quiet));
  const RunResult result = characterize(request, store, progress);
  if (result.error) throw *result.error;
  if (session.json) {
    nlohmann::ordered_json json = run_json(store.run(result.run));
    json["frames"] = result.frames;
    json["most_exchanges_a_step"] = result.most_exchanges_a_step;
    json["process_seconds"] = result.process_seconds;
    print_json("run", json);
    return;
  }
  fmt::print("run {}: {}, {} frames in {:.0f} min of process time; {}\n", result.run, db::to_string(result.outcome),
             result.frames, result.process_seconds / 60.0, result.safe_text);
}

}  // namespace

void add_run(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("run", "carry out recipes on a bench and store every frame; prints the run's number");
  verb->add_option("recipe", options->recipes, "recipe files or names of shipped ones (descending, ascending)")
      ->required();
  verb->add_option("--bench", options->bench, "bench file")->required();
  verb->add_option("--sensor", options->sensor, "serial of a registered sensor (tactbench sensors add)")->required();
  verb->add_option("--operator", options->operator_name, "who runs it; recorded")->required();
  verb->add_option("--purpose", options->purpose, "why; recorded");
  verb->add_option("--set", options->set, "override table.key=value of the bench file, or recipe.key=value")
      ->take_all();
  verb->add_option("--seed", options->seeds.seed, "simulation: noise and faults");
  verb->add_option("--sensor-seed", options->seeds.sensor_seed, "simulation: makes the array");
  verb->add_option(
      "--specimen-state", options->specimen_state,
      "simulation: file with the film's memory, read if it exists and written at the end; without it a run "
      "starts from virgin film");
  add_common(*verb, session);
  verb->callback([options, &session] { run(*options, session); });
}

}  // namespace tactbench::bench
