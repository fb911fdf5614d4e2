#include "bench/instruments/check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>

#include "analysis/counted.h"
#include "analysis/pressure_unit.h"
#include "bench/common/error.h"
#include "bench/config/config_calibration.h"
#include "bench/rig/device_records.h"
#include "bench/safety/safe_state.h"
#include "devices/clock.h"
#include "devices/device.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/daqmx/daqmx_api.h"
#include "devices/wire/modbus/modbus_link.h"
#include "devices/wire/report_link.h"

namespace tactbench::bench {
namespace {

using State = DeviceCheck::State;

// Faults that mean that nothing answers; all others mean that the device is not the expected one or not sound.
bool means_absent(const std::string& id) {
  constexpr std::array kAbsent{"TB-MODBUS-CONNECT", "TB-MODBUS-TIMEOUT",     "TB-HID-OPEN",      "TB-SERIAL-OPEN",
                               "TB-SERIAL-LOST",    "TB-HID-LOST",           "TB-SCANNER-LOST",  "TB-SCANNER-TIMEOUT",
                               "TB-FORCE-TIMEOUT",  "TB-UDP-OPEN",           "TB-DAQMX-LIBRARY", "TB-DAQMX-DEVICE",
                               "TB-STAGE-TIMEOUT",  "TB-CONTROLLER-TIMEOUT", "TB-HTTP-OPEN",     "TB-HTTP-TIMEOUT",
                               "TB-UDP-LOST"};
  return std::find(kAbsent.begin(), kAbsent.end(), id) != kAbsent.end();
}

DeviceCheck check(const std::string& role, const std::function<void(DeviceCheck&)>& inspect) {
  DeviceCheck result;
  result.role = role;
  try {
    inspect(result);
  } catch (const devices::Fault& fault) {
    result.state = means_absent(fault.id()) ? State::kAbsent : State::kWrong;
    result.notes.insert(result.notes.begin(), fmt::format("{}: {}", fault.id(), fault.what()));
    result.remedy = as_error(std::current_exception()).remedy();
  }
  return result;
}

void complain(DeviceCheck& result, const std::string& note, const std::string& remedy) {
  result.state = State::kWrong;
  result.notes.push_back(note);
  result.remedy = remedy;
}

// In words; overdue is a warning, which any fault outranks.
void report_calibration(const db::DeviceRecord& record, const std::string& today, DeviceCheck& result) {
  const analysis::InstrumentCalibration calibration = analysis::calibration_of(record);
  result.notes.push_back(calibration_text(calibration, today, analysis::PressureUnit::kPsi));
  if (due_state(calibration, today) != analysis::DueState::kOverdue || result.state != State::kOk) return;
  result.state = State::kWarning;
  result.remedy = "have it calibrated: results measured with it until then are inconclusive";
}

std::string name_of(const devices::Identity& identity) {
  const auto stated = [](const std::string& text, const char* what) {
    return text.empty() ? std::string() : fmt::format(", {} {}", what, text);
  };
  return fmt::format("{}{}{}{}", identity.model, stated(identity.serial, "serial"),
                     stated(identity.firmware, "firmware"),
                     identity.origin == devices::Origin::kSimulated ? " (simulated)" : "");
}

void inspect_module(Rig& rig, DeviceCheck& result) {
  const auto [identity, outputs] = rig.inspect_module();
  result.found = name_of(identity);
  result.reading =
      outputs.empty() ? "outputs cannot be read" : fmt::format("outputs {} counts", fmt::join(outputs, " "));
}

// As a run would judge the same reading before its first command.
void judge_zero(const PressureWitness& witness, const BenchConfig& config, const char* remedy, DeviceCheck& result) {
  if (!witness.possible()) {
    complain(result, fmt::format("{} {}", analysis::both_units(witness.psi(), 2), witness.doubt()),
             "check its supply and wiring (a broken wire reads below a live zero), and its span in the bench file");
  } else if (witness.psi() >= config.limits.safe_psi) {
    complain(result,
             fmt::format("not at zero: {}, limit {}", analysis::both_units(witness.psi(), 2),
                         analysis::both_units(config.limits.safe_psi)),
             remedy);
  }
}

void inspect_regulator(Rig& rig, DeviceCheck& result) {
  result.found = name_of(rig.source().identity());
  const double psi = rig.source().feedback().pressure.value();
  result.reading = "feedback " + analysis::both_units(psi, 2);
  judge_zero(rig.guard().feedback(), rig.config(),
             "vent the chamber; check span_v and span_bar, the monitor's wiring and the regulator's zero", result);
  for (const std::string& layer : fail_safe_layers(rig.config())) result.notes.push_back(layer);
}

void inspect_reference(Rig& rig, DeviceCheck& result, const std::string& today) {
  const BenchConfig& config = rig.config();
  result.found = name_of(rig.reference().identity());
  const double psi = rig.reference().read().pressure.value();
  result.reading = analysis::both_units(psi, 2);
  if (!config.reference_independent)
    result.notes.emplace_back("the regulator's feedback: pressure not independently traceable");
  report_calibration(reference_record(rig.reference().identity(), config), today, result);
  if (!config.reference_correction.empty()) {
    result.notes.push_back(
        fmt::format("correction {}, U {} (k = {:g}) at this reading",
                    analysis::both_units(config.reference_correction.corrected(devices::Psi(psi)).value() - psi, 3),
                    analysis::both_units(config.reference_correction.expanded_uncertainty(devices::Psi(psi)), 3),
                    config.reference_correction.coverage_factor));
  }
  judge_zero(rig.guard().reference(), config, "vent the chamber; check the transducer's span and zero", result);
}

void inspect_array(Rig& rig, DeviceCheck& result) {
  rig.open_array();
  const devices::ScanSet scan = rig.array().read(1);
  result.found = name_of(rig.array().identity());
  result.reading =
      fmt::format("{} x {} taxels, {}", scan.rows, scan.columns, array_summary(scan, rig.array().volts_per_count()));
  if (scan.status != 0) result.notes.push_back(fmt::format("status 0x{:02X}", scan.status));
}

void inspect_stage(Rig& rig, DeviceCheck& result, const std::string& today) {
  std::vector<std::string> names, positions;
  for (const devices::AxisIdentity& axis : rig.stage()->identify()) {
    const char letter = "xyz"[static_cast<int>(axis.axis)];
    if (!axis.present) {
      result.state = State::kAbsent;
      result.notes.push_back(fmt::format("axis {} does not answer", letter));
      result.remedy = axis.remedy;
      continue;
    }
    names.push_back(fmt::format("{}: id {}, firmware {}", letter, axis.id, axis.firmware));
    positions.push_back(
        fmt::format("{} {}, {:.1f} V", letter, analysis::counted(axis.microsteps, "microstep"), axis.supply.value()));
    if (!axis.complaint.empty()) complain(result, fmt::format("axis {}: {}", letter, axis.complaint), axis.remedy);
  }
  result.found = fmt::format("{}{}", fmt::join(names, "; "),
                             rig.config().origin == devices::Origin::kSimulated ? " (simulated)" : "");
  result.reading = fmt::format("{}", fmt::join(positions, "; "));
  report_calibration(stage_record({}, 0, *rig.config().stage), today, result);
}

void inspect_force(Rig& rig, DeviceCheck& result, const std::string& today) {
  devices::ForceSensor& sensor = rig.open_force();
  const devices::ForceReading reading = sensor.read(rig.config().force->records);
  result.found = fmt::format("{}, calibration {}", name_of(sensor.identity()), sensor.calibration_serial());
  const auto& force = reading.wrench.force_n;
  const auto& torque = reading.wrench.torque_nmm;
  result.reading = fmt::format("F {:.3f} {:.3f} {:.3f} N, T {:.2f} {:.2f} {:.2f} N mm", force[0], force[1], force[2],
                               torque[0], torque[1], torque[2]);
  const auto range = sensor.range();
  result.notes.push_back(fmt::format("range +-{:g} {:g} {:g} N, +-{:g} {:g} {:g} N mm", range[0], range[1], range[2],
                                     range[3], range[4], range[5]));
  report_calibration(force_record({sensor.identity(), {}, {}}, *rig.config().force), today, result);
  if (std::abs(force[2]) > 0.1 * range[2]) {
    result.notes.emplace_back("far from zero: an object rests on the sensor, or it needs a tare");
  }
}

}  // namespace

const char* to_string(State state) {
  return state == State::kOk        ? "ok"
         : state == State::kWarning ? "warning"
         : state == State::kAbsent  ? "absent"
                                    : "wrong";
}

std::string array_summary(const devices::ScanSet& scan, devices::Volts volts_per_count) {
  const double sum = std::accumulate(scan.counts.begin(), scan.counts.end(), 0.0);
  const auto highest = *std::max_element(scan.counts.begin(), scan.counts.end());
  return fmt::format("mean {:.3f} V, highest {:.3f} V",
                     sum / static_cast<double>(scan.counts.size()) * volts_per_count.value(),
                     highest * volts_per_count.value());
}

std::vector<DeviceCheck> check_devices(Rig& rig, const std::string& today) {
  std::vector<DeviceCheck> all;
  if (rig.config().module.present())
    all.push_back(check("analog module", [&](DeviceCheck& result) { inspect_module(rig, result); }));
  all.push_back(check("regulator", [&](DeviceCheck& result) { inspect_regulator(rig, result); }));
  all.push_back(check("pressure reference", [&](DeviceCheck& result) { inspect_reference(rig, result, today); }));
  for (std::size_t i = 0; i < rig.config().environment.size(); ++i) {
    const EnvironmentSensor& sensor = rig.config().environment[i];
    all.push_back(check(sensor.quantity + " sensor", [&](DeviceCheck& result) {
      result.reading = fmt::format("{:.2f}", rig.environment(i).value);
      result.found = fmt::format("{}, serial {}", sensor.model, sensor.serial);
    }));
  }
  all.push_back(check("tactile scanner", [&](DeviceCheck& result) { inspect_array(rig, result); }));
  if (rig.stage() != nullptr)
    all.push_back(check("stage", [&](DeviceCheck& result) { inspect_stage(rig, result, today); }));
  if (rig.config().force) {
    all.push_back(check("force sensor", [&](DeviceCheck& result) { inspect_force(rig, result, today); }));
  }
  return all;
}

namespace {

void add_serial_ports(std::vector<ScanEntry>& entries) {
  for (const devices::SerialPortInfo& port : devices::list_serial_ports()) {
    const std::string usb = port.usb_vendor < 0 ? "not USB, may have nothing attached"
                                                : fmt::format("USB {:04x}:{:04x}, usb_serial = \"{}\"", port.usb_vendor,
                                                              port.usb_product, port.usb_serial);
    entries.push_back({"serial port", port.name, fmt::format("{} ({})", port.description, usb)});
  }
}

void add_hid_devices(std::vector<ScanEntry>& entries) {
  for (const devices::HidInfo& hid : devices::list_hid_devices()) {
    entries.push_back(
        {"HID device", fmt::format("vendor_id = 0x{:04x}, product_id = 0x{:04x}", hid.vendor_id, hid.product_id),
         fmt::format("{}, serial \"{}\", {}", hid.product.empty() ? "unnamed" : hid.product, hid.serial, hid.path)});
  }
}

ScanEntry ask_modbus(const std::string& text) {
  devices::ModbusEndpoint endpoint;
  const std::size_t colon = text.find(':');
  endpoint.host = text.substr(0, colon);
  if (colon != std::string::npos) endpoint.port = std::atoi(text.c_str() + colon + 1);
  if (endpoint.host.empty() || endpoint.port <= 0 || endpoint.port > 65535) {
    throw Error("TB-USAGE", fmt::format("'{}' is not HOST or HOST:PORT", text), "--modbus " + text,
                "e.g. --modbus 192.168.0.10:502");
  }
  endpoint.response_timeout = std::chrono::milliseconds(500);
  devices::SteadyClock clock;
  devices::ModbusLink link(endpoint, "Modbus server", clock);
  std::array<std::uint16_t, 1> word{};
  std::string what;
  try {
    link.read_input_registers(0, word);
    what = fmt::format("answers; input register 0 holds {}", word[0]);
  } catch (const devices::Fault& fault) {
    what = fault.id() == "TB-MODBUS-EXCEPTION" ? "answers (and refuses to read input register 0)" : fault.what();
  }
  return {"Modbus TCP", text, what};
}

void add_daqmx(std::vector<ScanEntry>& entries) {
  try {
    devices::DaqmxApi api;
    for (const devices::DaqmxDevice& device : api.list_devices()) {
      entries.push_back({"NI-DAQmx", device.name,
                         fmt::format("{}, serial {}{}", device.product_type, device.serial,
                                     device.simulated ? " (simulated by the driver)" : "")});
    }
  } catch (const devices::Fault& fault) {
    entries.push_back({"NI-DAQmx", "-", fault.what()});
  }
}

}  // namespace

std::vector<ScanEntry> scan_devices(const std::vector<std::string>& modbus_hosts) {
  std::vector<ScanEntry> entries;
  add_serial_ports(entries);
  add_hid_devices(entries);
  for (const std::string& host : modbus_hosts) entries.push_back(ask_modbus(host));
  add_daqmx(entries);
  return entries;
}

}  // namespace tactbench::bench
