// Stored run -> frames taken while an object is pressed, each with its force reading.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/statistics/studies/studies.h"

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

}  // namespace tactbench::analysis
