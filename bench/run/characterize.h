// One run from request to closed row: checks before any device is touched, the row before the first device is opened,
// setup, steps, and a way out that always proves the safe state and says why the run ended.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/config.h"
#include "bench/error.h"
#include "bench/run/progress.h"
#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

struct RunRequest {
  BenchConfig bench;
  db::SensorRecord sensor;  // as registered
  SensorType sensor_type;
  std::vector<sequences::Recipe> recipes;  // at least one
  std::string operator_name, purpose;
  std::vector<sequences::Override> overrides;  // as given, stored
  std::string specimen_state_file;             // simulation: read at the start if it exists, written at the end
  std::string label = "run";                   // of the progress line
};

struct RunResult {
  std::int64_t run = 0;
  db::Outcome outcome = db::Outcome::kIncomplete;
  db::SafeState safe = db::SafeState::kUnknown;
  std::string safe_text;
  int frames = 0;
  int most_exchanges_a_step = 0;
  double process_seconds = 0.0;
  std::string content_sha256;
  std::optional<Error> error;  // why it did not complete; carries the exit code and the rig's state
};

// Throws only what happens before the run row exists (FileError, StoreError, Error with ExitCode::kUsage).
RunResult characterize(const RunRequest& request, db::RunStore& store, Progress& progress);

// Refuses a recipe that goes beyond the command limit, before anything is touched. Throws Error TB-RECIPE-LIMIT.
void check_limits(const std::vector<sequences::Recipe>& recipes, const SafetyLimits& limits);

// 2026-01-31T12:00:00Z
std::string utc_now();

}  // namespace tactbench::bench
