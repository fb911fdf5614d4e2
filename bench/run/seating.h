// Seating check of a run: loads the array lightly, evaluates the seating (analysis) and stores the result.
#pragma once

#include "bench/run/run_record.h"
#include "bench/run/sequencer.h"

namespace tactbench::db {
class RunStore;
}

namespace tactbench::bench {

class StatusBoard;

// About half a minute at 8 psi or the recipes' highest level, if that is lower, then vented. The result is compared
// with the sensor's last passed seating, else with its last seating marked as a warning. Stores a check "seating"; its
// data are the unloaded and then the loaded mean counts, rows x columns each. Skipped, with an event, if the request or
// the recipes use no pressure. Warnings go to `board`. Throws Error TB-SEATING and the exceptions of the sequencer.
void check_seat(Sequencer& sequencer, Recorder& recorder, const db::RunStore& store, const RunRequest& request,
                const UnloadedFrame& unloaded, StatusBoard& board);

}  // namespace tactbench::bench
