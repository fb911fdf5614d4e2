#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/documents/run_json.h"
#include "bench/cli/rig/page.h"
#include "bench/cli/rig/run.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/config_calibration.h"
#include "bench/guard/trip.h"
#include "bench/rig/device_records.h"
#include "bench/run/characterize.h"
#include "bench/run/control/locks.h"
#include "bench/run/recipe_check.h"
#include "bench/run/run_record.h"
#include "bench/run/time_estimate.h"
#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

db::SensorRecord registered(const db::RunReader& store, const std::string& serial, const std::string& db_path) {
  if (const std::optional<db::SensorRecord> sensor = store.sensor(serial)) return *sensor;
  std::vector<std::string> known;
  for (const db::SensorRecord& record : store.sensors()) known.push_back(record.serial);
  throw Error("TB-SENSOR-UNKNOWN", fmt::format("sensor '{}' is not registered in '{}'", serial, db_path),
              "--sensor " + serial,
              known.empty() ? fmt::format("tactbench sensors add {} --type sensor.toml --db {}", serial, db_path)
                            : fmt::format("registered: {}; or tactbench sensors add", fmt::join(known, ", ")));
}

struct CarriedOut {
  RunResult result;
  std::string estimated;
};

std::string prompts_text(int prompts) {
  return prompts == 0 ? "" : fmt::format(" + {} prompt{}", prompts, prompts == 1 ? "" : "s");
}

CarriedOut carry_out(RunRequest& request, db::RunStore& store, const std::string& sensor, const Session& session) {
  request.sensor = registered(store, sensor, session.db);
  request.sensor_type = parse_sensor_type(request.sensor.type_toml, "sensor type of " + sensor);
  Progress progress(Progress::mode_for(session.quiet), session.unit());
  const std::vector<sequences::Step> steps = sequences::compile(request.recipes);
  TimeEstimate estimate(request.recipes, steps, time_model(request.bench));
  estimate.learn(store, request.bench.id, request.overrides, true);
  request.estimate = &estimate;
  const std::int64_t frames =
      request.resume == 0 ? 0 : store.frame_count(request.resume) - store.void_frame_count(request.resume);
  const TimeBand band = estimate.remaining(frames > 0 ? steps_done(steps, frames) : 0);
  const std::string basis =
      band.runs > 0 ? fmt::format("learned from {} run{}", band.runs, band.runs == 1 ? "" : "s") : "never run here";
  const std::string estimated = fmt::format("{} of process time{} ({} to {}, {})", clock_text(band.p50_s),
                                            prompts_text(request.assume_yes ? 0 : band.prompts), clock_text(band.p10_s),
                                            clock_text(band.p90_s), basis);
  if (!session.quiet) progress.note(fmt::format("estimated {}", estimated));
  RunResult result = characterize(request, store, progress);
  if (result.error)
    throw result.error->with_rig_state(result.error_state.in(session.unit()), result.safe == db::SafeState::kVerified);
  return {std::move(result), estimated};
}

void show_run_result(const CarriedOut& done, const Session& session) {
  const RunResult& result = done.result;
  if (session.json) {
    nlohmann::ordered_json json = analysis::run_json(db::RunStore::open_read_only(session.db).run(result.run));
    json["frames"] = result.frames_kept;
    json["most_exchanges_a_step"] = result.most_exchanges_a_step;
    json["branches_redone"] = result.branches_redone;
    json["process_seconds"] = result.process_seconds;
    json["waiting_seconds"] = result.waiting_seconds;
    json["time_spent"] = result.time_spent;
    print_json("run", json);
    return;
  }
  const double worked = result.process_seconds - result.waiting_seconds;
  tty::print("{}\n", run_line(result, session.unit()));
  if (!session.quiet)
    tty::print(
        "took {}{}, estimated {}\n", clock_text(worked),
        result.waiting_seconds < 1.0 ? "" : fmt::format(" and {} of waiting", clock_text(result.waiting_seconds)),
        done.estimated);
}

