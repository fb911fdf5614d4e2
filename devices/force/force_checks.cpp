#include "devices/force/force_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "devices/device.h"
#include "devices/force/ati_calibration.h"

namespace tactbench::devices {

Wrench wrench_of(const SixAxes& axes) { return {{axes[0], axes[1], axes[2]}, {axes[3], axes[4], axes[5]}}; }

Wrench operator-(const Wrench& wrench, const Wrench& bias) {
  Wrench difference = wrench;
  for (std::size_t i = 0; i < 3; ++i) {
    difference.force_n[i] -= bias.force_n[i];
    difference.torque_nmm[i] -= bias.torque_nmm[i];
  }
  return difference;
}

void ForceSpread::add(const Wrench& record) {
  ++records_;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double off = record.force_n[i] - mean_[i];
    mean_[i] += off / records_;
    squares_[i] += off * (record.force_n[i] - mean_[i]);
  }
}

double ForceSpread::standard_deviation_n() const {
  if (records_ < 2) return 0.0;
  return std::sqrt(*std::max_element(squares_.begin(), squares_.end()) / (records_ - 1));
}

void check_records(int records) {
  if (records >= 1 && records <= kMaxForceRecords) return;
  throw Fault("TB-FORCE-RECORDS", kForceDevice,
              fmt::format("a reading of {} records was requested; 1 to {} are possible", records, kMaxForceRecords),
              "Correct the number of force records to average.");
}

void check_overload(const Wrench& load, const SixAxes& range, double share) {
  std::string beyond;
  for (std::size_t i = 0; i < 6; ++i) {
    const double limit = share * range[i];
    const double value = i < 3 ? load.force_n[i] : load.torque_nmm[i - 3];
    if (std::abs(value) <= limit) continue;  // NaN is beyond
    beyond += fmt::format("{}{} is {:.4g} {}, beyond {:.4g} ({:.0f} % of the calibration's range)",
                          beyond.empty() ? "" : "; ", kAxisNames[i], value, i < 3 ? "N" : "N*mm", limit, 100.0 * share);
  }
  if (beyond.empty()) return;
  throw Fault("TB-FORCE-OVERLOAD", kForceDevice, "the transducer is overloaded: " + beyond,
              "Take the load off. Beyond the range readings are wrong, and far beyond it the transducer breaks.");
}

void check_serial(const std::string& asked, const std::string& found, const std::string& where) {
  if (asked.empty() || asked == found) return;
  throw Fault("TB-FORCE-SERIAL", kForceDevice,
              fmt::format("the calibration of transducer '{}' was expected, {} has that of '{}'", asked, where, found),
              "Connect the right transducer, or correct its serial number in the bench file.");
}

}  // namespace tactbench::devices
