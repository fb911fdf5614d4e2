// Studies from further runs of a sensor on its bench: uniformity of the chamber's pressure, effect of re-mounting,
// crosstalk to unloaded taxels, effects of rate and hold. Plain results: the report prints them, the uncertainty budget
// uses uniformity and mounting. A study without runs states why it was not assessed.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/scoring/score.h"

namespace tactbench::analysis {

// Chamber and sensor kept apart by turning the sensor in the chamber. Estimates of pressure less the level, in psi:
//   Y(angle, taxel) = m(angle) + sensor(taxel) + chamber(place of the taxel at that angle)
// by least squares, level by level. What is the same at all places that one taxel can come to (with four quarter turns:
// anything that a quarter turn does not change, such as a bowl about the centre) could be either's: it stays with the
// sensor, and `chamber` holds only the rest. Maps are row-major; the chamber's in the array's coordinates at 0 degrees.
struct Uniformity {
  std::string not_assessed = "no runs of this sensor turned in the chamber were given";  // empty: assessed
  std::vector<std::int64_t> runs;
  std::vector<int> angles_deg;        // of each run, counter-clockwise as seen on the array with row 0 on top
  std::vector<double> pressure_psi;   // levels that all runs have, above 0 and below the models' end
  std::vector<double> u_psi;          // of each level: standard deviation of the chamber's part over the array
  std::vector<double> residual_psi;   // of each level: standard deviation of what neither map explains
  std::vector<double> chamber_share;  // cells: slope of the chamber's part over pressure; NaN if no run shows it
  std::vector<double> chamber_psi;    // cells: its part that does not grow with pressure
  std::vector<double> sensor_share;   // taxels: the same of the sensor's part
  double u_share = 0.0;               // standard deviation of chamber_share: relative standard uncertainty
  double u_offset_psi = 0.0;          // of chamber_psi
  double residual_rms_psi = 0.0;      // over all levels
  // The residual with the angles taken clockwise. Clearly smaller: the angles were typed with the opposite sign.
  double residual_other_sense_psi = 0.0;
  double degrees = 0.0;  // of freedom of u_share and u_offset_psi: cells with a part of their own less free constants
  int undetermined = 0;  // free constants: sets of cells whose common part could be either's
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
};

// Mounts of one sensor. within: between the sweeps of one mount; between: of the mounts, what `within` explains taken
// off (one-way analysis of variance, not below 0). Standard deviations, root mean square over the taxels; shares:
// root mean square over the levels from a tenth of the highest on.
struct Remount {
  std::string not_assessed = "no runs of this sensor mounted anew were given";  // empty: assessed
  std::vector<std::int64_t> runs;                                               // one per mount, this report's first
  std::vector<double> pressure_psi;                                             // levels that all runs have, above 0
  std::vector<double> within_psi, between_psi;
  std::vector<double> mean_between_psi;      // the same of the array's mean alone: what all taxels have in common
  std::vector<double> taxel_between_psi;     // taxels: root mean square over the levels; NaN where not fitted
  double within_share = 0.0, s_share = 0.0;  // of within / p and between / p, see above
  // between / p in two: what all taxels have in common (mounts - 1 degrees of freedom), and a taxel's own.
  double common_share = 0.0, per_taxel_share = 0.0;
  int degrees = 0;            // of freedom: mounts - 1
  int per_taxel_degrees = 0;  // (mounts - 1)(taxels - 1)
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
};

// One press of a small object: outputs of the frame under it.
struct PointFrame {
  int position = 0;           // presses at one place share it
  bool rising = true;         // force on its way up
  double force_n = 0.0;       // measured
  std::vector<double> volts;  // taxels
};

// Outputs over each taxel's own baseline (the lower quartile of its outputs over all positions), as shares of the
// highest one of the frame; rising frames of the highest force. Taxels within `reach` pitches of the print's centre
// along rows and columns are loaded or touched by the object's edge and do not count.
struct CrosstalkZone {
  double mean_share = 0.0, u_share = 0.0;  // u: standard deviation of the mean, over the positions
  double max_share = 0.0;
  int samples = 0;
};
struct CrosstalkLine {
  int line = 0;
  double mean_share = 0.0;
};
struct Crosstalk {
  std::string not_assessed = "no run with a point indenter was given";  // empty: assessed
  std::int64_t run = 0;
  int positions = 0;
  double force_n = 0.0, reach_pitches = 2.0;
  CrosstalkZone row, column, elsewhere;  // in a loaded row, in a loaded column, in neither
  // Rows or columns whose unloaded taxels show more than elsewhere by ghost_share and by 3 standard deviations.
  std::vector<CrosstalkLine> ghost_rows, ghost_columns;
  std::vector<double> distance_pitches, along_row_share, along_column_share;  // mean share over distance
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
};
inline constexpr double kGhostShare = 0.005;

// Compensation errors of runs that go at several rates or hold their levels, |estimate - reference| in psi.
struct RateHoldRun {
  std::int64_t run = 0;
  std::string sequence;
  ErrorSum error;
  std::vector<Bin> by_hold, by_rate;  // seconds; psi a second: from frame to frame, 0 left out
  // Mean output of the fitted taxels against that of the slowest repeat, step by step; shares of full scale. 0 where
  // the repeats do not differ in pace.
  double output_max_share = 0.0, output_mean_share = 0.0;
};
struct RateHold {
  std::string not_assessed = "no run of the recipes rate, rate-ramp or creep-hold was given";  // empty: assessed
  std::vector<RateHoldRun> runs;
  [[nodiscard]] bool assessed() const { return not_assessed.empty(); }
};

struct Studies {
  Uniformity uniformity;
  Remount remount;
  Crosstalk crosstalk;
  RateHold rate_hold;
};

// A run of the sensor and how it lay in the chamber.
struct TurnedRun {
  std::int64_t run = 0;
  int angle_deg = 0;         // 0, 90, 180 or 270
  SweepEstimates estimates;  // by the models of one run, the same for all
};

// The place in the chamber, row x columns + column, of each taxel of an array turned counter-clockwise by the angle.
// Throws std::invalid_argument for another angle, or a quarter turn of an array that is not square.
std::vector<int> turned_places(int rows, int columns, int angle_deg);

// One map's decomposition. y[run][taxel], NaN where there is none; places[run][taxel]. `chamber` has mean 0 over each
// set of cells that belong together; NaN where no cell but itself does.
struct TurnedMaps {
  std::vector<double> sensor, chamber;
  double residual = 0.0;  // standard deviation, degrees of freedom taken off; NaN where there are none
  double degrees = 0.0;   // of freedom
  int undetermined = 0;
};
TurnedMaps separate_maps(std::span<const std::vector<double>> y, std::span<const std::vector<int>> places);

// At least two angles. Runs of one angle are taken for so many equations.
Uniformity uniformity_of(std::span<const TurnedRun> runs, int rows, int columns);

struct MountedRun {
  std::int64_t run = 0;
  SweepEstimates estimates;  // by the models of one run, the same for all
};
Remount remount_of(std::span<const MountedRun> mounts);

Crosstalk crosstalk_of(std::int64_t run, std::span<const PointFrame> frames, int rows, int columns);

// Compensates all frames in time order, as evaluate() does. Throws as evaluate().
std::vector<RateHoldRun> rate_hold_of(const Dataset& dataset, const SensorModel& fit, int threads = 0);

}  // namespace tactbench::analysis