// Before any device is opened; the run stores the same as events.
void warn_of_instruments(const RunRequest& request, analysis::PressureUnit unit) {
  refuse_placeholders(request.bench);
  const auto instruments = stated_instruments(request.bench, needs_press(request.recipes));
  for (const std::string& line : recipe_warnings(request.recipes, request.bench, unit))
    tty::print(stderr, "warning: {}\n", line);
  for (const std::string& line : calibration_warnings(request.bench, instruments, utc_now().substr(0, 10),
                                                      sequences::compile(request.recipes), unit))
    tty::print(stderr, "warning: {}\n", line);
}

// Warns of limits that cannot be judged on a run of loops, if the profile names limits.
void warn_of_limits(const RunOptions& options, const Session& session) {
  const auto limits = session.profile.values().find(ProfileKey::kLimits);
  if (limits == session.profile.values().end()) return;
  const std::string& file = limits->second.values.front();
  const std::vector<sequences::Recipe> recipes = read_recipes(options.recipes, split_overrides(options.set).recipe);
  const bool loops = std::ranges::any_of(recipes, [](const sequences::Recipe& recipe) {
    return recipe.kind == sequences::RecipeKind::kLevels && recipe.turning_points.size() > 2;
  });
  if (!loops) return;
  for (const std::string& why :
       not_judged(sequences::compile(recipes), {}, read_limits(find_config(file)), session.unit()).why)
    tty::print(stderr, "warning: judged by {}: {}\n", file, why);
}

CarriedOut begin_and_carry_out(const RunOptions& options, const Session& session) {
  check_operator(options.operator_name);
  const SplitOverrides overrides = split_overrides(options.set);
  RunRequest request;
  const std::vector<std::string> tags = metadata_tags(options.metadata);
  request.bench = read_bench(find_config(options.bench), overrides.bench, options.seeds);
  request.recipes = read_recipes(options.recipes, overrides.recipe);
  check_recipes(request.recipes, request.bench);
  warn_of_instruments(request, session.unit());
  refuse_tripped(request.bench);
  request.overrides = overrides.all;
  request.operator_name = options.operator_name;
  request.purpose = options.purpose;
  request.specimen_state_file = options.specimen_state;
  request.on_event = options.on_event;
  request.assume_yes = options.assume_yes;
  request.check_seating = !options.no_seating;
  request.label = options.label;
  request.pace = options.rate;
  if (!options.specimen_state.empty() && !request.bench.simulation) {
    throw Error("TB-USAGE", "--specimen-state is for a simulated bench", "--specimen-state",
                "leave it out: real film keeps its own state");
  }
  if (options.rate > 0.0 && !request.bench.simulation) {
    throw Error("TB-USAGE", "--rate is for a bench simulated in this process", "--rate",
                "leave it out: the pace of real instruments cannot be changed");
  }
  const BenchLock bench_lock(request.bench);
  request.bench_name = bench_lock.name();
  db::RunStore store = open_for_running(session.db, request.bench);
  if (options.page) start_background_page(session.db, request.bench.id, options.operator_name);
  request.on_begun = [&](std::int64_t run) {
    if (!tags.empty()) store.set_tags(run, tags, {});
    if (options.on_begun) options.on_begun(run);
  };
  return carry_out(request, store, options.sensor, session);
}

}  // namespace

std::string run_line(const RunResult& result, analysis::PressureUnit unit) {
  const double seconds = result.process_seconds;
  return fmt::format("run {}: {}, {} in {} of process time; {}", result.run, db::to_string(result.outcome),
                     analysis::counted(result.frames_kept, "frame"),
                     seconds < 100.0 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60.0),
                     result.safe_text.in(unit));
}

RunResult carry_out_run(const RunOptions& options, const Session& session) {
  return begin_and_carry_out(options, session).result;
}

