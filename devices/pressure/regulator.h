// Pneumax 171E2N.T.D.0009 (0-9 bar for 0-10 V, monitor output alike) on two channels of an analog module, and a
// transducer on a third as pressure reference. Not verified on hardware.
#pragma once

#include <string>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_source.h"

namespace tactbench::devices {

struct LinearSpan {  // pressure = low + (voltage - volts_low) / (volts_high - volts_low) * (high - low)
  Volts volts_low{0.0};
  Volts volts_high{10.0};
  Psi low{0.0};
  Psi high{0.0};
  [[nodiscard]] Psi pressure(Volts volts) const;
  [[nodiscard]] Volts voltage(Psi pressure) const;
};

struct RegulatorOptions {
  std::string model = "Pneumax 171E2N.T.D.0009";
  std::string serial;
  int output_channel = 0;
  int feedback_channel = 0;
  LinearSpan command_span;
  LinearSpan feedback_span;
  Nanoseconds feed_interval = std::chrono::milliseconds(400);
  Psi command_limit{60.0};  // inclusive; command() refuses more before anything is sent (Fault TB-CHAMBER-LIMIT)
  Origin origin = Origin::kHardware;
};

class Regulator final : public PressureSource {
 public:
  Regulator(AnalogModule& module, RegulatorOptions options, Clock& clock);
  std::uint16_t command(Psi pressure) override;
  void keep_alive() override;
  [[nodiscard]] PressureReading feedback() override;
  [[nodiscard]] Nanoseconds last_fed() const override { return module_.last_write_time(); }
  [[nodiscard]] bool vent() noexcept override;
  [[nodiscard]] Identity identity() const override;

 private:
  AnalogModule& module_;
  RegulatorOptions options_;
  Clock& clock_;
};

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

}  // namespace tactbench::devices
