#include "bench/config/config_simulation.h"

#include <optional>

#include "sequences/toml/key_table.h"

namespace tactbench::bench {

using sequences::Key;
using sequences::KeyTable;
using sequences::kOne;
using sequences::Range;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

constexpr double kMost = 1e9, kMostSeed = 9007199254740992.0;  // 2^53

Key optional_number(const char* name, std::optional<double>& value, const sequences::Unit& unit, const Range& range,
                    const char* meaning) {
  double none = 0.0;
  Key row = key::optional(key::number(name, none, unit, range, meaning));
  row.read = [name, &value, range](const TomlTable& table, bool) {
    value = table.number_in(name, std::nullopt, range.low, range.high);
  };
  return row;
}

KeyTable chamber_keys(ChamberOptions& chamber) {
  return {key::number("reference_span_psi", chamber.reference_span_psi, {"psi"}, {1.0, 1000.0},
                      "Pressure at which the reference transducer gives 10 V"),
          key::number("time_constant_s", chamber.time_constant_s, {"s"}, {0.01, 10.0},
                      "Time constant of the chamber behind the valve (second order)"),
          key::number("damping", chamber.damping, kOne, {0.2, 5.0},
                      "Damping of the chamber's pressure; below 1 it overshoots"),
          key::number("slew_psi_per_s", chamber.slew_psi_per_s, {"psi/s"}, {1.0, 1000.0},
                      "Fastest change that the valve's flow allows"),
          key::number("resolution_v", chamber.resolution_v, {"V"}, {0.0, 0.1},
                      "Smallest change of the set-point's voltage that the regulator sees"),
          key::number("hysteresis_share", chamber.hysteresis_share, kOne, {0.0, 0.05},
                      "Hysteresis of the regulator, as a share of its span"),
          key::number("leak_psi_per_s", chamber.leak_psi_per_s, {"psi/s"}, {0.0, 50.0},
                      "Pressure lost through a leak while a level is held"),
          key::number("dump_psi_per_s", chamber.dump_psi_per_s, {"psi/s"}, {1.0, 10000.0},
                      "Fall of pressure through an open dump valve"),
          key::number("reference_noise_psi", chamber.reference_noise_psi, {"psi"}, {0.0, 1.0},
                      "Noise of the reference, as a standard deviation"),
          key::number("feedback_noise_psi", chamber.feedback_noise_psi, {"psi"}, {0.0, 1.0},
                      "Noise of the regulator's monitor, as a standard deviation")};
}

KeyTable contact_keys(ContactOptions& contact) {
  Key inner = key::number("inner_diameter_mm", contact.inner_diameter_mm, {"mm"}, {}, "Inner diameter of the ring");
  inner.facts.range = "0 to 0.1 below outer_diameter_mm";  // checked when both are read
  return {
      key::word("object", contact.object, {"ring", "point", "flat"},
                "Object under the z stage; press.object of a recipe (ring, point or flat) has precedence"),
      key::number("outer_diameter_mm", contact.outer_diameter_mm, {"mm"}, {0.1, 200.0}, "Outer diameter of the ring"),
      inner,
      key::number("point_diameter_mm", contact.point_diameter_mm, {"mm"}, {0.0, 200.0},
                  "Diameter of the point indenter"),
      key::number("surface_z_mm", contact.surface_z_mm, {"mm"}, {0.0, 1000.0},
                  "Position of z at which the object touches the fabric"),
      key::number("stiffness_n_per_mm", contact.stiffness_n_per_mm, {"N/mm"}, {0.1, 1000.0},
                  "Stiffness of fabric, film and support at first touch"),
      key::number("stiffening_n_per_mm2", contact.stiffening_n_per_mm2, {"N/mm²"}, {0.0, 10000.0},
                  "How much stiffer they become with depth"),
      key::number("friction_share", contact.friction_share, kOne, {0.0, 0.5},
                  "Hysteresis of the fabric: more force while loading, less while unloading"),
      key::number("relaxation_share", contact.relaxation_share, kOne, {0.0, 0.5},
                  "Share of the force that is lost at a held position"),
      key::number("relaxation_s", contact.relaxation_s, {"s"}, {0.01, 1000.0},
                  "Shorter time constant of that loss; the other is ten times as long"),
      key::number("backlash_mm", contact.backlash_mm, {"mm"}, {0.0, 1.0},
                  "How far z turns back before the object follows"),
      key::number("fabric_spread_mm", contact.fabric_spread_mm, {"mm"}, {0.05, 20.0},
                  "How far the fabric blurs the object's edge, as a standard deviation"),
      key::number("pitch_mm", contact.pitch_mm, {"mm"}, {0.1, 100.0}, "Distance of two taxels of the simulated array"),
      key::number("centre_x_mm", contact.centre_x_mm, {"mm"}, {-1000.0, 1000.0},
                  "Position of x at which the object is over the array's centre"),
      key::number("centre_y_mm", contact.centre_y_mm, {"mm"}, {-1000.0, 1000.0},
                  "Position of y at which the object is over the array's centre"),
      key::number("misplaced_x_mm", contact.misplaced_x_mm, {"mm"}, {-100.0, 100.0},
                  "Error of the sensor's position along x, which a registration must find"),
      key::number("misplaced_y_mm", contact.misplaced_y_mm, {"mm"}, {-100.0, 100.0},
                  "Error of the sensor's position along y, which a registration must find"),
      key::number("misplaced_deg", contact.misplaced_deg, {"°"}, {-180.0, 180.0},
                  "Rotation of the sensor, counter-clockwise, which a registration must find"),
      key::number("force_noise_n", contact.force_noise_n, {"N"}, {0.0, 1.0},
                  "Noise of each force axis, as a standard deviation"),
      key::number("torque_noise_nmm", contact.torque_noise_nmm, {"N mm"}, {0.0, 10.0},
                  "Noise of each torque axis, as a standard deviation")};
}

// The errors of the instruments are drawn within their stated limits.
InstrumentOptions instruments_of(const BenchConfig& config, std::uint64_t seed) {
  const auto limits_of = [](const StatedCalibration& stated, double input_scale) {
    return DrawnLimits{0.5 * stated.expanded_uncertainty, stated.drift, input_scale * stated.input_limit};
  };
  InstrumentOptions out;
  out.seed = seed;
  const devices::LinearSpan& span = config.reference.span;
  const double volts = span.volts_high.value() - span.volts_low.value();
  out.reference =
      limits_of(config.reference_stated, volts > 0.0 ? (span.high.value() - span.low.value()) / volts : 0.0);
  if (const devices::PressureCorrection& correction = config.reference_correction; !correction.empty()) {
    out.reading_psi = correction.reading_psi;
    for (const double expanded : correction.expanded_uncertainty_psi)
      out.certificate_u_psi.push_back(expanded / correction.coverage_factor);
  } else if (out.reference.certificate_u > 0.0) {
    out.reading_psi = {0.0};
    out.certificate_u_psi = {out.reference.certificate_u};
  }
  out.hysteresis_psi = config.reference_limits.hysteresis_psi;
  out.zero_psi = config.reference_limits.zero_psi;
  out.temperature_psi = config.reference_limits.temperature_psi;
  if (config.force) out.force_n = limits_of(config.force->stated, 1.0);
  for (const EnvironmentSensor& sensor : config.environment)
    if (sensor.quantity == "temperature_c") out.thermometer_c = limits_of(sensor.stated, 1.0);
  return out;
}

KeyTable fault_keys(PlannedFault& fault) {
  return {
      key::required(key::word("kind", fault.kind, fault_kind_names(), "What breaks")),
      optional_number("at_s", fault.at_s, {"s"}, {0.0, 1e8},
                      "Process time at which the fault begins; without any at_ key it begins at once"),
      optional_number("at_psi", fault.at_psi, {"psi"}, {0.0, 1000.0},
                      "The fault begins when the chamber first reaches this pressure from below"),
      optional_number("at_n", fault.at_n, {"N"}, {0.0, 1000.0},
                      "The fault begins when the force on the sensor first reaches this"),
      key::number("lasts_s", fault.lasts_s, {"s"}, {0.0}, "Duration of the fault"),
      optional_number("value", fault.value, {"of its kind"}, {-1000.0, 1000.0},
                      "Size of the fault, in the unit of its kind (psi/s for a leak); default: that of the kind"),
      key::number("times", fault.times, kOne, {0, kMost}, "Number of answers that it affects; 0: all while it lasts")};
}

KeyTable front_end_keys(ScannerFrontEnd& front_end) {
  return {key::number("noise_v", front_end.noise_v, {"V"}, {0.0, 1.0},
                      "Noise of one sample of the scanner, as a standard deviation"),
          key::number("relay_settle_s", front_end.relay_settle_s, {"s"}, {0.0, 1.0},
                      "Time that the scanner waits after a row's relay has closed"),
          key::number("relay_time_constant_s", front_end.relay_time_constant_s, {"s"}, {0.0, 1.0},
                      "Time constant with which the previous row decays")};
}

KeyTable effect_keys(SpecimenEffects& effects) {
  return {key::number("row_crosstalk", effects.row_crosstalk, kOne, {0.0, 0.5},
                      "Share of the row's mean output that is added to each of its taxels"),
          key::number("column_crosstalk", effects.column_crosstalk, kOne, {0.0, 0.5},
                      "Share of the column's mean output that is added to each of its taxels"),
          key::number("temperature_coefficient", effects.temperature_coefficient, {"1/K"}, {-0.05, 0.05},
                      "Relative change of the output for each kelvin away from 23 °C"),
          key::number("lift_off_psi", effects.lift_off_psi, {"psi"}, {0.0, 5.0},
                      "Mean pressure below which the membrane does not touch a taxel"),
          key::number("chamber_nonuniformity", effects.chamber_nonuniformity, kOne, {-0.5, 0.5},
                      "Relative difference of pressure from the array's centre to a corner"),
          key::number("chamber_tilt", effects.chamber_tilt, kOne, {-0.5, 0.5},
                      "Relative difference of pressure over the array's longer side"),
          key::number("chamber_tilt_deg", effects.chamber_tilt_deg, {"°"}, {-360.0, 360.0},
                      "Direction in which the tilt rises: 0 the last column, 90 row 0"),
          key::number("zero_drift_v_per_month", effects.zero_drift_v_per_month, {"V/month"}, {-0.5, 0.5},
                      "Drift of the unloaded output, the same for all taxels"),
          key::number("gain_drift_per_month", effects.gain_drift_per_month, {"1/month"}, {0.0, 0.5},
                      "Relative drift of the gain; its standard deviation over taxels"),
          key::number("gain_drift_per_thousand_cycles", effects.gain_drift_per_thousand_cycles, {"1/1000 cycles"},
                      {-0.5, 0.5}, "Relative drift of the gain by use; a cycle is 60 psi"),
          key::number("remount_variation", effects.remount_variation, kOne, {0.0, 0.5},
                      "Relative change of a taxel's pressure by mounting, as a standard deviation")};
}

KeyTable defect_keys(TaxelDefect& defect, const devices::HidScannerOptions& scanner) {
  return {
      key::required(
          key::word("kind", defect.kind, {"dead", "stuck", "saturated", "noisy", "swapped"},
                    "dead reads 0 V, stuck a constant voltage, saturated the converter's limit; noisy has 50 mV "
                    "more noise; swapped has changed places with another taxel")),
      key::required(key::number("row", defect.row, kOne, {0, scanner.rows - 1.0}, "Row of the taxel, counted from 0")),
      key::required(key::number("column", defect.column, kOne, {0, scanner.columns - 1.0},
                                "Column of the taxel, counted from 0"))};
}

KeyTable swap_keys(TaxelDefect& defect, const devices::HidScannerOptions& scanner) {
  return {key::required(key::number("other_row", defect.other_row, kOne, {0, scanner.rows - 1.0},
                                    "Row of the taxel that it is swapped with")),
          key::required(key::number("other_column", defect.other_column, kOne, {0, scanner.columns - 1.0},
                                    "Column of the taxel that it is swapped with"))};
}

TaxelDefect read_defect(const TomlTable& table, const devices::HidScannerOptions& scanner) {
  TaxelDefect defect;
  read_keys(table, defect_keys(defect, scanner));
  if (defect.kind == TaxelDefect::Kind::kSwapped) read_keys(table, swap_keys(defect, scanner));
  table.finish();
  return defect;
}

KeyTable wire_fault_keys(SimulationConfig& simulation) {
  return {key::number("module_silent_after_requests", simulation.module_faults.silent_after_requests, kOne, {-1, kMost},
                      "The module answers this many requests, then none; -1: never"),
          key::number("module_dead_after_requests", simulation.module_faults.dead_after_requests, kOne, {-1, kMost},
                      "The module closes its line after this many requests; -1: never"),
          key::number("scanner_silent_after_scans", simulation.scanner_faults.silent_after_scans, kOne, {-1, kMost},
                      "The scanner answers this many scans, then none; -1: never"),
          key::number("scanner_corrupt_scan", simulation.scanner_faults.corrupt_scan, kOne, {-1, kMost},
                      "Number of the scan in which one bit is wrong; -1: none"),
          key::number("scanner_drop_report_scan", simulation.scanner_faults.drop_report_scan, kOne, {-1, kMost},
                      "Number of the scan in which one report is missing; -1: none"),
          key::number("scanner_unplug_after_scans", simulation.scanner_faults.unplug_after_scans, kOne, {-1, kMost},
                      "The scanner is unplugged after this many scans; -1: never")};
}

KeyTable simulation_keys(SimulationConfig& simulation, const devices::HidScannerOptions& scanner) {
  PlantOptions& plant = simulation.plant;
  SpecimenOptions& specimen = plant.specimen;
  return {key::number("seed", plant.seed, kOne, {0, kMostSeed},
                      "Seed of noise and faults; the same seeds give the same run. --seed has precedence"),
          key::number("sensor_seed", specimen.sensor_seed, kOne, {0, kMostSeed},
                      "Seed of the array: another number is another sensor. --sensor-seed has precedence"),
          key::number("instrument_seed", plant.instruments.seed, kOne, {0, kMostSeed},
                      "Seed of the errors of reference, force sensor and thermometer, drawn within their stated "
                      "limits; 0: no errors"),
          key::word("specimen", specimen.kind, specimen_kind_names(),
                    "Film of the simulated sensor: the paper's, one that is harder on every model, or a foam"),
          key::number("mount_seed", specimen.mount_seed, kOne, {0, kMostSeed},
                      "Another number: the sensor was taken out and mounted again"),
          key::number("temperature_c", specimen.temperature_c, {"°C"}, {-20.0, 80.0}, "Temperature of the sensor"),
          key::number("age_months", specimen.age_months, {"months"}, {0.0, 1200.0},
                      "Time since the sensor was new, for drifts"),
          key::word("mount_turn", specimen.mount_turn, mount_turn_names(scanner.rows == scanner.columns),
                    "Orientation of the film under its wiring; anything except none is a mounting fault"),
          key::number("turned_in_chamber_deg", specimen.turned_in_chamber_deg, {"°"}, {-360.0, 360.0},
                      "Rotation of the sensor in the chamber, with its leads, counter-clockwise"),
          key::word("edge_outside", specimen.edge_outside, mount_edge_names(),
                    "Edge of the array at which lines are outside the membrane"),
          key::number("edge_outside_lines", specimen.edge_outside_lines, kOne, {0, 1024},
                      "Number of such lines, which the membrane does not press"),
          key::number("supply_bar", plant.supply_bar, {"bar"}, {0.0, 20.0},
                      "Pressure of the compressed air in front of the regulator"),
          key::number("frame_source_port", simulation.frame_source_port, kOne, {0, 65535},
                      "Port of the simulated frame source; 0: any free one"),
          key::text("scanner_serial", simulation.scanner_serial, "Serial number that the simulated scanner reports")};
}

}  // namespace

