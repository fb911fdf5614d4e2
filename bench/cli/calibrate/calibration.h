// `calibrate`: from a serial number to a verdict. Registers the sensor, measures it twice, fits models on the first
// run, judges them on the second, and writes the report, with the same code as `sensors add`, `run`, `fit` and
// `report`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cli/runs/metadata_options.h"
#include "bench/cli/session.h"
#include "bench/config/config.h"

namespace tactbench::bench {

struct CalibrateOptions {
  std::string serial, bench, operator_name, lab, on_event;
  std::string limits = "limits.toml", type = "sensor.toml", model;  // model: empty: as fit chooses
  std::vector<std::string> recipes = {"production"}, held_out_recipes = {"verification"};
  double minutes = 0.0;                // of process time, both runs: the longest shipped form that fits; 0: the first
  std::vector<std::string> set;        // recipe.key=value: of `recipes` alone
  std::int64_t run = 0, held_out = 0;  // completed runs of the sensor to continue from; 0: measured now
  MetadataOptions metadata;            // of both runs
  SeedOptions seeds;                   // the held-out run gets the following seed of noise
  bool assume_yes = false, no_seating = false;
};

// The command line that continues with these options from existing runs: "tactbench calibrate MY-1 --run 1". Options
// that the profile gives are left out. 0: no such run.
std::string calibrate_again(const CalibrateOptions& options, Session& session, std::int64_t run, std::int64_t held_out);

// Recipes for the models and for the held-out run, one pair per form; `minutes` chooses among these forms. Longest
// first.
struct CalibrationForm {
  std::vector<std::string> recipes, held_out_recipes;
};
const std::vector<CalibrationForm>& calibration_forms();

// Sets session.code by the verdict. Throws before anything is touched where files, recipes or limits do not go together
// (sequences::FileError, Error TB-CALIBRATE-LEVELS, TB-CALIBRATE-MINUTES, TB-USAGE, ...), later what `run`, `fit` and
// `report` throw, with the command line to continue added to the remedy.
void calibrate(const CalibrateOptions& options, Session& session);

}  // namespace tactbench::bench
