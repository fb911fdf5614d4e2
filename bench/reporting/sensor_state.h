// State of a sensor according to a store: its runs, its valid verdict, until when that is valid, and whether the sensor
// drifted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/laboratory.h"
#include "analysis/statistics/sensor/drift.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

// A run checked with models of an earlier one, as `model check` does.
struct SensorDrift {
  std::int64_t run = 0, model_run = 0;
  std::string
      since_utc;  // start of the first run from which on all runs were outside the tolerance; empty: not drifted
  analysis::Drift drift;
  std::vector<std::string> outside;  // conditions of the run outside the models' validity, such as its temperature
};

struct SensorState {
  std::vector<db::RunRecord> runs;  // runs that are not void, oldest first; without sequences
  std::optional<Standing> verdict;  // the newest valid verdict
  std::int64_t judged_run = 0;      // run of that verdict
  std::string valid_until;          // by the laboratory's rule, counted from that run; empty: not known
  std::optional<SensorDrift> drift;
};

// The current fit of the newest run before `run` that has models which were not judged on `run`; else of the newest
// that has any. `runs`: of a sensor, oldest first.
std::optional<db::FitRecord> earlier_models(const db::Models& store, const std::vector<db::RunRecord>& runs,
                                            const db::RunRecord& run);

// `drift`: of the newest run on which earlier models can be checked. Models judged on that run belong to the same
// calibration, so older models are preferred: the drift describes the sensor as found.
SensorState sensor_state(const db::RunStore& store, const std::string& serial, const analysis::Laboratory& laboratory);

// "yes, since 2026-11-30: off by 0.75 % of full scale (tolerance 0.50); zero +0.25 ± 0.05 %, gain -0.8 ± 0.1 %, ...;
// the gain moved: gain adjustment enough (tactbench model adjust 1 8 --gain -o adjusted.json)".
std::string drift_text(const SensorState& state);
// "+0.13 ± 0.29": a share of 1 or of full scale, with U, in %.
std::string signed_percent(double share, double expanded);

}  // namespace tactbench::bench
