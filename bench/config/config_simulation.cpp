#include "bench/config/config_simulation.h"

#include <algorithm>
#include <limits>

namespace tactbench::bench {

using sequences::TomlTable;

namespace {

// The value of an enumeration by its word; `words` are in the enumeration's order.
template <typename Enum>
Enum word_of(const TomlTable& table, const char* key, Enum usual, const std::vector<std::string>& words) {
  const std::string word = table.word(key, words[static_cast<std::size_t>(usual)], words);
  return static_cast<Enum>(std::find(words.begin(), words.end(), word) - words.begin());
}

void read_chamber(const TomlTable& table, const BenchConfig& config, ChamberOptions& chamber) {
  chamber.span_psi = config.regulator.command_span.high.value();
  chamber.reference_span_psi = table.number_in("reference_span_psi", chamber.reference_span_psi, 1.0, 1000.0);
  chamber.time_constant_s = table.number_in("time_constant_s", chamber.time_constant_s, 0.01, 10.0);
  chamber.damping = table.number_in("damping", chamber.damping, 0.2, 5.0);
  chamber.slew_psi_per_s = table.number_in("slew_psi_per_s", chamber.slew_psi_per_s, 1.0, 1000.0);
  chamber.resolution_v = table.number_in("resolution_v", chamber.resolution_v, 0.0, 0.1);
  chamber.hysteresis_share = table.number_in("hysteresis_share", chamber.hysteresis_share, 0.0, 0.05);
  chamber.leak_psi_per_s = table.number_in("leak_psi_per_s", chamber.leak_psi_per_s, 0.0, 50.0);
  chamber.dump_psi_per_s = table.number_in("dump_psi_per_s", chamber.dump_psi_per_s, 1.0, 10000.0);
  chamber.reference_noise_psi = table.number_in("reference_noise_psi", chamber.reference_noise_psi, 0.0, 1.0);
  chamber.feedback_noise_psi = table.number_in("feedback_noise_psi", chamber.feedback_noise_psi, 0.0, 1.0);
  table.finish();
}

void read_contact(const TomlTable& table, ContactOptions& contact) {
  contact.object = word_of(table, "object", contact.object, {"ring", "point", "flat"});
  const auto read = [&](const char* key, double& value, double low, double high) {
    value = table.number_in(key, value, low, high);
  };
  read("outer_diameter_mm", contact.outer_diameter_mm, 0.1, 200.0);
  read("inner_diameter_mm", contact.inner_diameter_mm, 0.0, contact.outer_diameter_mm - 0.1);
  read("point_diameter_mm", contact.point_diameter_mm, 0.0, 200.0);
  read("surface_z_mm", contact.surface_z_mm, 0.0, 1000.0);
  read("stiffness_n_per_mm", contact.stiffness_n_per_mm, 0.1, 1000.0);
  read("stiffening_n_per_mm2", contact.stiffening_n_per_mm2, 0.0, 10000.0);
  read("friction_share", contact.friction_share, 0.0, 0.5);
  read("relaxation_share", contact.relaxation_share, 0.0, 0.5);
  read("relaxation_s", contact.relaxation_s, 0.01, 1000.0);
  read("backlash_mm", contact.backlash_mm, 0.0, 1.0);
  read("fabric_spread_mm", contact.fabric_spread_mm, 0.05, 20.0);
  read("pitch_mm", contact.pitch_mm, 0.1, 100.0);
  read("centre_x_mm", contact.centre_x_mm, -1000.0, 1000.0);
  read("centre_y_mm", contact.centre_y_mm, -1000.0, 1000.0);
  read("misplaced_x_mm", contact.misplaced_x_mm, -100.0, 100.0);
  read("misplaced_y_mm", contact.misplaced_y_mm, -100.0, 100.0);
  read("misplaced_deg", contact.misplaced_deg, -180.0, 180.0);
  read("force_noise_n", contact.force_noise_n, 0.0, 1.0);
  read("torque_noise_nmm", contact.torque_noise_nmm, 0.0, 10.0);
  table.finish();
}

// What is stated of the instruments is what their errors are drawn within.
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

PlannedFault read_fault(const TomlTable& table) {
  const auto& words = fault_words();
  PlannedFault fault;
  const std::string kind = table.word("kind", words);
  fault.kind = static_cast<FaultKind>(std::find(words.begin(), words.end(), kind) - words.begin());
  const auto read = [&](const char* key, std::optional<double>& value, double low, double high) {
    if (table.has(key)) value = table.number_in(key, low, low, high);
  };
  read("at_s", fault.at_s, 0.0, 1e8);
  read("at_psi", fault.at_psi, 0.0, 1000.0);
  read("at_n", fault.at_n, 0.0, 1000.0);
  fault.lasts_s = table.number_in("lasts_s", fault.lasts_s, 0.0, std::numeric_limits<double>::infinity());
  read("value", fault.value, -1000.0, 1000.0);
  fault.times = table.integer("times", 0, 0, 1000000000);
  table.finish();
  return fault;
}

void read_front_end(const TomlTable& table, ScannerFrontEnd& front_end) {
  front_end.noise_v = table.number_in("noise_v", front_end.noise_v, 0.0, 1.0);
  front_end.relay_settle_s = table.number_in("relay_settle_s", front_end.relay_settle_s, 0.0, 1.0);
  front_end.relay_time_constant_s = table.number_in("relay_time_constant_s", front_end.relay_time_constant_s, 0.0, 1.0);
  table.finish();
}

void read_effects(const TomlTable& table, SpecimenEffects& effects) {
  effects.row_crosstalk = table.number_in("row_crosstalk", effects.row_crosstalk, 0.0, 0.5);
  effects.column_crosstalk = table.number_in("column_crosstalk", effects.column_crosstalk, 0.0, 0.5);
  effects.temperature_coefficient =
      table.number_in("temperature_coefficient", effects.temperature_coefficient, -0.05, 0.05);
  effects.lift_off_psi = table.number_in("lift_off_psi", effects.lift_off_psi, 0.0, 5.0);
  effects.chamber_nonuniformity = table.number_in("chamber_nonuniformity", effects.chamber_nonuniformity, -0.5, 0.5);
  effects.chamber_tilt = table.number_in("chamber_tilt", effects.chamber_tilt, -0.5, 0.5);
  effects.chamber_tilt_deg = table.number_in("chamber_tilt_deg", effects.chamber_tilt_deg, -360.0, 360.0);
  effects.zero_drift_v_per_month = table.number_in("zero_drift_v_per_month", effects.zero_drift_v_per_month, -0.5, 0.5);
  effects.gain_drift_per_month = table.number_in("gain_drift_per_month", effects.gain_drift_per_month, 0.0, 0.5);
  effects.gain_drift_per_thousand_cycles =
      table.number_in("gain_drift_per_thousand_cycles", effects.gain_drift_per_thousand_cycles, -0.5, 0.5);
  effects.remount_variation = table.number_in("remount_variation", effects.remount_variation, 0.0, 0.5);
  table.finish();
}

TaxelDefect read_defect(const TomlTable& table, const devices::HidScannerOptions& scanner) {
  TaxelDefect defect;
  const std::vector<std::string> words = {"dead", "stuck", "saturated", "noisy", "swapped"};
  const std::string kind = table.word("kind", words);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (kind == words[i]) defect.kind = static_cast<TaxelDefect::Kind>(i);
  }
  defect.row = static_cast<int>(table.integer("row", 0, scanner.rows - 1));
  defect.column = static_cast<int>(table.integer("column", 0, scanner.columns - 1));
  if (defect.kind == TaxelDefect::Kind::kSwapped) {
    defect.other_row = static_cast<int>(table.integer("other_row", 0, scanner.rows - 1));
    defect.other_column = static_cast<int>(table.integer("other_column", 0, scanner.columns - 1));
  }
  table.finish();
  return defect;
}

void read_wire_faults(const TomlTable& table, SimulationConfig& simulation) {
  constexpr long kMost = 1000000000;
  auto& module = simulation.module_faults;
  module.silent_after_requests = table.integer("module_silent_after_requests", -1, -1, kMost);
  module.dead_after_requests = table.integer("module_dead_after_requests", -1, -1, kMost);
  auto& scanner = simulation.scanner_faults;
  scanner.silent_after_scans = table.integer("scanner_silent_after_scans", -1, -1, kMost);
  scanner.corrupt_scan = table.integer("scanner_corrupt_scan", -1, -1, kMost);
  scanner.drop_report_scan = table.integer("scanner_drop_report_scan", -1, -1, kMost);
  scanner.unplug_after_scans = table.integer("scanner_unplug_after_scans", -1, -1, kMost);
  table.finish();
}

}  // namespace

