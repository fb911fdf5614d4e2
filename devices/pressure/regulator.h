// Pneumax 171E2N.T.D.0009 (0-9 bar for 0-10 V, monitor output alike) on an output and an input of analog modules. Not
// verified on hardware.
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

// Feedback and reference may stand in one input image; a reading this young serves both. Far below any settling time.
inline constexpr Nanoseconds kSameImage = std::chrono::microseconds(500);

// Throw Fault TB-MODULE-CHANNEL and TB-MODULE-SPAN, naming `device`.
void check_channel(const char* device, const char* what, int channel, int channels);
void check_span(const char* device, const LinearSpan& span);

class Regulator final : public PressureSource {
 public:
  // `output` drives it, `input` (often the same module) reads its monitor.
  Regulator(AnalogModule& output, AnalogModule& input, RegulatorOptions options, Clock& clock);
  void arm() override;
  void disarm() noexcept override { armed_ = false; }
  [[nodiscard]] bool armed() const override { return armed_; }
  std::uint16_t command(Psi pressure) override;
  void keep_alive() override;
  [[nodiscard]] PressureReading feedback() override;
  [[nodiscard]] Nanoseconds last_fed() const override { return output_.last_write_time(); }
  [[nodiscard]] bool vent() noexcept override;
  [[nodiscard]] Identity identity() const override;

 private:
  template <class Act>
  void or_disarm(Act&& act);
  AnalogModule& output_;
  AnalogModule& input_;
  RegulatorOptions options_;
  Clock& clock_;
  bool armed_ = false;
};

}  // namespace tactbench::devices
