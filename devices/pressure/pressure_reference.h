// Pressure references: a transducer on an input of an analog module, a digital gauge over Modbus, the pressure source's
// own transducer, and each of them with the corrections of its certificate. Not verified on hardware.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/options.h"
#include "devices/pressure/pressure_source.h"
#include "devices/wire/modbus/modbus_value.h"

namespace tactbench::devices {

class ModuleTransducer final : public PressureReference {
 public:
  ModuleTransducer(AnalogModule& module, TransducerOptions options);
  [[nodiscard]] PressureReading read() override;
  [[nodiscard]] Identity identity() const override;

 private:
  AnalogModule& module_;
  TransducerOptions options_;
};

// One exchange. Throws Fault; TB-MODBUS-VALUE when a float is not a number.
RegisterValue read_quantity(ModbusLink& link, const ModbusQuantity& quantity);

class ModbusGauge final : public PressureReference {
 public:
  ModbusGauge(std::unique_ptr<ModbusLink> link, GaugeOptions options, Clock& clock);
  [[nodiscard]] PressureReading read() override;
  [[nodiscard]] Identity identity() const override;
  [[nodiscard]] const ModbusLink& link() const { return *link_; }

 private:
  std::unique_ptr<ModbusLink> link_;
  GaugeOptions options_;
  Clock& clock_;
};

// The source's own transducer, used if there is no independent one.
class FeedbackReference final : public PressureReference {
 public:
  FeedbackReference(PressureSource& source, TransducerOptions options)
      : source_(source), options_(std::move(options)) {}
  [[nodiscard]] PressureReading read() override { return source_.feedback(); }
  [[nodiscard]] Identity identity() const override;

 private:
  PressureSource& source_;
  TransducerOptions options_;
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