SimulationConfig read_simulation(const TomlTable& table, const BenchConfig& config, const SeedOptions& seeds) {
  SimulationConfig simulation;
  constexpr long kMost = 1L << 53;
  PlantOptions& plant = simulation.plant;
  SpecimenOptions& specimen = plant.specimen;
  plant.seed = seeds.seed.value_or(static_cast<std::uint64_t>(table.integer("seed", 1, 0, kMost)));
  specimen.sensor_seed =
      seeds.sensor_seed.value_or(static_cast<std::uint64_t>(table.integer("sensor_seed", 1, 0, kMost)));
  plant.instruments = instruments_of(config, static_cast<std::uint64_t>(table.integer("instrument_seed", 0, 0, kMost)));
  specimen.kind = word_of(table, "specimen", specimen.kind, specimen_words());
  specimen.mount_seed = static_cast<std::uint64_t>(table.integer("mount_seed", 0, 0, kMost));
  specimen.temperature_c = table.number_in("temperature_c", specimen.temperature_c, -20.0, 80.0);
  specimen.age_months = table.number_in("age_months", specimen.age_months, 0.0, 1200.0);
  specimen.mount_turn = word_of(table, "mount_turn", specimen.mount_turn,
                                mount_turn_words(config.scanner.rows == config.scanner.columns));
  specimen.turned_in_chamber_deg =
      table.number_in("turned_in_chamber_deg", specimen.turned_in_chamber_deg, -360.0, 360.0);
  specimen.edge_outside = word_of(table, "edge_outside", specimen.edge_outside, mount_edge_words());
  specimen.edge_outside_lines = static_cast<int>(table.integer("edge_outside_lines", 0, 0, 1024));
  plant.supply_bar = table.number_in("supply_bar", plant.supply_bar, 0.0, 20.0);
  specimen.rows = config.scanner.rows;
  specimen.columns = config.scanner.columns;
  simulation.frame_source_port = static_cast<int>(table.integer("frame_source_port", 0, 0, 65535));
  simulation.scanner_serial = table.text("scanner_serial", simulation.scanner_serial);
  read_chamber(table.table("chamber"), config, plant.chamber);
  read_contact(table.table("contact"), plant.contact);
  read_front_end(table.table("front_end"), plant.scanner);
  read_effects(table.table("effects"), specimen.effects);
  for (const TomlTable& defect : table.tables("defect")) {
    specimen.defects.push_back(read_defect(defect, config.scanner));
  }
  for (const TomlTable& fault : table.tables("faults")) plant.faults.push_back(read_fault(fault));
  read_wire_faults(table.table("wire_faults"), simulation);
  table.finish();
  return simulation;
}

}  // namespace tactbench::bench
