// The kinds of pressure reference: a transducer on an input of an analog module, a digital gauge by Modbus, and either
// of them with its certificate's corrections. Not verified on hardware.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_source.h"
#include "devices/pressure/regulator.h"
#include "devices/wire/modbus_value.h"

namespace tactbench::devices {

struct TransducerOptions {
  std::string model;
  std::string serial;
  int channel = 1;
  LinearSpan span;
  Origin origin = Origin::kHardware;
};

class ModuleTransducer final : public PressureReference {
 public:
  ModuleTransducer(AnalogModule& module, TransducerOptions options);
  [[nodiscard]] PressureReading read() override;
  [[nodiscard]] Identity identity() const override;

 private:
  AnalogModule& module_;
  TransducerOptions options_;
};

// One quantity in registers of a Modbus device: a digital gauge's pressure, a thermometer's temperature.
struct ModbusQuantity {
  int function = 4;  // 3 or 4
  int address = 0;
  int spare = 0;  // readable registers behind it (RTU readings alternate their length)
  RegisterFormat format;
  LinearScale scale;
};
// One exchange. Throws Fault; TB-MODBUS-VALUE when a float is not a number.
RegisterValue read_quantity(ModbusLink& link, const ModbusQuantity& quantity);

struct GaugeOptions {
  std::string model;
  std::string serial;
  ModbusQuantity quantity;  // scaled to psi
  Origin origin = Origin::kHardware;
};

class ModbusGauge final : public PressureReference {
 public:
  ModbusGauge(std::unique_ptr<ModbusLink> link, GaugeOptions options, Clock& clock);
  [[nodiscard]] PressureReading read() override;
  [[nodiscard]] Identity identity() const override;
  [[nodiscard]] std::uint64_t exchanges() const { return link_->exchanges(); }

 private:
  std::unique_ptr<ModbusLink> link_;
  GaugeOptions options_;
  Clock& clock_;
};

// What a certificate says: at `reading` add `correction`; expanded uncertainty U of the corrected value with coverage
// factor k. Between points linear, beyond them the last one's.
struct PressureCorrection {
  std::vector<double> reading_psi, correction_psi, expanded_uncertainty_psi;  // equally long; readings rise
  double coverage_factor = 2.0;
  [[nodiscard]] bool empty() const { return reading_psi.empty(); }
  [[nodiscard]] Psi corrected(Psi reading) const;
  [[nodiscard]] double expanded_uncertainty(Psi reading) const;
};

class CorrectedReference final : public PressureReference {
 public:
  CorrectedReference(std::unique_ptr<PressureReference> reference, PressureCorrection correction)
      : reference_(std::move(reference)), correction_(std::move(correction)) {}
  [[nodiscard]] PressureReading read() override;
  [[nodiscard]] Identity identity() const override { return reference_->identity(); }

 private:
  std::unique_ptr<PressureReference> reference_;
  PressureCorrection correction_;
};

}  // namespace tactbench::devices
