#include "devices/pressure/regulator.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "devices/fault.h"

namespace tactbench::devices {
namespace {

// Feedback and reference stand in one input image; a reading this young serves both. Far below any settling time.
constexpr Nanoseconds kSameImage = std::chrono::microseconds(500);

PressureReading reading(const AnalogModule& module, int channel, const LinearSpan& span) {
  const std::int32_t counts = module.input(channel);
  const Volts voltage = module.volts(counts);
  return {span.pressure(voltage), voltage, counts, module.image_time()};
}

void check(const char* device, const char* what, int channel, int channels) {
  if (channel >= 0 && channel < channels) return;
  throw Fault("TB-MODULE-CHANNEL", device,
              fmt::format("{} channel {} of the {} was asked for, the module has {}", what, channel, device, channels),
              "Correct the channel (counted from 0) in the bench file.");
}

void check(const char* device, const LinearSpan& span) {
  if (span.volts_high > span.volts_low && span.high > span.low) return;
  throw Fault("TB-MODULE-SPAN", device,
              fmt::format("the {}'s span from {:g} V = {:g} psi to {:g} V = {:g} psi does not rise", device,
                          span.volts_low.value(), span.low.value(), span.volts_high.value(), span.high.value()),
              "Correct the span in the bench file.");
}

}  // namespace

Psi LinearSpan::pressure(Volts volts) const {
  return low + (high - low) * ((volts - volts_low) / (volts_high - volts_low));
}

Volts LinearSpan::voltage(Psi pressure) const {
  return volts_low + (volts_high - volts_low) * ((pressure - low) / (high - low));
}

Regulator::Regulator(AnalogModule& module, RegulatorOptions options, Clock& clock)
    : module_(module), options_(std::move(options)), clock_(clock) {
  check("regulator", "output", options_.output_channel, module_.profile().outputs);
  check("regulator", "feedback", options_.feedback_channel, module_.profile().inputs);
  check("regulator", options_.command_span);
  check("regulator", options_.feedback_span);
}

std::uint16_t Regulator::command(Psi pressure) {
  // Written so that NaN is refused too.
  const bool allowed = pressure >= Psi(0.0) && pressure <= options_.command_limit;
  const Volts volts = options_.command_span.voltage(pressure);
  const bool reachable = volts >= Volts(0.0) && volts <= module_.profile().volts_full_scale;
  if (!allowed || !reachable) {
    throw Fault("TB-CHAMBER-LIMIT", "regulator",
                fmt::format("{:g} psi was asked for, {}; nothing was sent", pressure.value(),
                            allowed ? fmt::format("which needs {:g} V of an output of 0 to {:g} V", volts.value(),
                                                  module_.profile().volts_full_scale.value())
                                    : fmt::format("allowed is 0 to {:g} psi", options_.command_limit.value())),
                "Correct the recipe, or the limit and span in the bench file.");
  }
  const std::uint16_t counts = module_.counts(volts);
  module_.write(options_.output_channel, counts);
  return counts;
}

void Regulator::keep_alive() {
  const Nanoseconds written = module_.last_write_time();
  if (written < Nanoseconds(0) || clock_.now() - written >= options_.feed_interval) {
    module_.feed();
  } else {
    module_.refresh(kSameImage);
  }
}

PressureReading Regulator::feedback() {
  module_.refresh(kSameImage);
  return reading(module_, options_.feedback_channel, options_.feedback_span);
}

bool Regulator::vent() noexcept { return module_.zero_outputs(); }

Identity Regulator::identity() const { return {"regulator", options_.model, options_.serial, "", options_.origin}; }

ModuleTransducer::ModuleTransducer(AnalogModule& module, TransducerOptions options)
    : module_(module), options_(std::move(options)) {
  check("pressure reference", "input", options_.channel, module_.profile().inputs);
  check("pressure reference", options_.span);
}

PressureReading ModuleTransducer::read() {
  module_.refresh(kSameImage);
  return reading(module_, options_.channel, options_.span);
}

Identity ModuleTransducer::identity() const {
  return {"pressure reference", options_.model, options_.serial, "", options_.origin};
}

}  // namespace tactbench::devices
