// `devices scan`: lists what is attached to this computer or answers at the given addresses.
#pragma once

#include <string>
#include <vector>

namespace tactbench::bench {

struct ScanEntry {
  std::string kind;   // "serial port", "HID device", "Modbus TCP", "NI-DAQmx"
  std::string where;  // as written in a bench file
  std::string what;
};

// Opens nothing but the Modbus hosts given ("HOST" or "HOST:PORT", unit 1 is asked for a register) and NI's library.
std::vector<ScanEntry> scan_devices(const std::vector<std::string>& modbus_hosts);

}  // namespace tactbench::bench
