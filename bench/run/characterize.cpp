#include "bench/run/characterize.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/rig.h"
#include "bench/run/sequencer.h"
#include "bench/safety/fail_safe.h"
#include "build_info.h"
#include "devices/fault.h"

namespace tactbench::bench {

using sequences::Recipe;

std::string utc_now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

void check_limits(const std::vector<Recipe>& recipes, const SafetyLimits& limits) {
  for (const Recipe& recipe : recipes) {
    std::vector<devices::Psi> levels = recipe.turning_points;
    if (recipe.conditioning_cycles > 0) levels.push_back(recipe.conditioning_peak);
    for (const devices::Psi level : levels) {
      if (level.value() <= limits.command_psi * (1.0 + 1e-12)) continue;
      throw Error(
          ExitCode::kUsage, "TB-RECIPE-LIMIT",
          fmt::format("recipe '{}' goes to {:.2f} psi ({:.1f} kPa), beyond the bench's command limit of {:.2f} psi",
                      recipe.name, level.value(), devices::kilopascals(level), limits.command_psi),
          fmt::format("recipe '{}', turning_points or conditioning.peak", recipe.name),
          "lower the recipe; the limit is [limits] command_psi in the bench file");
    }
  }
}

namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string time_zone() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  return local.tm_zone != nullptr ? local.tm_zone : "UTC";
}

db::RunRecord record_of(const RunRequest& request) {
  db::RunRecord record;
  record.uuid = db::new_uuid();
  record.origin = request.bench.origin == devices::Origin::kSimulated ? "simulated" : "hardware";
  record.state = to_string(RunState::kPrepared);
  record.operator_name = request.operator_name;
  record.purpose = request.purpose;
  record.sensor_serial = request.sensor.serial;
  record.scanner_serial = request.sensor.scanner_serial;
  record.bench_id = request.bench.id;
  record.bench_toml = request.bench.text;
  record.bench_sha256 = db::sha256_hex(request.bench.text);
  record.sensor_toml = request.sensor_type.text;
  record.sensor_sha256 = db::sha256_hex(request.sensor_type.text);
  nlohmann::ordered_json overrides = nlohmann::ordered_json::array();
  for (const auto& item : request.overrides) overrides.push_back({{"key", item.key}, {"value", item.value}});
  record.overrides_json = overrides.dump();
  record.program_version = TACTBENCH_VERSION;
  record.git_commit = TACTBENCH_COMMIT;
  record.git_dirty = TACTBENCH_DIRTY;
  record.build_id = TACTBENCH_BUILD;
  record.host = host_name();
  record.time_zone = time_zone();
  if (request.bench.simulation) {
    record.seed = static_cast<std::int64_t>(request.bench.simulation->plant.seed);
    record.sensor_seed = static_cast<std::int64_t>(request.bench.simulation->plant.specimen.sensor_seed);
  }
  record.started_utc = utc_now();
  for (std::size_t i = 0; i < request.recipes.size(); ++i) {
    const Recipe& recipe = request.recipes[i];
    int frames = 0;
    for (const auto& step : sequences::compile(recipe, static_cast<int>(i))) {
      frames += step.kind == sequences::StepKind::kMeasure && step.repeat == 0 ? 1 : 0;
    }
    record.sequences.push_back(
        {static_cast<int>(i), recipe.name, recipe.text, db::sha256_hex(recipe.text), recipe.repeats, frames});
  }
  return record;
}

void check_geometry(const RunRequest& request) {
  const devices::HidScannerOptions& scanner = request.bench.scanner;
  if (request.sensor_type.rows == scanner.rows && request.sensor_type.columns == scanner.columns) return;
  throw Error(ExitCode::kUsage, "TB-SENSOR-GEOMETRY",
              fmt::format("sensor type '{}' has {} x {} taxels, the bench's scanner {} x {}", request.sensor_type.name,
                          request.sensor_type.rows, request.sensor_type.columns, scanner.rows, scanner.columns),
              request.bench.file + " [scanner], sensor " + request.sensor.serial,
              "use the bench file of this sensor's scanner, or mend rows and columns");
}

void check_scanner(const RunRequest& request, const std::string& serial) {
  if (request.sensor.scanner_serial.empty() || serial == request.sensor.scanner_serial) return;
  throw devices::Fault("TB-SCANNER-SERIAL", "tactile scanner",
                       fmt::format("scanner '{}' answers, but sensor '{}' is registered with scanner '{}'", serial,
                                   request.sensor.serial, request.sensor.scanner_serial),
                       "connect the registered scanner, or register the pair as a sensor of its own: swapped read-out "
                       "electronics change the calibration");
}

void record_environment(Rig& rig, Recorder& recorder) {
  for (const EnvironmentReading& reading : rig.environment()) {
    recorder.event("environment", reading.quantity, fmt::format("{:.3f}", reading.value));
  }
}

void load_specimen(Rig& rig, const std::string& file) {
  if (file.empty() || rig.plant() == nullptr || !std::filesystem::exists(file)) return;
  std::ifstream stream(file);
  try {
    rig.plant()->set_specimen_state(std::string(std::istreambuf_iterator<char>(stream), {}));
  } catch (const std::exception& error) {
    throw Error(ExitCode::kUsage, "TB-SPECIMEN-STATE", fmt::format("not a specimen state: {}", error.what()), file,
                "give a file that --specimen-state wrote for this sensor seed, or a new name");
  }
}

