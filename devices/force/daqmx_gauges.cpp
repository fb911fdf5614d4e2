#include "devices/force/daqmx_gauges.h"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>
#include <utility>

namespace tactbench::devices {

DaqmxGauges::DaqmxGauges(DaqmxGaugesOptions options, Clock& clock)
    : options_(std::move(options)),
      clock_(clock),
      api_(options_.library),
      device_(api_.device(options_.device, options_.expected_serial)),
      inputs_(api_) {
  inputs_.add_voltages(options_.channels, options_.terminal, options_.range);
  channels_ = inputs_.channels();
  if (channels_ == 6 || channels_ == 7) return;
  throw Fault("TB-DAQMX-CHANNELS", options_.device,
              fmt::format("a DAQ F/T has six gauges and may have a thermistor; {} makes {} inputs", options_.channels,
                          channels_),
              "Correct the channels in the bench file.");
}

GaugeSamples DaqmxGauges::read(int samples) {
  if (samples < 1) throw std::invalid_argument("a reading of the gauges takes at least one sample");
  GaugeSamples read;
  read.samples = samples;
  read.channels = channels_;
  read.time = clock_.now();
  read.volts.resize(static_cast<std::size_t>(samples) * static_cast<std::size_t>(channels_));
  if (samples != samples_) {
    samples_ = 0;
    inputs_.finite_samples(options_.sample_rate_hz, samples);
    inputs_.commit();
    samples_ = samples;
  }
  const std::chrono::duration<double> duration(samples / options_.sample_rate_hz);
  const Nanoseconds timeout = options_.timeout + std::chrono::duration_cast<Nanoseconds>(duration);
  ++exchanges_;
  try {
    inputs_.start();
    inputs_.read(samples, timeout, read.volts);
  } catch (const Fault& fault) {
    inputs_.stop();
    const auto* error = dynamic_cast<const DaqmxError*>(&fault);
    if (error != nullptr && error->timed_out()) clock_.reply_lost(timeout);
    throw;
  }
  inputs_.stop();
  return read;
}

Identity DaqmxGauges::identity() const {
  return {"gauge source", "NI " + device_.product_type, device_.serial, "",
          device_.simulated ? Origin::kSimulated : options_.origin};
}

}  // namespace tactbench::devices
