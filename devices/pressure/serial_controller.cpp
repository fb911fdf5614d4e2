#include "devices/pressure/serial_controller.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "devices/device.h"
#include "devices/pressure/regulator.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

constexpr const char* kControllerDevice = "regulator";
constexpr std::size_t kQuoted = 60;  // of a damaged answer
constexpr int kControllerVentTries = 2;

double setpoint_step(const SerialControllerOptions& options) { return std::pow(10.0, -options.decimals); }

}  // namespace

SerialController::SerialController(std::function<std::unique_ptr<ByteStream>()> open, RegulatorOptions regulator,
                                   SerialControllerOptions options, Clock& clock)
    : open_(std::move(open)), regulator_(std::move(regulator)), options_(options), clock_(clock) {}

std::string SerialController::read_line(const std::string& asked) {
  const RealTime end = std::chrono::steady_clock::now() + options_.reply_timeout;
  std::string line;
  for (std::array<std::uint8_t, 64> bytes{};;) {
    const std::size_t got = stream_->read(bytes, left_until(end));
    if (got == 0) {
      clock_.reply_lost(options_.reply_timeout);
      throw Fault("TB-CONTROLLER-TIMEOUT", kControllerDevice,
                  fmt::format("'{}' was sent to the pressure controller on {}: {} within {:g} ms", asked,
                              stream_->description(), line.empty() ? "no answer came" : "no whole answer came",
                              in_milliseconds(options_.reply_timeout)));
    }
    for (const std::uint8_t byte : std::span(bytes).first(got)) {
      if (byte == kLineEnd) return line;
      line += static_cast<char>(byte);
    }
    if (line.size() > kMaxLineBytes) return line;
  }
}

ControllerFrame SerialController::exchange(const ControllerRequest& request) {
  if (!stream_) stream_ = open_();
  stream_->discard();
  const std::string sent = encode_request(options_.unit, request, options_.decimals);
  const std::string asked = sent.substr(0, sent.size() - 1);
  const Nanoseconds time = clock_.now();
  stream_->write(std::span(reinterpret_cast<const std::uint8_t*>(sent.data()), sent.size()));
  ++exchanges_;
  const std::string line = read_line(asked);
  const ControllerAnswer answer =
      decode_answer(line, options_.unit, {options_.pressure_field, options_.setpoint_field});
  if (!answer.frame) {
    throw Fault(answer.refused ? "TB-CONTROLLER-REFUSED" : "TB-CONTROLLER-PROTOCOL", kControllerDevice,
                fmt::format("'{}' was sent to the pressure controller on {}: '{}' came, which {}", asked,
                            stream_->description(), line.substr(0, kQuoted),
                            answer.refused ? "refuses it" : fmt::format("is no reading of unit {}", options_.unit)));
  }
  frame_ = *answer.frame;
  frame_time_ = time;
  return frame_;
}

// What the controller does after a failed exchange is not known: nothing more is sent before the next arm().
ControllerFrame SerialController::ask(const ControllerRequest& request) {
  try {
    return exchange(request);
  } catch (const Fault& fault) {
    armed_ = false;
    frame_time_ = Nanoseconds(-1);
    if (fault.id().starts_with("TB-SERIAL-")) stream_.reset();
    throw;
  }
}

void SerialController::check_holds(const ControllerFrame& frame) {
  const bool same = std::abs(frame.setpoint - setpoint_.value()) < 0.6 * setpoint_step(options_);
  const bool regulates = setpoint_ == Psi(0.0) || (!frame.has("EXH") && !frame.has("HLD"));
  if (same && regulates) return;
  armed_ = false;
  throw Fault(
      "TB-CONTROLLER-READBACK", kControllerDevice,
      fmt::format("the pressure controller on {} was set to {:g} psi: it reads back {:g} psi{}", stream_->description(),
                  setpoint_.value(), frame.setpoint, regulates ? "" : " with its valves held"));
}

void SerialController::set(Psi pressure) {
  const double step = setpoint_step(options_);
  setpoint_ = Psi(std::round(pressure.value() / step) * step);
  check_holds(ask({ControllerAct::kSetpoint, setpoint_.value()}));
  last_fed_ = frame_time_;
}

void SerialController::arm() {
  (void)ask({});
  setpoint_ = Psi(0.0);  // what an earlier run left is not gone back to
  last_fed_ = Nanoseconds(-1);
  armed_ = true;
}

std::uint16_t SerialController::command(Psi pressure) {
  const Psi full = regulator_.command_span.high;
  check_setpoint(pressure, regulator_.command_limit,
                 pressure <= full ? std::string() : fmt::format("and its full scale is {:g} psi", full.value()),
                 armed_);
  if (pressure > Psi(0.0) && (frame_.has("EXH") || frame_.has("HLD"))) (void)ask({ControllerAct::kCancel});
  set(pressure);
  return static_cast<std::uint16_t>(std::lround(setpoint_.value() / setpoint_step(options_)));
}

void SerialController::keep_alive() {
  if (!armed_ || (last_fed_ >= Nanoseconds(0) && clock_.now() - last_fed_ < regulator_.feed_interval)) {
    refresh();
    return;
  }
  // Read first: rewriting would hide another program's set-point, and a controller that was without power.
  if (last_fed_ >= Nanoseconds(0)) check_holds(ask({}));
  set(setpoint_);
}

void SerialController::refresh() {
  if (frame_time_ < Nanoseconds(0) || clock_.now() - frame_time_ > kSameImage) (void)ask({});
}

PressureReading SerialController::feedback() {
  refresh();
  for (const char* word : {"POV", "ADC"}) {
    if (!frame_.has(word)) continue;
    throw Fault("TB-CONTROLLER-STATUS", kControllerDevice,
                fmt::format("the pressure controller on {} reads {:g} psi with status {}", stream_->description(),
                            frame_.pressure, word));
  }
  const auto shown = static_cast<float>(frame_.pressure);
  return {Psi(frame_.pressure), Volts(0.0), std::bit_cast<std::int32_t>(shown), frame_time_};
}

bool SerialController::vent() noexcept {
  for (int i = 0; i < kControllerVentTries; ++i) {
    bool zeroed = false, open = !options_.exhausts;
    try {
      set(Psi(0.0));
      zeroed = true;
    } catch (const std::exception&) {
      zeroed = false;  // the exhaust is commanded all the same
    }
    try {
      open = open || ask({ControllerAct::kExhaust}).has("EXH");
    } catch (const std::exception&) {
      open = false;
    }
    if (zeroed && open) return true;
  }
  return false;
}

Identity SerialController::identity() const {
  return {kControllerDevice, regulator_.model, regulator_.serial, "", regulator_.origin};
}

}  // namespace tactbench::devices