void save_specimen(Rig& rig, const std::string& file) {
  if (file.empty() || rig.plant() == nullptr) return;
  std::ofstream stream(file);
  stream << rig.plant()->specimen_state();
  if (!stream.flush()) {
    throw Error(ExitCode::kUsage, "TB-SPECIMEN-STATE", "cannot write the specimen state", file,
                "check folder and space");
  }
}

db::Outcome outcome_of(const Error& error) {
  switch (error.code()) {
    case ExitCode::kInterrupted:
    case ExitCode::kTerminated:
      return db::Outcome::kStopped;
    case ExitCode::kStopped:
      return db::Outcome::kAborted;
    default:
      return db::Outcome::kFailed;
  }
}

// What ended the run, by whatever was thrown.
Error why_ended(std::int64_t run, int frames) {
  const std::string where = fmt::format("run {}, after frame {}", run, frames);
  try {
    throw;
  } catch (const Stopped& stopped) {
    const bool interrupt = stopped.signal == SIGINT;
    return {interrupt ? ExitCode::kInterrupted : ExitCode::kTerminated, "TB-RUN-STOPPED",
            fmt::format("stopped by {}", interrupt ? "Ctrl-C" : "a request to terminate"), where,
            "the frames so far are kept; start a new run to measure the rest"};
  } catch (...) {
    return as_error(std::current_exception(), where);
  }
}

}  // namespace

RunResult characterize(const RunRequest& request, db::RunStore& store, Progress& progress) {
  check_limits(request.recipes, request.bench.limits);
  check_geometry(request);
  const std::vector<sequences::Step> steps = sequences::compile(request.recipes);
  RunResult result;
  result.run = store.begin_run(record_of(request));
  const StopRequest stop;
  std::unique_ptr<Rig> rig;
  std::unique_ptr<Recorder> recorder;
  const devices::SteadyClock no_rig_clock;
  std::optional<Error> ended_by;
  Baseline baseline;
  try {
    rig = std::make_unique<Rig>(request.bench);
    recorder = std::make_unique<Recorder>(store, result.run, rig->clock());
    load_specimen(*rig, request.specimen_state_file);
    rig->open();
    store.set_devices(result.run, rig->devices());
    for (const std::string& layer : fail_safe_layers(request.bench)) recorder->event("fail-safe", "", layer);
    record_environment(*rig, *recorder);
    check_scanner(request, rig->array().identity().serial);
    Sequencer sequencer(*rig, *recorder, progress, stop);
    baseline = sequencer.read_baseline();
    recorder->state(RunState::kRunning, "devices open, chamber unloaded");
    sequencer.run(steps, request.label);
    record_environment(*rig, *recorder);
  } catch (...) {
    ended_by = why_ended(result.run, recorder ? recorder->frames() : 0);
  }
  progress.finish();
  // Teardown runs after any failure; each part is bounded and none stops the next.
  SafeProof proof{db::SafeState::kVerified, "no device was opened"};
  if (rig) {
    proof = make_safe(*rig, baseline);
    result.process_seconds = static_cast<double>(rig->clock().now().count()) * 1e-9;
  }
  try {
    if (rig && !ended_by) save_specimen(*rig, request.specimen_state_file);
  } catch (...) {
    ended_by = why_ended(result.run, recorder->frames());
  }
  if (!recorder) recorder = std::make_unique<Recorder>(store, result.run, no_rig_clock);
  result.frames = recorder->frames();
  result.most_exchanges_a_step = recorder->most_exchanges();
  result.safe = proof.state;
  result.safe_text = proof.text;
  if (!ended_by && proof.state != db::SafeState::kVerified) {
    ended_by = Error(ExitCode::kUnsafe, "TB-SAFE-UNVERIFIED", "the safe state could not be proved",
                     fmt::format("run {}", result.run), "look at the chamber's own gauge before touching the rig");
  }
  result.outcome = ended_by ? outcome_of(*ended_by) : db::Outcome::kCompleted;
  std::string reason = ended_by ? fmt::format("{}: {}", ended_by->id(), ended_by->what()) : "all steps done";
  try {
    if (rig && !rig->relay_operations().empty()) {
      recorder->event("relays", "",
                      fmt::format("closed {} times, row by row", fmt::join(rig->relay_operations(), " ")));
    }
    if (ended_by) recorder->event("fault", ended_by->id(), ended_by->what());
    recorder->state(RunState::kStopping, reason);
    recorder->event("safe", to_string(proof.state), proof.text);
    store.end_run(result.run, result.outcome, reason, proof.state, utc_now());
    result.content_sha256 = store.run(result.run).content_sha256;
  } catch (...) {  // the store itself failed: the row stays open and the next start marks it interrupted
    if (!ended_by) ended_by = why_ended(result.run, result.frames);
  }
  if (ended_by) {
    const std::string kept = fmt::format("{}; run {} kept with {} frames", proof.text, result.run, result.frames);
    const ExitCode code = proof.state == db::SafeState::kVerified ? ended_by->code() : ExitCode::kUnsafe;
    result.error = Error(code, ended_by->id(), ended_by->what(), ended_by->where(), ended_by->remedy(), kept);
  }
  return result;
}

}  // namespace tactbench::bench
