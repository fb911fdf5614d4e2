// Pneumax 171E2N.T.D.0009 (0-9 bar for 0-10 V, monitor output the same) on an output and an input of analog modules.
// Not verified on hardware.
#pragma once

#include <string>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/options.h"
#include "devices/pressure/pressure_source.h"

namespace tactbench::devices {

// Feedback and reference may share one input image; an image up to this age serves both. Far below any settling time.
inline constexpr Nanoseconds kSameImage = std::chrono::microseconds(500);

// Throw Fault TB-MODULE-CHANNEL and TB-MODULE-SPAN, naming `device`.
void check_channel(const char* device, const char* what, int channel, int channels);
void check_span(const char* device, const LinearSpan& span);
// Throws Fault TB-CHAMBER-LIMIT unless `pressure` is between 0 and `limit` and `unreachable` (a reason from other
// limits) is empty, TB-CHAMBER-NOT-ARMED unless `armed`.
void check_setpoint(Psi pressure, Psi limit, const std::string& unreachable, bool armed);

class Regulator final : public PressureSource {
 public:
  // `output` drives the regulator, `input` (often of the same module) reads its monitor.
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
  [[nodiscard]] std::uint64_t exchanges() const override { return 0; }

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
