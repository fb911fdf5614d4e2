// The sequencer's states in one table; each change is an event with time and reason. The outcome is kept apart.
#pragma once

#include <string>

namespace tactbench::bench {

enum class RunState {
  kPrepared,
  kRunning,
  kPausing,    // asked to pause: continues to the end of the branch
  kPaused,     // vented, waits for a person
  kSuspended,  // vented, waits for a condition (supply pressure, temperature)
  kStopping,   // teardown, safe state
  kEnded,
};

const char* to_string(RunState state);
// The table: which state may follow which.
[[nodiscard]] bool may_follow(RunState from, RunState to);

}  // namespace tactbench::bench
