// Parameters of the simulated rig, set by the table [simulation] of a bench file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/config/planned_fault.h"

// Parameters of the simulated regulator and chamber.

namespace tactbench::bench {

struct ChamberOptions {
  double low_psi = 0.0, span_psi = 130.534;  // regulator, command and monitor: at 0 V and at 10 V
  double reference_span_psi = 100.0;         // reference transducer: psi for 10 V
  double time_constant_s = 0.12;             // chamber behind the valve, second order
  double damping = 0.75;                     // < 1 overshoots
  double slew_psi_per_s = 60.0;              // valve flow limit
  double resolution_v = 0.002;               // of the command as the regulator sees it
  double hysteresis_share = 0.002;    // of the regulator, as a share of its span (up to 0.005): its sensor lags, so the
                                      // true pressure is ahead of the measured one by half of it in each direction
  double leak_psi_per_s = 0.0;        // a defect: pressure lost while held; the regulator compensates it except for an
                                      // offset of 2 * damping * time constant * leak
  double dump_psi_per_s = 300.0;      // through the open dump valve, faster than the regulator can fill
  double reference_noise_psi = 0.01;  // transducer's noise, standard deviation
  double feedback_noise_psi = 0.02;
};

// Parameters of the simulated contact: an object under the z stage, the fabric, and how the sensor is mounted.
enum class Footprint { kRing, kPoint, kFlat };

struct ContactOptions {
  Footprint object = Footprint::kRing;
  double outer_diameter_mm = 15.0;  // of the ring
  double inner_diameter_mm = 10.0;
  double point_diameter_mm = 2.0;
  double surface_z_mm = 30.0;          // where the object touches the fabric
  double stiffness_n_per_mm = 20.0;    // of fabric, film and support, at first touch
  double stiffening_n_per_mm2 = 10.0;  // F = stiffness d + stiffening d^2
  double friction_share =
      0.04;  // hysteresis of the fabric: the force is higher by this share while loading, lower while unloading
  double relaxation_share = 0.06;  // share of the force lost at a held position: one half with each time constant
  double relaxation_s = 1.5;       // the slower time constant is ten times this
  double backlash_mm = 0.01;       // the tip does not move for this distance after z reverses
  double fabric_spread_mm = 0.6;   // standard deviation by which the fabric blurs the footprint
  double pitch_mm = 2.54;          // of the array
  double centre_x_mm = 30.0;       // stage position at which the object is over the array's centre
  double centre_y_mm = 30.0;
  double misplaced_x_mm = 0.0;  // true offset of the mounted sensor, which registration must find
  double misplaced_y_mm = 0.0;
  double misplaced_deg = 0.0;    // counter-clockwise
  double force_noise_n = 0.005;  // standard deviation, each axis
  double torque_noise_nmm = 0.02;
};

// Limits of the errors of the simulated reference, force sensor and thermometer: the values stated in the bench file;
// the errors are drawn within these limits.

// certificate_u: standard deviation of the error that remains after calibration; the others are half-widths.
struct DrawnLimits {
  double certificate_u = 0.0, drift = 0.0, input = 0.0;
};

struct InstrumentOptions {
  std::uint64_t seed = 0;  // determines the instruments of a bench; 0: they have no errors
  // Reference, psi. Certificate: standard deviations at increasing readings, linear in between; one value for all
  // readings, or none.
  std::vector<double> reading_psi, certificate_u_psi;
  DrawnLimits reference;  // certificate_u is not used
  double hysteresis_psi = 0.0, zero_psi = 0.0, temperature_psi = 0.0;
  DrawnLimits force_n;        // at full scale: an error that does not grow with the force is removed by taring
  DrawnLimits thermometer_c;  // the same at all temperatures
};

// Parameters of the simulated sensor: seeds, mount, effects of known size, defects.

// The film of the simulated sensor: the paper's, one that is harder for every model and compensation, or a foam with
// other physics (bench/simulation/README.md). The names are in the order of the values.
enum class SpecimenKind { kPaper, kHarsh, kFoam };
std::vector<std::string> specimen_kind_names();
std::string keyword_of(SpecimenKind kind);

// Effects of known size that can be switched on; off (zero, empty) unless a default is given.
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
  double gain_drift_per_thousand_cycles = 0.0;  // relative, the same for all taxels; a cycle is 60 psi of loading
  double remount_variation = 0.0;  // standard deviation of a taxel's relative change of local pressure by mount
};

struct TaxelDefect {
  // kDead reads 0 V, kStuck a constant voltage between 0.5 and 2.5 V, kSaturated the converter's 5 V, kNoisy has
  // 50 mV of extra noise, kSwapped changes places with another taxel in the wiring.
  enum class Kind { kDead, kStuck, kSaturated, kNoisy, kSwapped };
  Kind kind = Kind::kDead;
  int row = 0;
  int column = 0;
  int other_row = 0;  // kSwapped: the other taxel
  int other_column = 0;
};

// Orientation of the sensor under its wiring: the scanner's rows and columns relative to the film's. Only the first
// four are possible for an array that is not square.
enum class MountTurn { kNone, kBy180, kRowsMirrored, kColumnsMirrored, kBy90, kBy270, kTransposed, kAntiTransposed };
std::vector<std::string> mount_turn_names(bool square);

// Lines at one edge that lie outside the membrane: their share of the pressure falls off line by line.
enum class MountEdge { kFirstRow, kLastRow, kFirstColumn, kLastColumn };
std::vector<std::string> mount_edge_names();

struct SpecimenOptions {
  SpecimenKind kind = SpecimenKind::kPaper;
  std::uint64_t sensor_seed = 1;  // determines the array
  std::uint64_t seed = 1;         // harsh film: determines what differs from run to run; the plant gives its own seed
  std::uint64_t mount_seed = 0;   // 0: the mount of the first characterization
  MountTurn mount_turn = MountTurn::kNone;
  // The sensor turned in the chamber with its leads, counter-clockwise with row 0 on top: each taxel keeps its row and
  // column but moves to another place. With mount_turn the film is turned but the leads are not: the scanner's rows and
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

struct ScannerFrontEnd {
  double volts_per_count = 5.0 / 65535.0;  // 16 bit over 0-5 V
  double noise_v = 0.0015;                 // standard deviation per sample
  double relay_settle_s = 0.004;           // wait after a row's relay closes
  double relay_time_constant_s = 0.0006;   // the remainder of the previous row decays with this
};

struct PlantOptions {
  std::uint64_t seed = 1;  // noise
  ChamberOptions chamber;
  SpecimenOptions specimen;
  ScannerFrontEnd scanner;
  ContactOptions contact;
  InstrumentOptions instruments;
  std::vector<PlannedFault> faults;
  double supply_bar = 8.0;  // compressed air in front of the regulator
};

}  // namespace tactbench::bench
