#include "devices/pressure/regulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {

void check_channel(const char* device, const char* what, int channel, int channels) {
  if (channel >= 0 && channel < channels) return;
  throw Fault("TB-MODULE-CHANNEL", device,
              fmt::format("{} channel {} of the {} was requested, the module has {}", what, channel, device, channels),
              "Correct the channel (counted from 0) in the bench file.");
}

void check_span(const char* device, const LinearSpan& span) {
  if (span.volts_high > span.volts_low && span.high > span.low) return;
  throw Fault("TB-MODULE-SPAN", device,
              fmt::format("the {}'s span from {:g} V = {:g} psi to {:g} V = {:g} psi does not rise", device,
                          span.volts_low.value(), span.low.value(), span.volts_high.value(), span.high.value()),
              "Correct the span in the bench file.");
}

void check_setpoint(Psi pressure, Psi limit, const std::string& unreachable, bool armed) {
  // Written so that NaN is refused too.
  const bool allowed = pressure >= Psi(0.0) && pressure <= limit;
  if (!allowed || !unreachable.empty()) {
    throw Fault(
        "TB-CHAMBER-LIMIT", "regulator",
        fmt::format("{:g} psi ({:.4g} kPa) was requested, {}; nothing was sent", pressure.value(),
                    kilopascals(pressure),
                    allowed ? unreachable
                            : fmt::format("allowed is 0 to {:g} psi ({:.4g} kPa)", limit.value(), kilopascals(limit))),
        "Correct the recipe, or the limit and span in the bench file.");
  }
  if (armed) return;
  throw Fault("TB-CHAMBER-NOT-ARMED", "regulator",
              fmt::format("{:g} psi ({:.4g} kPa) was requested while the regulator is not armed; nothing was sent",
                          pressure.value(), kilopascals(pressure)),
              "Arm it first; a failed exchange disarms it.");
}

Psi LinearSpan::pressure(Volts volts) const { return Psi(scale().physical(volts.value())); }
Volts LinearSpan::voltage(Psi pressure) const { return Volts(scale().raw(pressure.value())); }
Psi LinearSpan::driven(Volts volts) const { return pressure(std::clamp(volts, volts_low, volts_high)); }

Regulator::Regulator(AnalogModule& output, AnalogModule& input, RegulatorOptions options, Clock& clock)
    : output_(output), input_(input), options_(std::move(options)), clock_(clock) {
  check_channel("regulator", "output", options_.output_channel, output_.profile().outputs.channels);
  check_channel("regulator", "feedback", options_.feedback_channel, input_.profile().inputs.channels);
  check_span("regulator", options_.command_span);
  check_span("regulator", options_.feedback_span);
  output_.rest_at(options_.output_channel, options_.rest);
}

// The module's state after a failed exchange is not known: nothing more is written before the next arm().
template <class Act>
void Regulator::or_disarm(Act&& act) {
  try {
    act();
  } catch (...) {
    armed_ = false;
    throw;
  }
}

void Regulator::arm() {
  output_.bring_up();
  armed_ = true;
}

std::uint16_t Regulator::command(Psi pressure) {
  const LinearScale& scale = output_.profile().outputs.volts;
  const Volts volts = options_.command_span.voltage(pressure);
  const bool reachable = volts >= Volts(scale.low) && volts <= Volts(scale.high);
  check_setpoint(pressure, options_.command_limit,
                 reachable ? std::string()
                           : fmt::format("which needs {:g} V of an output of {:g} to {:g} V", volts.value(), scale.low,
                                         scale.high),
                 armed_);
  const std::uint16_t counts = output_.counts(volts);
  input_.forget_image();
  or_disarm([&] {
    if (pressure > Psi(0.0)) output_.close_dump();  // a vent has opened it
    output_.write(options_.output_channel, counts);
  });
  return counts;
}

void Regulator::keep_alive() {
  const Nanoseconds written = output_.last_write_time();
  if (armed_ && (written < Nanoseconds(0) || clock_.now() - written >= options_.feed_interval)) {
    or_disarm([&] { output_.feed(); });
  } else {
    input_.refresh(kSameImage);
  }
}

PressureReading Regulator::feedback() {
  input_.refresh(kSameImage);
  const Volts voltage = input_.input_volts(options_.feedback_channel);
  return {options_.feedback_span.pressure(voltage), voltage, input_.input(options_.feedback_channel).counts,
          input_.image_time()};
}

bool Regulator::vent() noexcept {
  input_.forget_image();  // its readings are older than this
  const bool zeroed = output_.zero_outputs();
  return output_.open_dump() && zeroed;
}

Identity Regulator::identity() const { return {"regulator", options_.model, options_.serial, "", options_.origin}; }

}  // namespace tactbench::devices
