// Runs of simulated sensors for studies that know the truth: a recipe carried out on the whole simulated rig.
#pragma once

#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "bench/config/plant_options.h"
#include "bench/run/run_record.h"
#include "db/run_store.h"

namespace tactbench::bench {

struct SimulatedSensor {
  SpecimenKind kind = SpecimenKind::kPaper;
  unsigned seed = 1;  // makes the array
};

struct SimulatedRun {
  std::vector<std::string> recipes;  // files, or names of shipped ones
  std::vector<std::string> set;      // KEY=VALUE, of bench file and recipes
};

// Without a check of the seating; the array is as large as the scanner that `run` sets.
RunRequest simulated_request(const SimulatedRun& run, const SimulatedSensor& sensor, unsigned noise_seed);
// The frames of `descending` alone, without conditioning.
RunRequest descending_request(int repeats, unsigned noise_seed);
// Registers the sensor where it is new. Throws what carrying out a run throws.
RunResult carry_out(const RunRequest& request, db::RunStore& store);

struct KnownRun {
  analysis::Dataset data;
  std::vector<double> chamber_psi;  // the plant's pressure at the end of each frame, in time order
  double process_s = 0.0;           // from opening the rig to the safe state
};

// `noise_seed`: of this run. Stores the run in `store`. Throws what carrying out a run throws, and std::runtime_error
// when a frame was taken again, whose pressures would then be another frame's.
KnownRun simulate_run(const SimulatedRun& run, const SimulatedSensor& sensor, unsigned noise_seed, db::RunStore& store);

}  // namespace tactbench::bench
