// `calibrate`: from a serial number to a verdict. Registers the sensor, measures it twice, fits models on the first
// run, judges them on the second, and writes the report, with the same code as `sensors add`, `run`, `fit` and
// `report`.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/runs/runs.h"
#include "bench/cli/session.h"
#include "bench/config/config.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

struct CalibrateOptions {
  std::string serial, bench, operator_name, lab, on_event;
  std::string limits = "limits.toml", type = "sensor.toml", model;  // model: empty: the one that fit chooses
  std::vector<std::string> recipes = {"production"}, held_out_recipes = {"verification"};
  double minutes = 0.0;          // process time of both runs: selects the longest shipped form that fits; 0: the first
  std::vector<std::string> set;  // recipe.key=value; only for `recipes`
  std::int64_t run = 0, held_out = 0;  // completed runs of the sensor to continue from; 0: measured now
  MetadataOptions metadata;            // of both runs
  SeedOptions seeds;                   // the held-out run gets the following seed of noise
  bool assume_yes = false, no_seating = false;
};

// The command line that continues with these options from existing runs: "tactbench calibrate MY-1 --run 1". Options
// that the profile gives are left out. 0: no such run.
std::string resume_command_line(const CalibrateOptions& options, Session& session, std::int64_t run,
                                std::int64_t held_out);

// Sets session.code by the verdict. Throws, before any device is touched, when files, recipes or limits do not match
// (sequences::FileError, Error TB-CALIBRATE-LEVELS, TB-CALIBRATE-MINUTES, TB-USAGE, ...), later the errors of `run`,
// `fit` and `report`, with the command line to continue added to the remedy.
void calibrate(const CalibrateOptions& options, Session& session);

struct CalibrationResult {
  std::string sensor, origin, limits;  // limits: the name in the limits file
  bool registered = false;             // the sensor was new
  std::int64_t run = 0, held_out = 0;  // run: measured for the models; held_out: judged
  JudgedFit fit;                       // evaluations: first of the run itself, then of the held-out run
  analysis::Judgement judgement;       // as in the report
  std::string report_number, report_path;
  std::string drift;  // drift_text() of a sensor that was measured before; empty: not known
  analysis::PressureUnit unit = analysis::PressureUnit::kPsi;  // of the page; the document stays in psi
};

struct BadTaxel {
  int row = 0, column = 0;
  std::string why;  // "dead"; "mean |error| 3.40 psi, the largest"
};
// Taxels without a model, in the order of their numbers; then the worst taxel, if the requirement on it is not met.
std::vector<BadTaxel> bad_taxels(const JudgedFit& fit, const analysis::Judgement& judgement,
                                 analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// The output of `calibrate --json`: the verdict with its reason, and the bad taxels.
nlohmann::ordered_json calibration_json(const CalibrationResult& result);

}  // namespace tactbench::bench
