// Options of the scanner, as a bench file states them: an HID scanner, the paper's relays on an NI card, or a frame
// source; and the faults of a simulated one.
#pragma once

#include <chrono>
#include <string>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/fault_injection.h"
#include "devices/units.h"
#include "devices/wire/options.h"

namespace tactbench::devices {

struct HidScannerOptions {
  std::string model = "tactbench HID scanner";
  std::string expected_serial;  // empty: any; otherwise another serial is Fault TB-SCANNER-SERIAL
  int rows = 16;
  int columns = 16;
  Nanoseconds frame_timeout = std::chrono::milliseconds(500);  // per scan
  Origin origin = Origin::kHardware;
};

struct DaqmxScannerOptions {
  std::string library;  // empty: NI's own (daqmx_api.h)
  std::string device = "Dev1";
  std::string expected_serial;  // hexadecimal; empty: any
  std::string column_channels = "Dev1/ai0:15";
  std::string row_lines = "Dev1/port0/line0:15";
  int rows = 16;
  int columns = 16;
  DaqmxTerminal terminal = DaqmxTerminal::kRse;
  Volts range{10.0};                                     // inputs measure -range to +range; counts cover 0 to range
  bool relays_active_low = false;                        // a relay closes on 0
  double sample_rate_hz = 10'000;                        // samples of all columns per second
  double convert_rate_hz = 0;                            // from column to column; 0: the driver chooses
  int samples_per_row = 10;                              // averaged
  Nanoseconds settle = std::chrono::milliseconds(5);     // from closing a relay to the first sample
  Nanoseconds timeout = std::chrono::milliseconds(500);  // per row, beyond the time that the samples take
  Origin origin = Origin::kHardware;                     // a device that NI's driver simulates is kSimulated anyway
};

struct FrameSourceOptions {
  std::string address = "tcp:127.0.0.1:5800";  // or "unix:PATH" (stream_link.h)
  std::string expected_serial;                 // empty: any; otherwise another serial is Fault TB-SCANNER-SERIAL
  int rows = 16;
  int columns = 16;
  Nanoseconds connect_timeout = std::chrono::seconds(2);
  Nanoseconds frame_timeout = std::chrono::milliseconds(500);  // per answer
  Origin origin = Origin::kHardware;
};

struct SimulatedScannerFaults {  // test and nightly switches, all off by default
  long silent_after_scans = -1;  // answers this many scans, then none
  long corrupt_scan = -1;        // flips a bit in one report of this scan (0-based)
  long drop_report_scan = -1;    // omits one report of this scan
  long unplug_after_scans = -1;  // closes the socket
  FaultInjector inject = {};     // silent, stale, corrupt, torn (a report is missing); unplugged: connections close
};

}  // namespace tactbench::devices
