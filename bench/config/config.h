// Text -> checked configuration: the bench file (rig and its limits), the sensor type file and the limits file. Units
// are in the keys; unknown keys are errors (sequences/toml/strict_toml.h).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "analysis/statistics/figures/limits.h"
#include "bench/config/plant_options.h"
#include "devices/device.h"
#include "devices/force/options.h"
#include "devices/pressure/module_profile.h"
#include "devices/pressure/options.h"
#include "devices/stage/options.h"
#include "devices/tactile/options.h"
#include "devices/wire/options.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

struct Settling {                // when a commanded level counts as reached
  double band_psi = 0.25;        // |feedback - set-point|
  double slope_psi_per_s = 0.5;  // |change of the reference| between two polls
  double poll_s = 0.2;           // between two readings while it settles
  double trace_s = 0.0;          // between two readings during a dwell; 0: whenever the module's watchdog is fed
  double landing_s = 0.5;        // rest before the last of several ticks
  double timeout_s = 20.0;
};

struct SafetyLimits {
  double command_psi = 60.0;  // inclusive
  double trip_psi = 66.0;     // measured, on either witness (feedback or reference)
  double safe_psi = 1.0;
  double disagreement_psi = 5.0;  // between feedback and reference, for longer than disagreement_s
  double disagreement_s = 1.0;
  double vent_timeout_s = 20.0;
  double rate_psi_per_s = 20.0;                   // rise of the set-point, sustained
  double step_psi = 2.5;                          // rise of the set-point, in one step
  double stale_s = 1.0;                           // upward commands are refused if a witness's reading is older
  std::array<double, 3> force_n{5.0, 5.0, 35.0};  // measured, per axis: a force beyond it is a trip
  double contact_n = 0.5;                         // from this force on the indenter is in contact
  double clear_z_mm = 25.0;                       // z may not be beyond this while x or y move
};

struct DeadManConfig {
  bool enabled = true;  // used if the instruments outlive the process: never on a bench simulated in the same process
  double timeout_s = 0.4;   // between two signs of life of the sequencer's process
  double progress_s = 1.5;  // between two steps of its work: more than the longest exchange that fails
  double back_off_mm = 5.0;
  bool blind_ends = true;                  // ends a run whose dead-man cannot reach the module; false: only reports it
  std::string program = "/proc/self/exe";  // the program that serves as the dead-man; tests set another
};

struct SimulationConfig {
  PlantOptions plant;
  std::string scanner_serial = "SIM-SCANNER-1";
  int frame_source_port = 0;  // 0: the system chooses
  devices::SimulatedModuleFaults module_faults;
  devices::SimulatedScannerFaults scanner_faults;
};

enum class RegulatorKind { kModule, kSerial };  // a row each in bench/pressure/pressure_kinds.cpp

struct StatedCalibration {  // an instrument's calibration as stated in the bench file; empty, 0: not stated
  std::string certificate, calibrated, due;  // dates as 2026-01-31
  double expanded_uncertainty = 0.0;         // U with k = 2 over the whole range, in psi, N, mm or K
  std::string
      covers;  // "chain": instrument and the input that reads it; "transducer": the instrument alone; empty: not stated
  double drift = 0.0;  // limit of its change until it is due, in the same unit; 0: not stated. As half-widths:
  double input_limit =
      0.0;  // limit of error of the input that reads it, in V, N or K; 0: included in the certificate, or not stated
};

struct ReferenceLimits {  // limits of the pressure transducer that its certificate does not cover; half-widths, 0: not
                          // stated
  double hysteresis_psi = 0.0, zero_psi = 0.0, temperature_psi = 0.0;
};

struct StageConfig : devices::StageOptions {
  StatedCalibration stated;  // of all three axes
};

struct ForceConfig : devices::ForceOptions {
  StatedCalibration stated;
};

struct ModuleConfig {
  devices::ModuleProfile profile;
  devices::ModbusEndpoint endpoint;
  bool same_line = false;  // as [module], another unit
  [[nodiscard]] bool present() const { return !profile.name.empty(); }
};

struct GaugeConfig {  // a digital gauge as reference
  devices::ModbusEndpoint endpoint;
  bool own_line = false;
  devices::ModbusQuantity quantity;  // psi
};

struct EnvironmentSensor {
  std::string quantity;  // temperature_c | supply_bar
  std::string model = "not stated", serial = "not stated";
  StatedCalibration stated;  // of a thermometer
  devices::ModbusEndpoint endpoint;
  bool own_line = false;
  devices::ModbusQuantity place;
};

