// An array under an object: total force, centre of pressure, moments and area of the contact from its frames, raw and
// compensated, against the force sensor (paper, Tables 8 and 9).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/statistics/studies/press_run.h"
#include "analysis/statistics/uncertainty/instrument_uncertainty.h"

namespace tactbench::analysis {

struct ArrayGeometry {
  double pitch_mm = 2.54;
  double taxel_area_mm2 = 6.4516;  // effective area of one taxel
};
inline constexpr double kNewtonPerPsiMm2 = 0.006894757293168;

// Of one frame of pressures. Places in mm from the array's centre: x along the columns, y along the rows. A taxel is in
// contact at or above the threshold; the total force is that of all taxels, everything else of those in contact: what
// many unloaded taxels show by their zeros would pull the centre.
struct ContactFigures {
  double force_n = 0.0;           // sum of pressure x taxel area
  double x_mm = 0.0, y_mm = 0.0;  // centre of pressure; NaN without contact
  double moment_x_nmm = 0.0;      // sum of pressure x area x y, about the array's centre
  double moment_y_nmm = 0.0;      // sum of pressure x area x -x
  double area_mm2 = 0.0;          // taxels in contact x taxel area
  double threshold_psi = 0.0;     // 10 % of the frame's highest pressure, at least 0.5 psi
};
// Values that are not finite count as no pressure. Throws std::invalid_argument when there are not rows x columns.
ContactFigures contact_figures(std::span<const double> pressure_psi, int rows, int columns,
                               const ArrayGeometry& geometry);

// One level of force, one direction: means over the frames of all repeats and positions.
struct ContactLevel {
  double target_n = 0.0;
  bool rising = true;
  int frames = 0;
  double force_n = 0.0;     // of the force sensor
  double torque_nmm = 0.0;  // its sqrt(Tx^2 + Ty^2)
  ContactFigures raw, compensated;
  // |force of the array - force of the force sensor|, N.
  double raw_force_error_n = 0.0, compensated_force_error_n = 0.0;
  // Distance of the centre of pressure from the object's axis, which needs a registration; NaN without one.
  double raw_place_error_mm = 0.0, compensated_place_error_mm = 0.0;
  // Distance of the centre of pressure from its mean over all levels of its position: how much it wanders.
  double raw_wander_mm = 0.0, compensated_wander_mm = 0.0;
  double clamped_taxels = 0.0;  // mean number of taxels at the highest pressure of their model
  // Frames of the first position, means of the repeats: volts, psi (NaN where not fitted), and std over the taxels as a
  // share of full scale.
  std::vector<double> raw_v, compensated_psi;
  double raw_std = 0.0, compensated_std = 0.0;
};

struct ContactResult {
  std::int64_t run = 0, mount_run = 0;  // mount_run: whose registration was used; 0: none
  std::string sequence, object;
  std::string force_traceability;           // of the run's force sensor, in a sentence; filled in by the caller
  InstrumentUncertainty force_uncertainty;  // of the force that the errors are against; filled in by the caller
  int positions = 0, repeats = 0;
  ArrayGeometry geometry;
  double full_scale_v = 0.0, full_scale_psi = 0.0;  // of the chamber run that the models are from
  std::vector<ContactLevel> levels;                 // rising ones first, then falling ones from the peak down
  // Mean over the taxels of |up - down| at a level as shares of full scale, rising levels that have both; else NaN.
  std::vector<double> raw_distance, compensated_distance;
  // Over all frames: mean and maximum of the force errors, N.
  double raw_mean_error_n = 0.0, raw_max_error_n = 0.0, compensated_mean_error_n = 0.0, compensated_max_error_n = 0.0;
};

// Raw: every taxel read by one straight line through the ends of the mean taxel's external loop. Compensated: the
// taxel's own model, starting unloaded at each rise. Throws AnalysisError TB-ANALYSIS-OTHER-SENSOR,
// TB-ANALYSIS-ORIGIN when run and models do not belong together.
ContactResult contact_result(const PressRun& run, const SensorModel& fit, const ArrayGeometry& geometry);

}  // namespace tactbench::analysis
