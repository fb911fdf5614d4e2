// Checks, means and spread shared by all force drivers: number of records, load against the rated range, serial number.
#pragma once

#include <array>
#include <string>

#include "devices/force/force_sensor.h"
#include "devices/force/options.h"

namespace tactbench::devices {

inline constexpr const char* kForceDevice = "force sensor";

Wrench wrench_of(const SixAxes& axes);
Wrench operator-(const Wrench& wrench, const Wrench& bias);

// The spread of records that are averaged (Welford).
class ForceSpread {
 public:
  void add(const Wrench& record);
  [[nodiscard]] double standard_deviation_n()
      const;  // of the force axis with the largest standard deviation; 0 below two records

 private:
  int records_ = 0;
  std::array<double, 3> mean_{}, squares_{};
};

// Throws Fault TB-FORCE-RECORDS unless 1 <= records <= kMaxForceRecords.
void check_records(int records);
// Compares `load`, in the frame of `range` (N, N*mm), with share * range of each axis. Throws Fault TB-FORCE-OVERLOAD.
void check_overload(const Wrench& load, const SixAxes& range, double share);
// Throws Fault TB-FORCE-SERIAL if the expected serial number is not empty and another one is found.
void check_serial(const std::string& asked, const std::string& found, const std::string& where);

}  // namespace tactbench::devices