struct BenchConfig {
  std::string id, location = "not stated";
  devices::Origin origin = devices::Origin::kHardware;
  SafetyLimits limits;
  DeadManConfig dead_man;
  Settling settling;
  RegulatorKind regulator_kind = RegulatorKind::kModule;
  ModuleConfig module;                       // drives the regulator, or reads the transducer of a serial one
  std::optional<ModuleConfig> input_module;  // reads feedback and transducer; none: `module` does
  double watchdog_s = 0.0;                   // 0: the module has none
  devices::RegulatorOptions regulator;
  devices::SerialControllerOptions controller;  // of a serial regulator, with its line
  devices::SerialAddress controller_address;
  devices::TransducerOptions reference;
  StatedCalibration reference_stated;  // the U of a correction has precedence
  ReferenceLimits reference_limits;
  double certificate_low_psi = 0.0,
         certificate_high_psi = 0.0;      // range of the reference's certificate; equal: not stated
  double reference_resolution_psi = 0.0;  // 0: the resolution of the converter that reads it
  bool reference_independent = true;
  std::optional<GaugeConfig> reference_gauge;  // none: the transducer of `reference`
  devices::PressureCorrection reference_correction;
  std::vector<EnvironmentSensor> environment;
  devices::ScannerOptions scanner;
  std::string scanner_cable;  // identifies the cable, which is part of the measuring chain like the scanner
  int scans_per_frame = 2;
  std::optional<StageConfig> stage;
  std::optional<ForceConfig> force;
  bool in_process = false;                     // simulated, with the simulated ends in this process
  double rate = 1.0;                           // of process time against real time; not 1 only with a simulator
  std::optional<SimulationConfig> simulation;  // exactly when in_process
  std::string file, text;                      // path and text of the bench file, stored with the run
  std::string resolved;                        // text with the overrides applied
  std::vector<sequences::Setting> settings;    // every value, and its source
};

// The pressure, psi, that the regulator sets at 0 V: the output of a module without power or after its watchdog has
// acted.
double zero_volt_psi(const BenchConfig& config);
bool zero_volt_vents(const BenchConfig& config);  // it is within safe_psi of 0 psi
// Whether the pressure source is on a serial line, which has one user at a time.
bool on_serial_line(const BenchConfig& config);

struct SensorType {
  std::string name;
  int rows = 0, columns = 0;
  double pitch_mm = 2.54, taxel_area_mm2 = 0.0;
  double orientation_deg = 0.0;  // angle of row 0 to the bench's x axis
  double output_low_v = 0.0, output_high_v = 5.0;
  std::string full_scale;  // "highest mean output of the run"
  std::string text;
};

struct SeedOptions {  // the command line has precedence over the file
  std::optional<std::uint64_t> seed, sensor_seed;
};

// Each throws sequences::FileError.
BenchConfig read_bench(const std::string& path, const std::vector<sequences::Override>& overrides,
                       const SeedOptions& seeds = {});
// The same from a text; `name` replaces the file name in error messages. Reads only the files that the text names.
BenchConfig parse_bench(const std::string& text, const std::string& name,
                        const std::vector<sequences::Override>& overrides, const SeedOptions& seeds = {});
SensorType read_sensor_type(const std::string& path, const std::vector<sequences::Override>& overrides = {});
SensorType parse_sensor_type(const std::string& text, const std::string& name);
analysis::Limits read_limits(const std::string& path);
analysis::Limits parse_limits(const std::string& text, const std::string& name);

// The keys of each of these files.
std::vector<sequences::KeyFacts> bench_keys();
std::vector<sequences::KeyFacts> sensor_type_keys();
std::vector<sequences::KeyFacts> limits_keys();

// Folder of the shipped recipes and configuration: $TACTBENCH_SHARE, else share/tactbench where installed, else source.
std::string share_folder();
// Names of the TOML files in one of its folders ("sequences", "bench/config"), sorted.
std::vector<std::string> shipped_files(const std::string& folder);
// `name` if such a file exists or it holds a folder, else the shipped one of that name (with or without .toml). Throws
// FileError TB-FILE-MISSING, with the nearest shipped name or all of them.
std::string find_recipe(const std::string& name);
std::string find_config(const std::string& name);

}  // namespace tactbench::bench
