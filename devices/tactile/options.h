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

struct ArrayOptions {           // of every kind
  std::string expected_serial;  // of an NI card hexadecimal; empty: any; otherwise another is Fault TB-SCANNER-SERIAL
  int rows = 16;
  int columns = 16;
  // Per scan; of an NI card per row, beyond the time that the samples take; of a frame source per answer.
  Nanoseconds frame_timeout = std::chrono::milliseconds(500);
  Origin origin = Origin::kHardware;  // an NI card that its driver simulates is kSimulated anyway
};

struct HidScannerOptions : ArrayOptions {
  std::string model = "tactbench HID scanner";
};

struct DaqmxScannerOptions : ArrayOptions {
  std::string library;  // empty: NI's own (daqmx_api.h)
  std::string device = "Dev1";
  std::string column_channels = "Dev1/ai0:15";
  std::string row_lines = "Dev1/port0/line0:15";
  DaqmxTerminal terminal = DaqmxTerminal::kRse;
  Volts range{10.0};                                  // inputs measure -range to +range; counts cover 0 to range
  bool relays_active_low = false;                     // a relay closes on 0
  double sample_rate_hz = 10'000;                     // samples of all columns per second
  double convert_rate_hz = 0;                         // from column to column; 0: the driver chooses
  int samples_per_row = 10;                           // averaged
  Nanoseconds settle = std::chrono::milliseconds(5);  // from closing a relay to the first sample
};

struct FrameSourceOptions : ArrayOptions {
  std::string address = "tcp:127.0.0.1:5800";  // or "unix:PATH" (byte_stream.h)
  Nanoseconds connect_timeout = std::chrono::seconds(2);
};

enum class ScannerKind { kHid, kDaqmx, kFrameSource };  // a row each in bench/config/config_scanner.cpp

struct ScannerOptions : HidScannerOptions {  // geometry, serial and timeout count for every kind
  ScannerKind kind = ScannerKind::kHid;
  HidAddress address;
  std::string socket;  // HID reports over a local socket instead: a simulated scanner in another process
  DaqmxScannerOptions daqmx;
  FrameSourceOptions frame_source;
};

struct SimulatedScannerFaults {  // test and nightly switches, all off by default
  long silent_after_scans = -1;  // answers this many scans, then none
  long corrupt_scan = -1;        // flips a bit in one report of this scan (0-based)
  long drop_report_scan = -1;    // omits one report of this scan
  long unplug_after_scans = -1;  // closes the socket
  FaultInjector inject = {};     // silent, stale, corrupt, torn (a report is missing); unplugged: connections close
};

}  // namespace tactbench::devices
