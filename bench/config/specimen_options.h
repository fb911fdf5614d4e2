// Parameters of the simulated sensor: seeds, mount, effects of known size, defects.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactbench::bench {

// Which film the simulated sensor has: the paper's, one that is harder on every model and every compensation, or a foam
// of other physics (bench/simulation/README.md). The words stand in the order of the values.
enum class SpecimenKind { kPaper, kHarsh, kFoam };
std::vector<std::string> specimen_words();
std::string word_of(SpecimenKind kind);

// Switchable effects with known truth; all off (zero, empty) unless said.
struct SpecimenEffects {
  double row_crosstalk = 0.0;  // share of the other taxels' mean output in the same row added to a taxel
  double column_crosstalk = 0.0;
  double temperature_coefficient = -0.002;  // relative output change per kelvin away from 23 degrees Celsius
  double lift_off_psi = 0.3;                // mean pressure below which the membrane does not touch; per taxel spread
  double chamber_nonuniformity = 0.0;       // relative pressure difference from the array's centre to a corner, growing
                                            // with the square of the distance
  // A tilt of the chamber's pressure: relative difference over the array's longer side, the mean over the array
  // unchanged. It rises toward chamber_tilt_deg: 0 the chamber's last column, 90 its row 0, counter-clockwise.
  double chamber_tilt = 0.0;
  double chamber_tilt_deg = 0.0;
  double zero_drift_v_per_month = 0.0;  // the same for all taxels
  double gain_drift_per_month = 0.0;    // relative; sign and size differ by taxel, this is the standard deviation
  double gain_drift_per_thousand_cycles = 0.0;  // relative, the same for all; a cycle is 60 psi of loading
  double remount_variation = 0.0;  // standard deviation of a taxel's relative change of local pressure by mount
};

struct TaxelDefect {
  // kDead reads 0 V, kStuck one voltage between 0.5 and 2.5 V for ever, kSaturated the converter's 5 V, kNoisy has
  // 50 mV of extra noise, kSwapped changes places with another taxel in the wiring.
  enum class Kind { kDead, kStuck, kSaturated, kNoisy, kSwapped };
  Kind kind = Kind::kDead;
  int row = 0;
  int column = 0;
  int other_row = 0;  // kSwapped: with whom
  int other_column = 0;
};

// Orientation of the sensor under its wiring: the scanner's rows and columns relative to the film's. Only the first
// four are possible for an array that is not square.
enum class MountTurn { kNone, kBy180, kRowsMirrored, kColumnsMirrored, kBy90, kBy270, kTransposed, kAntiTransposed };
std::vector<std::string> mount_turn_words(bool square);

// Lines at one edge that lie outside the membrane: their share of the pressure falls off line by line.
enum class MountEdge { kFirstRow, kLastRow, kFirstColumn, kLastColumn };
std::vector<std::string> mount_edge_words();

struct SpecimenOptions {
  SpecimenKind kind = SpecimenKind::kPaper;
  std::uint64_t sensor_seed = 1;  // makes the array
  std::uint64_t seed = 1;         // harsh: what differs from run to run; a plant gives its own seed
  std::uint64_t mount_seed = 0;   // 0: the mount of the first characterization
  MountTurn mount_turn = MountTurn::kNone;
  // The sensor turned in the chamber with its leads, counter-clockwise with row 0 on top: each taxel keeps its row and
  // column and comes to another place. mount_turn is the film turned under leads that stay: the scanner's rows and
  // columns are then the chamber's.
  double turned_in_chamber_deg = 0.0;
  MountEdge edge_outside = MountEdge::kLastRow;
  int edge_outside_lines = 0;  // 0: all of the array lies inside
  double temperature_c = 23.0;
  double age_months = 0.0;  // since the first characterization
  int rows = 16;
  int columns = 16;
  SpecimenEffects effects;
  std::vector<TaxelDefect> defects;
};

}  // namespace tactbench::bench
