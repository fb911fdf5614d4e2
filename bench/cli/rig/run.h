// Executes a new run, or resumes a stored one; shared by `run`, `resume` and `devices test`.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/cli/runs/runs.h"
#include "bench/config/config.h"
#include "bench/run/run_record.h"

namespace tactbench::bench {

struct Session;

struct RunOptions {
  std::vector<std::string> recipes, set;
  std::string bench, sensor, operator_name, purpose, specimen_state, on_event;
  bool assume_yes = false, no_seating = false, page = false;
  double rate =
      0.0;  // for a bench simulated in this process: at most so many process seconds per real second; 0: no limit
  SeedOptions seeds;
  MetadataOptions metadata;
  std::string label = "run";                   // of the progress line
  std::function<void(std::int64_t)> on_begun;  // called with the run's number once the store has it; may be empty
};

// Carries out a new run. Throws Error when it did not complete or was refused before it began.
RunResult carry_out_run(const RunOptions& options, const Session& session);
// "run 1: completed, 303 frames in 12 min of process time; vented, verified (...)".
std::string run_line(const RunResult& result, analysis::PressureUnit unit);

struct ResumeOptions {
  std::string bench;     // bench file; empty: as stored with the run
  std::string on_event;  // command; empty: none
  bool assume_yes = false;
};

// Reopens run `number` of session.db and completes it; prints as `run` does. Throws Error and the errors of a run.
void resume_run(std::int64_t number, const ResumeOptions& options, Session& session);

}  // namespace tactbench::bench
