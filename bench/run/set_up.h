// What happens before the first step of a run: loads the simulated specimen's stored state, records the environment,
// checks the scanner's serial number, waits for the electronics to warm up, checks how the sensor is seated. At the
// end the specimen's state is stored.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/run/run_record.h"
#include "bench/run/sequencer.h"
#include "sequences/recipe.h"

namespace tactbench::db {
class RunReader;
}

namespace tactbench::bench {

class Rig;
class StatusBoard;

void record_environment(Rig& rig, Recorder& recorder);  // one event per sensor
// Throws Fault TB-SCANNER-SERIAL if the scanner is not the one registered with the sensor.
void check_scanner(const RunRequest& request, const std::string& serial);
// Warm-up by the first recipe's criterion, then seating; each stored as a check. Throws Error TB-SEATING and the
// exceptions of the sequencer; after Suspended it may be called again.
void prepare_sensor(Sequencer& sequencer, Recorder& recorder, const db::RunReader& store, const RunRequest& request,
                    const UnloadedFrame& baseline, StatusBoard& board);

// State of the simulated specimen between runs: the film's memory, kept in a file; and the object that presses on it.
// Both do nothing without a file, and on a rig that is not simulated in this process. Throw Error TB-SPECIMEN-STATE.
void load_specimen(Rig& rig, const std::string& file);  // reads the file if it exists
void save_specimen(Rig& rig, const std::string& file);

// Adds the recipe's object to the stage of a rig simulated in this process.
BenchConfig with_object(BenchConfig bench, const std::vector<sequences::Recipe>& recipes);

}  // namespace tactbench::bench
