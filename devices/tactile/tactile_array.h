// A tactile array behind its scanner. Each call returns one set of K scans of all taxels, as raw counts.
#pragma once

#include <cstdint>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/units.h"

namespace tactbench::devices {

struct ScanSet {
  int rows = 0;
  int columns = 0;
  int scans = 0;                              // K
  std::vector<std::uint16_t> counts;          // scans x rows x columns, row-major, scan slowest
  std::vector<std::uint32_t> frame_counters;  // K: the scanner's own
  std::uint32_t device_time_us = 0;           // scanner's clock at the first report of the first scan
  std::uint8_t status = 0;                    // all report status bytes, or-ed
  Nanoseconds time{0};                        // process time when the first scan was requested
};

class TactileArray {
 public:
  virtual ~TactileArray() = default;
  // Requests K fresh scans one after the other; nothing from a queue is used. Bounded by the scanner's
  // frame timeout times K. Throws Fault TB-SCANNER-TIMEOUT, TB-SCANNER-LOST, TB-SCANNER-CORRUPT.
  [[nodiscard]] virtual ScanSet read(int scans) = 0;
  [[nodiscard]] virtual int rows() const = 0;
  [[nodiscard]] virtual int columns() const = 0;
  // volts = counts * volts_per_count.
  [[nodiscard]] virtual Volts volts_per_count() const = 0;
  [[nodiscard]] virtual std::uint64_t exchanges() const = 0;
  // How often each row's relay closed since it was opened; empty where the scanner does not count.
  [[nodiscard]] virtual std::vector<std::uint64_t> relay_operations() const { return {}; }
  [[nodiscard]] virtual Identity identity() const = 0;
};

}  // namespace tactbench::devices
