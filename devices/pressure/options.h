// Options of a bench file for the regulator and the pressure reference (transducer or gauge), and the faults of a
// simulated analog module. The module's registers are described in module_profile.h.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/fault_injection.h"
#include "devices/units.h"
#include "devices/wire/modbus/modbus_value.h"

namespace tactbench::devices {

struct LinearSpan {  // LinearScale with the quantities' types: volts_low is low, volts_high is high
  Volts volts_low{0.0};
  Volts volts_high{10.0};
  Psi low{0.0};
  Psi high{0.0};
  [[nodiscard]] LinearScale scale() const { return {volts_low.value(), volts_high.value(), low.value(), high.value()}; }
  [[nodiscard]] Psi pressure(Volts volts) const;
  [[nodiscard]] Volts voltage(Psi pressure) const;
  // Pressure that a regulator sets at `volts`, clipped to its span.
  [[nodiscard]] Psi driven(Volts volts) const;
};

struct RegulatorOptions {
  std::string model = "Pneumax 171E2N.T.D.0009";
  std::string serial;
  int output_channel = 0;
  int feedback_channel = 0;
  LinearSpan command_span;
  LinearSpan feedback_span;
  Volts rest{0.0};     // output for venting; other than 0 V only if `relief` is named
  std::string relief;  // device that relieves the chamber if the source cannot vent; empty: none
  Nanoseconds feed_interval = std::chrono::milliseconds(400);
  Psi command_limit{60.0};  // inclusive; command() refuses more before anything is sent (Fault TB-CHAMBER-LIMIT)
  Origin origin = Origin::kHardware;
};

// Options of a pressure controller on a serial line, in addition to RegulatorOptions.
struct SerialControllerOptions {
  char unit = 'A';                             // its letter on the line
  int decimals = 2;                            // digits of a set-point in psi, as sent and as returned
  int pressure_field = 1, setpoint_field = 2;  // places in its answer, counted from 1 after the letter
  bool exhausts = true;                        // it has an exhaust valve and the command for it
  Nanoseconds reply_timeout = std::chrono::milliseconds(250);
};

struct TransducerOptions {
  std::string model;
  std::string serial;
  int channel = 1;
  LinearSpan span;
  Origin origin = Origin::kHardware;
};

// One quantity in registers of a Modbus device: a digital gauge's pressure, a thermometer's temperature.
struct ModbusQuantity {
  int function = 4;  // 3 or 4
  int address = 0;
  int spare = 0;  // readable registers after it (used to vary the length of RTU readings)
  RegisterFormat format;
  LinearScale scale;
};

struct GaugeOptions {
  std::string model;
  std::string serial;
  ModbusQuantity quantity;  // scaled to psi
  Origin origin = Origin::kHardware;
};

// Table of a calibration certificate: at `reading` add `correction`; expanded uncertainty U of the corrected value with
// coverage factor k. Linear between points; beyond the ends the value of the last point.
struct PressureCorrection {
  std::vector<double> reading_psi, correction_psi, expanded_uncertainty_psi;  // of equal length; readings rise
  double coverage_factor = 2.0;
  [[nodiscard]] bool empty() const { return reading_psi.empty(); }
  [[nodiscard]] Psi corrected(Psi reading) const;
  [[nodiscard]] double expanded_uncertainty(Psi reading) const;
};

struct SimulatedModuleFaults {      // test and nightly switches, all off by default
  long silent_after_requests = -1;  // answers this many requests, then none (the connection stays open)
  long dead_after_requests = -1;    // closes connections and refuses new ones; a serial line hangs up
  bool echoes = false;              // a serial line echoes what the client sends, as some adapters do
  FaultInjector inject = {};        // silent, late, corrupt, stale, refused (failure), busy; unplugged: TCP closes
                                    // connections when asked, a serial line is silent
};

}  // namespace tactbench::devices
