#include "bench/run/control/run_state.h"

#include <algorithm>
#include <array>
#include <vector>

namespace tactbench::bench {

namespace {

using S = RunState;

struct Row {
  RunState state;
  const char* word;
  std::vector<RunState> next;
};

// A run that fails before its first step still goes through stopping: the safe state is proved on every way out.
const std::array<Row, 7>& table() {
  static const std::array<Row, 7> rows = {{
      {S::kPrepared, "prepared", {S::kRunning, S::kStopping}},
      {S::kRunning, "running", {S::kPausing, S::kSuspended, S::kStopping}},
      {S::kPausing, "pausing", {S::kPaused, S::kRunning, S::kSuspended, S::kStopping}},
      {S::kPaused, "paused", {S::kRunning, S::kStopping}},
      {S::kSuspended, "suspended", {S::kRunning, S::kPaused, S::kStopping}},
      {S::kStopping, "stopping", {S::kEnded}},
      {S::kEnded, "ended", {}},
  }};
  return rows;
}

const Row& row_of(RunState state) { return table()[static_cast<std::size_t>(state)]; }

}  // namespace

const char* to_string(RunState state) { return row_of(state).word; }

bool may_follow(RunState from, RunState to) {
  const std::vector<RunState>& next = row_of(from).next;
  return std::find(next.begin(), next.end(), to) != next.end();
}

}  // namespace tactbench::bench