void resume_run(std::int64_t number, const ResumeOptions& options, Session& session) {
  const db::RunRecord record = db::RunStore::open_read_only(session.db).run(number);
  const auto stored = stored_overrides(record.overrides_json);
  if (!stored)
    throw Error("TB-RESUME-SETTINGS", fmt::format("the settings (--set) stored with run {} cannot be read", number),
                session.db);
  std::vector<std::string> set;
  for (const sequences::Override& item : *stored) set.push_back(item.key + "=" + item.value);
  const SplitOverrides overrides = split_overrides(set);
  RunRequest request;
  SeedOptions seeds;
  if (record.origin == "simulated") {
    seeds = {static_cast<std::uint64_t>(record.seed), static_cast<std::uint64_t>(record.sensor_seed)};
  }
  const std::string name = fmt::format("bench file of run {}", number);
  request.bench = options.bench.empty() ? parse_bench(record.bench_toml, name, overrides.bench, seeds)
                                        : read_bench(find_config(options.bench), overrides.bench, seeds);
  if (request.bench.id != record.bench_id) {
    throw Error("TB-RESUME-BENCH",
                fmt::format("run {} belongs to bench '{}', not to '{}'", number, record.bench_id, request.bench.id),
                options.bench);
  }
  for (const db::SequenceRecord& sequence : record.sequences) {
    request.recipes.push_back(
        sequences::parse_recipe(sequences::TomlDocument::from_text(
                                    sequence.recipe_toml, fmt::format("recipe '{}' of run {}", sequence.name, number)),
                                overrides.recipe));
  }
  request.resume = number;
  warn_of_instruments(request, session.unit());
  request.on_event = options.on_event;
  request.assume_yes = options.assume_yes;
  const BenchLock bench_lock(request.bench);
  request.bench_name = bench_lock.name();
  db::RunStore store = open_for_running(session.db, request.bench);
  show_run_result(carry_out(request, store, record.sensor_serial, session), session);
}

void add_run(CLI::App& app, Session& session) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* verb = app.add_subcommand("run", "carry out recipes on a bench and store every frame");
  session.profile
      .add(*verb, "recipe", ProfileKey::kRecipe, options->recipes,
           "recipe files, or names of shipped ones (tactbench plan lists them)")
      ->required();
  verb->add_option("--sensor", options->sensor, "serial of a registered sensor (tactbench sensors add)")->required();
  session.profile.add_operator(*verb, options->operator_name);
  verb->add_option("--purpose", options->purpose, "why; recorded");
  add_metadata_options(*verb, options->metadata);
  verb->add_option("--set", options->set,
                   "override table.key=value of the bench file, or recipe.key=value; a pressure in the key's unit, or "
                   "with a unit: recipe.step=20kPa, limits.trip_psi=450kPa")
      ->take_all();
  verb->add_option("--seed", options->seeds.seed, "simulation: seed of noise and faults");
  verb->add_option("--sensor-seed", options->seeds.sensor_seed, "simulation: seed of the array");
  verb->add_option(
      "--specimen-state", options->specimen_state,
      "simulation: file with the film's memory, read if it exists and written at the end; without it a run "
      "starts from virgin film");
  verb->add_option("--on-event", options->on_event,
                   "shell command started when the run is done, has failed or waits for a person; TACTBENCH_EVENT, "
                   "TACTBENCH_RUN and TACTBENCH_REASON are in its environment");
  verb->add_flag("--yes", options->assume_yes, "answer operator prompts with yes");
  verb->add_flag("--no-seating", options->no_seating, "skip the seating check");
  verb->add_option("--rate", options->rate,
                   "simulation: limit of process seconds per real second, for people who watch (default: none)")
      ->check(CLI::Range(0.1, 1e6));
  verb->add_flag(
      "--page", options->page,
      "also start `tactbench page`: its address is printed; it ends when the run has ended and nobody views the page");
  for (const char* const name : {"--specimen-state", "--no-seating", "--purpose", "--on-event"})
    verb->get_option(name)->group(kRareOptions);
  verb->callback([options, &session] {
    options->bench = session.bench_file();
    warn_of_limits(*options, session);
    show_run_result(begin_and_carry_out(*options, session), session);
  });
}

}  // namespace tactbench::bench
