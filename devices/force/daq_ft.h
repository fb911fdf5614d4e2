// Driver of the ATI DAQ F/T: six gauge voltages from any GaugeSource, converted to a wrench by the transducer's .cal
// file. Not verified on hardware.
#pragma once

#include <memory>
#include <string>

#include "devices/force/ati_matrix.h"
#include "devices/force/force_checks.h"
#include "devices/force/force_sensor.h"
#include "devices/force/gauge_source.h"
#include "devices/force/options.h"
#include "devices/units.h"

namespace tactbench::devices {

class DaqFt final : public ForceSensor {
 public:
  // Reads nothing. Throws Fault TB-FORCE-SERIAL, TB-FORCE-GAUGES (the source does not have six gauges, or lacks the
  // thermistor that compensation needs).
  DaqFt(std::unique_ptr<GaugeSource> source, AtiCalibration calibration, DaqFtOptions options);
  // `raw` holds gauge volts as acquired, before compensation and bias. Saturation and overload are checked for every
  // sample, overload in the transducer's frame. Bounded by the source's timeout; the source's faults pass through.
  [[nodiscard]] ForceReading read(int records) override;
  // The bias is a vector of voltages, taken after compensation.
  ForceReading bias(int records) override;
  // In the transducer's frame, even with a tool transform.
  [[nodiscard]] SixAxes range() const override { return range_; }
  [[nodiscard]] std::string calibration_serial() const override { return calibration_.serial; }
  [[nodiscard]] std::uint64_t exchanges() const override { return source_->exchanges(); }
  [[nodiscard]] Identity identity() const override;

 private:
  struct Means {
    ForceReading reading;  // wrench not yet filled
    Vector6 gauges;        // compensated
  };
  Means acquire(int records, const Vector6& bias);
  std::unique_ptr<GaugeSource> source_;
  AtiCalibration calibration_;
  DaqFtOptions options_;
  Matrix6 matrix_;  // transducer's frame
  Matrix6 tool_;
  SixAxes range_;
  Vector6 bias_ = Vector6::Zero();
};

}  // namespace tactbench::devices
