// How a sensor behaves before any compensation: loops of single taxels, hysteresis error (paper 2.1), equilibration,
// repeatability, zero return, creep. Datasets in, figures for the report out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/loop.h"

namespace tactbench::analysis {

// External loop of one taxel, or of the mean of those that count.
struct RawLoop {
  std::string name;                                    // mean | best | median | worst
  int taxel = -1;                                      // -1: the mean
  double full_scale_v = 0.0;                           // highest output of a level, mean of the sweeps
  double hysteresis_max = 0.0, hysteresis_mean = 0.0;  // |up - down| over the levels, shares of its own full scale
  std::vector<double> up_v, down_v;
};

struct RawTrace {  // the mean of the taxels that count along one sequence, mean of its repeats
  std::string sequence;
  std::vector<double> pressure_psi, output_v;
};

// Standard deviation (n - 1) over the repeats at one level, in volt: of the mean taxel, and root mean square over
// taxels.
struct LevelRepeatability {
  double pressure_psi = 0.0;
  double mean_up_v = 0.0, mean_down_v = 0.0, taxel_up_v = 0.0, taxel_down_v = 0.0;
};

// Output at a repeat's lowest pressure after minus before, mean of the repeats.
struct ZeroReturn {
  std::string sequence;
  int repeats = 0;
  double mean_v = 0.0;     // of the mean taxel
  double largest_v = 0.0;  // of one repeat, the mean taxel, by amount
  double worst_taxel_v = 0.0;
  int worst_taxel = -1;
};

// Output of the mean taxel at a held level: V = a + b log10(t / 1 s), least squares.
struct Creep {
  std::int64_t run = 0;
  std::string sequence;
  double pressure_psi = 0.0, from_s = 0.0, to_s = 0.0;  // since the level was commanded
  double first_v = 0.0, last_v = 0.0;
  double per_decade = 0.0,
         per_decade_u = 0.0;  // share of first_v, with its standard uncertainty (residuals independent)
  int samples = 0;
  bool up = true;  // the level was reached from below
};

struct Behaviour {
  std::vector<int> taxels;           // those that count
  std::vector<double> pressure_psi;  // levels of the external loop; empty: the run has none
  double full_scale_v = 0.0;         // highest output of the mean loop
  std::vector<RawLoop> loops;        // mean, best, median, worst by mean hysteresis error; empty without a loop
  std::vector<double> hysteresis_max, hysteresis_mean;  // all taxels, NaN where they do not count
  std::vector<RawTrace> traces;
  double equilibration_psi = 0.0;  // the level next to 2/3 of the range, on the way up
  std::vector<double> gain;        // all taxels: output there over the mean of those that count; NaN as above
  std::vector<LevelRepeatability> repeatability;  // empty with a single repeat
  int repeats = 0;                                // of those loops
  std::vector<ZeroReturn> zero_returns;
  std::vector<Creep> creep;
};

// `taxels`: those that count, not empty. A run without a full sweep up and down gives only the results that need none.
Behaviour behaviour_of(const Dataset& dataset, const std::vector<int>& taxels);

// Holds of at least 20 frames at one set-point above 0.5 psi, commanded once. Part of the above; also for other runs.
std::vector<Creep> creep_of(const Dataset& dataset, const std::vector<int>& taxels);

// The external loop over the sequences that have the repeats asked for; none where no sequence sweeps the full range.
std::optional<ExternalLoop> loop_of(const Dataset& dataset, const RepeatOptions& options = {});

}  // namespace tactbench::analysis
