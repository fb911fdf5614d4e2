// Gauge voltages of a DAQ F/T acquired by an NI card: six differential inputs, and a thermistor as the seventh if it is
// wired. Not verified on hardware.
#pragma once

#include <string>

#include "devices/force/gauge_source.h"
#include "devices/force/options.h"
#include "devices/wire/daqmx/daqmx_api.h"

namespace tactbench::devices {

class DaqmxGauges final : public GaugeSource {
 public:
  // Throws the faults of DaqmxApi, and TB-DAQMX-CHANNELS when the number of channels is neither 6 nor 7.
  DaqmxGauges(DaqmxGaugesOptions options, Clock& clock);
  // Throws DaqmxError, Fault TB-DAQMX-SHORT; std::invalid_argument below 1 sample.
  [[nodiscard]] GaugeSamples read(int samples) override;
  [[nodiscard]] int channels() const override { return channels_; }
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] Identity identity() const override;
  [[nodiscard]] const std::vector<std::string>& warnings() const { return api_.warnings(); }

 private:
  DaqmxGaugesOptions options_;
  Clock& clock_;
  DaqmxApi api_;
  DaqmxDevice device_;
  DaqmxTask inputs_;
  int channels_ = 0;
  int samples_ = 0;  // number for which the task is set up
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
