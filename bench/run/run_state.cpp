#include "bench/run/run_state.h"

#include <array>

namespace tactbench::bench {

namespace {

struct Row {
  RunState state;
  const char* word;
  std::array<RunState, 2> next;  // repeated where there is only one
};

// A run that fails before its first step still goes through stopping: the safe state is proved on every way out.
constexpr std::array<Row, 4> kTable = {{
    {RunState::kPrepared, "prepared", {RunState::kRunning, RunState::kStopping}},
    {RunState::kRunning, "running", {RunState::kStopping, RunState::kStopping}},
    {RunState::kStopping, "stopping", {RunState::kEnded, RunState::kEnded}},
    {RunState::kEnded, "ended", {RunState::kEnded, RunState::kEnded}},
}};

const Row& row_of(RunState state) { return kTable[static_cast<std::size_t>(state)]; }

}  // namespace

const char* to_string(RunState state) { return row_of(state).word; }

bool may_follow(RunState from, RunState to) {
  const Row& row = row_of(from);
  return from != RunState::kEnded && (row.next[0] == to || row.next[1] == to);
}

}  // namespace tactbench::bench
