// What happened during a run, read from the store for its report: repeated attempts at a branch, branches declared
// void, flags, pauses, environment.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "analysis/dataset.h"

namespace tactbench::analysis {

struct RunLogEvent {
  double time_s = 0.0;  // process time since the run's start
  std::string kind;     // attempt | branch-broken | pause | suspension | warning | fault | prompt | word | note
  std::string text;
};

struct VoidBranch {
  std::string sequence;
  int repeat = 0, branch = 0, attempt = 0;  // from 0
  std::string reason;
};

struct EnvironmentRange {
  std::string quantity;  // "temperature_c", "supply_bar"
  double low = 0.0, high = 0.0;
  int readings = 0;
};

struct RunLog {
  bool loaded = false;   // the log was read
  bool presses = false;  // frames were taken under an indenter, not in the chamber
  std::vector<RunLogEvent> events;
  std::vector<VoidBranch> voids;
  std::map<std::string, int> flags;              // flag -> number of valid frames with it
  int frames = 0, flagged = 0, void_frames = 0;  // valid frames; valid frames with a flag; frames in void branches
  std::vector<EnvironmentRange> surroundings;
  std::vector<db::CheckRecord> checks;  // seating, warm-up, conditioning, mount, tare
  std::string time_spent;               // as text, stored at the end of the run
  // Response of each taxel (loaded - unloaded), volts, in the newest seating check, and in the sensor's last passed
  // seating before this run; empty if there is none.
  std::vector<double> seating_v, earlier_seating_v;
  std::int64_t earlier_seating_run = 0;
};

// Reads only the run: the sensor's earlier seating is left empty.
RunLog load_run_log(const StoredRun& run);
// Fills in earlier_seating_v and earlier_seating_run of `history`. Throws StoreError.
void add_earlier_seating(RunLog& history, const db::RunReader& store, const db::RunRecord& run);

}  // namespace tactbench::analysis
