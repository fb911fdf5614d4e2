// What `run`, `resume` and `rig check` share: a run carried out, or one of the store opened again.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/run/run_request.h"

namespace tactbench::bench {

struct Session;

struct RunOptions {
  std::vector<std::string> recipes, set;
  std::string bench, sensor, operator_name, purpose, specimen_state, on_event;
  bool assume_yes = false, no_seating = false;
  SeedOptions seeds;
};

// A new run, to its end. Throws Error when it did not complete, and what is refused before it begins.
RunResult carry_out_run(const RunOptions& options, const Session& session);

struct ResumeOptions {
  std::string bench;     // bench file; empty: as stored with the run
  std::string on_event;  // command; empty: none
  bool assume_yes = false;
};

// Opens run `number` of session.db again and carries it to its end; prints as `run` does. Throws Error and what a run
// throws.
void resume_run(std::int64_t number, const ResumeOptions& options, Session& session);

}  // namespace tactbench::bench
