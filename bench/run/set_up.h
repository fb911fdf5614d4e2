// Checks before the first step: environment, scanner, seating of the sensor, warm-up of the electronics.
#pragma once

#include "bench/run/run_request.h"
#include "bench/run/sequencer.h"

namespace tactbench::db {
class RunStore;
}

namespace tactbench::bench {

class StatusBoard;

void record_environment(Rig& rig, Recorder& recorder);  // one event per sensor
// Throws Fault TB-SCANNER-SERIAL when the scanner is not the one that the sensor is registered with.
void check_scanner(const RunRequest& request, const std::string& serial);
// Warm-up by the first recipe's criterion, then seating; each a stored check. Throws Error TB-SEATING and what the
// sequencer throws; after Suspended it may be called again.
void prepare_sensor(Sequencer& sequencer, Recorder& recorder, const db::RunStore& store, const RunRequest& request,
                    const Baseline& baseline, StatusBoard& board);

}  // namespace tactbench::bench
