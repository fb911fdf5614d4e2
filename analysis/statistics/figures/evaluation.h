// Figures of one run, raw and compensated: hysteresis error (paper 2.1), std/FS and up/down distance per level
// (Tables 6, 7), compensation error, verdicts' raw material. Shared by fit, report and tests. And those of them that
// the nightly suite, trends and control charts track from run to run.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Outputs and estimates are brought to the level's set-point before up and down are compared, outputs by local slope,
// estimates by 1 psi/psi x (set-point - measured reference): the regulator's own hysteresis is not the sensor's.
struct LevelFigures {
  double pressure_psi = 0.0;            // set-point of the level
  double up_psi = 0.0, down_psi = 0.0;  // measured reference, mean of the sweeps
  // Raw, shares of full scale (highest raw mean output in volts):
  double raw_std_up = 0.0, raw_std_down = 0.0, raw_distance = 0.0;  // distance: mean over taxels of |up - down|
  double raw_mean_distance = 0.0;                                   // |mean up - mean down|
  // Compensated, shares of the full pressure:
  double comp_std_up = 0.0, comp_std_down = 0.0, comp_distance = 0.0, comp_mean_distance = 0.0;
  double worst_taxel_distance = 0.0;      // compensated, worst taxel
  bool made_worse = false;                // comp_distance > raw_distance
  int flat_taxels = 0;                    // taxels whose estimate was flagged unobservable going down
  double comp_distance_observable = 0.0;  // comp_distance over the unflagged taxels only
  double worst_taxel_distance_observable = 0.0;
  std::vector<double> raw_up_v, raw_down_v, comp_up_psi, comp_down_psi;  // frames; comp: NaN where not fitted
};

struct Trace {  // the mean taxel along one sequence (Figs 11-14)
  std::string sequence;
  std::vector<double> pressure_psi, measured_v, model_v, compensated_psi;
};

struct Evaluation {
  std::int64_t run = 0;        // evaluated
  std::int64_t model_run = 0;  // whose models were used
  double full_scale_v = 0.0, full_scale_psi = 0.0;
  double hysteresis_max_fs = 0.0, hysteresis_mean_fs = 0.0;  // mean taxel, raw (paper: 0.253, 0.100)
  // Direct model against measured, mean taxel per sequence kind (Tables 4, 5) comes from the fit. Compensation error
  // |compensated - measured reference| in psi over all frames and fitted taxels, and without flat ones:
  double mean_error_psi = 0.0, max_error_psi = 0.0, mean_error_observable_psi = 0.0, max_error_observable_psi = 0.0;
  double worst_taxel_mean_error_psi = 0.0;
  int worst_taxel = -1;
  int max_error_taxel = -1;       // of max_error_psi; -1 where that is not known
  double max_error_at_psi = 0.0;  // the reference then
  // Averages of the 31 levels, shares of full scale:
  double raw_distance = 0.0;              // mean of raw_mean_distance (about 0.10)
  double comp_distance_of_mean = 0.0;     // the 256 pressures averaged, mean over levels of |up - down| / full pressure
  double comp_distance = 0.0;             // mean taxel of |up - down|, averaged over taxels and levels
  double comp_distance_observable = 0.0;  // the same without flagged (taxel, level) pairs
  double worst_taxel_distance = 0.0;      // worst taxel's mean over levels
  double worst_taxel_distance_observable = 0.0;
  double flat_share = 0.0;                   // flagged share of (taxel, level) pairs
  std::vector<LevelFigures> levels;          // every level of the external loop
  std::vector<double> taxel_mean_error_psi;  // taxels; NaN where not fitted
  std::vector<Trace> traces;
  int frames = 0;
};

// Compensates every stored frame of every repeat of `dataset` in time order with `fit` (made on the same or another
// run) and gathers the figures. Level figures average the full sweeps of all repeats; std is of the sample (n - 1).
// Throws AnalysisError TB-ANALYSIS-OTHER-SENSOR when sensor, scanner or geometry differ, TB-ANALYSIS-ORIGIN when
// origins mix.
Evaluation evaluate(const Dataset& dataset, const SensorModel& fit, int threads = 0);

// By name, with the unit in it. `evaluation` is what was judged; parameters are means over the fitted taxels. A figure
// that is not finite is left out.
std::map<std::string, double> figures_of(const SensorModel& fit, const Evaluation& evaluation);

}  // namespace tactbench::analysis
