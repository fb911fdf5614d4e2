// Aligned arrays from a stored run. Most analyses start from a Dataset: per sequence and repeat the measured
// pressures and the output voltages of all taxels, in step order, without void branches.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/error.h"
#include "db/run_store.h"

// All stored rows of one run, read together: the input for the Dataset, the presses, the event log and the rig's
// figures.

namespace tactbench::analysis {

struct StoredRun {
  db::RunRecord record;
  std::vector<db::FrameRecord> frames;  // in the order written, including those of void branches
  std::vector<db::BranchRecord> branches;
  std::vector<db::EventRecord> events;
  std::vector<db::CheckRecord> checks;
};

// `record`: the run's row, as RunReader::run() gives it. Throws StoreError.
StoredRun read_run(const db::RunReader& store, const db::RunRecord& record);

struct Sample {
  double setpoint_psi = 0.0;
  double reference_psi = 0.0;  // measured at frame time
  double time_s = 0.0;         // process time since the run's start
  double held_s = 0.0;         // since the set-point was commanded
};

// Time between two successive samples. Time that no command explains was conditioning over the whole range, ending at
// rest at the lowest pressure.
struct TimePassed {
  double worked_s = 0.0,
         step_s =
             0.0;  // worked_s: conditioning; step_s: since the set-point was commanded, or since the previous sample
};
// `before_s`: the time of the previous sample, negative for the first.
TimePassed time_passed(const Sample& sample, double before_s);

// One pass through a sequence's turning points.
struct Repeat {
  std::vector<Sample> steps;
  std::vector<double> volts;  // steps x taxels, row-major; mean of the K scans, outliers left out
};

struct SequenceData {
  std::string name;
  std::vector<Repeat> repeats;  // all of equal length
};

struct Dataset {
  std::int64_t run = 0;
  std::string origin, sensor_serial, scanner_serial;
  int rows = 0, columns = 0, scans = 1;  // scans: number averaged per sample, from the first frame
  std::vector<SequenceData> sequences;
  std::vector<double> noise_v;  // per taxel, standard deviation of one K-scan mean, from the K scans (0 if K = 1)
  std::vector<bool> at_limit;   // per taxel: at the converter's limit in more than one frame
  int outlying = 0;  // number of samples left out of the means because the other scans contradict them (db/record.h)
  std::vector<double> temperatures_c;  // ambient temperatures of the run; empty if the bench has no thermometer
  [[nodiscard]] int taxels() const { return rows * columns; }
};

// `volts_per_count` comes from the run's scanner calibration. Throws AnalysisError TB-ANALYSIS-EMPTY if no repeat is
// complete (with the number of missing frames); incomplete repeats are left out.
Dataset load_dataset(const StoredRun& run);
// For commands that need no other data of the run; others use Runs (report/gather.h).
Dataset load_dataset(const db::RunReader& store, std::int64_t run);

// Only Dataset::temperatures_c, also for a run without a complete repeat. Throws AnalysisError TB-ANALYSIS-FRAME.
std::vector<double> temperatures_of(const StoredRun& run);

}  // namespace tactbench::analysis
