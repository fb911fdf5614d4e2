// `devices check` opens each instrument of a bench read-only, identifies it and reads its zero; `devices scan` lists
// what is attached.
#pragma once

#include <string>
#include <vector>

#include "bench/rig/rig.h"

namespace tactbench::bench {

struct DeviceCheck {
  enum class State { kOk, kWarning, kAbsent, kWrong };  // warning: it works, and is overdue for calibration
  std::string role;
  State state = State::kOk;
  std::string found;               // model, serial, firmware
  std::string reading;             // now, with unit
  std::vector<std::string> notes;  // due dates, warnings
  std::string remedy;              // what to do, when not ok
};

const char* to_string(DeviceCheck::State state);

// Writes nothing to any instrument: no watchdog, no mode, no output. `today` as 2026-01-31, for due dates. Bounded by
// the instruments' timeouts.
std::vector<DeviceCheck> check_devices(Rig& rig, const std::string& today);

// "mean 0.020 V, highest 0.027 V": all taxels of one scan or several.
std::string array_summary(const devices::ScanSet& scan, devices::Volts volts_per_count);

// `devices scan`: lists what is attached to this computer or answers at the given addresses.
struct ScanEntry {
  std::string kind;   // "serial port", "HID device", "Modbus TCP", "NI-DAQmx"
  std::string where;  // as written in a bench file
  std::string what;
};

// Opens nothing but the Modbus hosts given ("HOST" or "HOST:PORT", unit 1 is asked for a register) and NI's library.
std::vector<ScanEntry> scan_devices(const std::vector<std::string>& modbus_hosts);

}  // namespace tactbench::bench