SimulationConfig read_simulation(const TomlTable& table, const BenchConfig& config, const SeedOptions& seeds) {
  SimulationConfig simulation;
  PlantOptions& plant = simulation.plant;
  SpecimenOptions& specimen = plant.specimen;
  read_keys(table, simulation_keys(simulation, config.scanner));
  plant.seed = seeds.seed.value_or(plant.seed);
  specimen.sensor_seed = seeds.sensor_seed.value_or(specimen.sensor_seed);
  plant.instruments = instruments_of(config, plant.instruments.seed);
  specimen.rows = config.scanner.rows;
  specimen.columns = config.scanner.columns;
  plant.chamber.low_psi = config.regulator.command_span.low.value();
  plant.chamber.span_psi = config.regulator.command_span.high.value();
  read_whole(table.table("chamber"), chamber_keys(plant.chamber));
  const TomlTable contact = table.table("contact");
  read_whole(contact, contact_keys(plant.contact));
  contact.check_range("inner_diameter_mm", plant.contact.inner_diameter_mm, 0.0, plant.contact.outer_diameter_mm - 0.1);
  read_whole(table.table("front_end"), front_end_keys(plant.scanner));
  read_whole(table.table("effects"), effect_keys(specimen.effects));
  for (const TomlTable& defect : table.tables("defect")) {
    specimen.defects.push_back(read_defect(defect, config.scanner));
  }
  for (const TomlTable& fault : table.tables("faults")) read_whole(fault, fault_keys(plant.faults.emplace_back()));
  read_whole(table.table("wire_faults"), wire_fault_keys(simulation));
  table.finish();
  return simulation;
}

void add_simulation_keys(std::vector<sequences::KeyFacts>& all) {
  SimulationConfig simulation;
  const devices::HidScannerOptions scanner;
  PlannedFault fault;
  TaxelDefect defect;
  add_facts(all, "simulation", simulation_keys(simulation, scanner));
  add_facts(all, "simulation.chamber", chamber_keys(simulation.plant.chamber));
  add_facts(all, "simulation.contact", contact_keys(simulation.plant.contact));
  add_facts(all, "simulation.front_end", front_end_keys(simulation.plant.scanner));
  add_facts(all, "simulation.effects", effect_keys(simulation.plant.specimen.effects));
  add_facts(all, "simulation.defect[]", defect_keys(defect, scanner));
  add_facts(all, "simulation.defect[]", swap_keys(defect, scanner));
  add_facts(all, "simulation.faults[]", fault_keys(fault));
  add_facts(all, "simulation.wire_faults", wire_fault_keys(simulation));
}

}  // namespace tactbench::bench
