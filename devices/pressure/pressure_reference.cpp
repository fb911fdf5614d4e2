#include "devices/pressure/pressure_reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "devices/device.h"
#include "devices/pressure/regulator.h"

namespace tactbench::devices {
namespace {

// The table's value at `x`: linear between points, constant beyond them.
double interpolate(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
  const auto above = std::upper_bound(xs.begin(), xs.end(), x);
  if (above == xs.begin()) return ys.front();
  if (above == xs.end()) return ys.back();
  const auto i = static_cast<std::size_t>(above - xs.begin());
  return ys[i - 1] + (ys[i] - ys[i - 1]) * (x - xs[i - 1]) / (xs[i] - xs[i - 1]);
}

}  // namespace

ModuleTransducer::ModuleTransducer(AnalogModule& module, TransducerOptions options)
    : module_(module), options_(std::move(options)) {
  check_channel("pressure reference", "input", options_.channel, module_.profile().inputs.channels);
  check_span("pressure reference", options_.span);
}

PressureReading ModuleTransducer::read() {
  module_.refresh(kSameImage);
  const Volts voltage = module_.input_volts(options_.channel);
  return {options_.span.pressure(voltage), voltage, module_.input(options_.channel).counts, module_.image_time()};
}

namespace {
template <class Options>
Identity reference_identity(const Options& options) {
  return {"pressure reference", options.model, options.serial, "", options.origin};
}
}  // namespace

Identity ModuleTransducer::identity() const { return reference_identity(options_); }
Identity ModbusGauge::identity() const { return reference_identity(options_); }
Identity FeedbackReference::identity() const { return reference_identity(options_); }

RegisterValue read_quantity(ModbusLink& link, const ModbusQuantity& quantity) {
  std::array<std::uint16_t, 2> words{};
  const auto into = std::span(words).first(quantity.format.words());
  const std::size_t readable = into.size() + static_cast<std::size_t>(quantity.spare);
  if (quantity.function == 3) {
    link.read_holding_registers(quantity.address, into, readable);
  } else {
    link.read_input_registers(quantity.address, into, readable);
  }
  RegisterValue value = decode_register(quantity.format, into);
  value.value = quantity.scale.physical(value.value);
  if (std::isfinite(value.value)) return value;
  throw Fault("TB-MODBUS-VALUE", link.peer(),
              fmt::format("register 0x{:04X} of {} does not hold a number", quantity.address, link.peer()),
              "Check type, word order and address in the bench file, and that the instrument reports no error.");
}

ModbusGauge::ModbusGauge(std::unique_ptr<ModbusLink> link, GaugeOptions options, Clock& clock)
    : link_(std::move(link)), options_(std::move(options)), clock_(clock) {}

PressureReading ModbusGauge::read() {
  const Nanoseconds time = clock_.now();
  const RegisterValue value = read_quantity(*link_, options_.quantity);
  return {Psi(value.value), Volts(0.0), value.counts, time};
}

Psi PressureCorrection::corrected(Psi reading) const {
  return empty() ? reading : reading + Psi(interpolate(reading_psi, correction_psi, reading.value()));
}

double PressureCorrection::expanded_uncertainty(Psi reading) const {
  return empty() ? std::nan("") : interpolate(reading_psi, expanded_uncertainty_psi, reading.value());
}

PressureReading CorrectedReference::read() {
  PressureReading reading = reference_->read();
  reading.pressure = correction_.corrected(reading.pressure);
  return reading;
}

}  // namespace tactbench::devices
