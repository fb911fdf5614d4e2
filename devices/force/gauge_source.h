// Source of a DAQ F/T's gauge voltages: six strain gauges and, if the transducer has one, a thermistor as the seventh
// channel. The real source is NI-DAQmx; the driver (daq_ft.h) works with any source.
#pragma once

#include <cstdint>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"

namespace tactbench::devices {

struct GaugeSamples {
  int samples = 0;            // as requested
  int channels = 0;           // 6, or 7: the thermistor last
  std::vector<double> volts;  // samples x channels, row-major, oldest sample first; finite
  Nanoseconds time{0};        // process time when the first sample was requested
};

class GaugeSource {
 public:
  virtual ~GaugeSource() = default;
  // Acquires `samples` (at least 1) fresh samples of all channels; nothing from a buffer is used. Bounded by the
  // source's own timeout. Throws the source's own Faults, which the driver passes on.
  [[nodiscard]] virtual GaugeSamples read(int samples) = 0;
  // Constant during the life of the source: 6, or 7 when the thermistor is wired too.
  [[nodiscard]] virtual int channels() const = 0;
  [[nodiscard]] virtual std::uint64_t exchanges() const = 0;
  // Identity of the interface card, not of the transducer.
  [[nodiscard]] virtual Identity identity() const = 0;
};

}  // namespace tactbench::devices
