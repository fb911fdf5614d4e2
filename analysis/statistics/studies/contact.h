// Frames taken while an object is pressed, each with its force reading: total force, centre of pressure, moments and
// area of the contact, raw and compensated, against the force sensor (paper, Tables 8 and 9).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/statistics/studies/studies.h"
#include "analysis/statistics/uncertainty/instruments.h"

namespace tactbench::analysis {

struct PressFrame {
  double time_s = 0.0;  // process time since the run's start
  int repeat = 0;
  int position = 0;                  // place of the stage, counted within the repeat
  bool rising = true;                // force on its way up, the peak included
  double target_n = 0.0;             // the level
  double force_n = 0.0;              // measured at frame time, pressing is positive
  std::array<double, 6> wrench{};    // Fx Fy Fz N, Tx Ty Tz N mm, in the force sensor's frame
  std::array<double, 3> place_mm{};  // x, y, z of the stage
  std::vector<double> volts;         // taxels, mean of the K scans
};

// How the array lies under the stage: stage = scale x R(angle) x F x taxel + offset, F the identity or the mirror
// (x, -y); taxel in mm from the centre of taxel (0, 0), x along the columns, y along the rows.
struct MountTransform {
  std::int64_t run = 0;  // where it was measured
  double angle_deg = 0.0, scale = 1.0;
  std::array<double, 2> offset_mm{};
  bool flipped = false;
  [[nodiscard]] std::array<double, 2> taxel_mm(double stage_x_mm, double stage_y_mm) const;
};

struct PressRun {
  std::int64_t run = 0;
  std::string sequence;  // the recipe's name
  std::string object;    // what presses: ring, point, flat, ...; empty: not stated
  std::string origin, sensor_serial, scanner_serial;
  int rows = 0, columns = 0;
  std::vector<PressFrame> frames;     // in time order
  std::vector<MountTransform> mount;  // one, or none
};

// The press sequences of a run that has any, void branches left out; none for other runs. `object` is left empty.
// Throws AnalysisError as load_dataset() does.
std::vector<PressRun> load_press_runs(const StoredRun& run);
// The registration stored with a run, if there is one.
std::vector<MountTransform> mount_of(const StoredRun& run);

// Of a point indenter, for the crosstalk study.
std::vector<PointFrame> point_frames(const PressRun& run);

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
