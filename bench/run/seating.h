// Seating check of a run: loads the array lightly, asks the analysis how the sensor sits, stores the answer.
#pragma once

#include "bench/run/run_request.h"
#include "bench/run/sequencer.h"

namespace tactbench::db {
class RunStore;
}

namespace tactbench::bench {

class Progress;

// About half a minute at 8 psi or the recipes' highest level, if that is lower, then vented; compared with the sensor's
// last seating that passed, else with its last one with a warning. Stores a check "seating"; its data are the unloaded
// and then the loaded mean counts, rows x columns each. Left out, with an event that says so, where the request or the
// recipes do not want pressure. Warnings are told to `progress`. Throws Error TB-SEATING and what the sequencer throws.
void check_seat(Sequencer& sequencer, Recorder& recorder, const db::RunStore& store, const RunRequest& request,
                const Baseline& unloaded, Progress& progress);

}  // namespace tactbench::bench
