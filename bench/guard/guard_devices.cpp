#include "bench/guard/guard_devices.h"

#include <algorithm>
#include <cmath>

#include "devices/device.h"

namespace tactbench::bench {

using devices::Axis;
using devices::Millimetres;
using devices::MillimetresPerSecond;

void GuardedSource::arm() {
  before_arming_();
  source_->arm();
  guard_.source_armed();
  guard_.arm();
}

std::uint16_t GuardedSource::command(devices::Psi pressure) {
  guard_.check_pressure(pressure);
  const std::uint16_t counts = source_->command(pressure);
  guard_.set_pressure(pressure);
  guard_.check_rewriting();  // see keep_alive()
  return counts;
}

void GuardedSource::keep_alive() {
  guard_.check_rewriting();
  source_->keep_alive();
  // A process that was stopped between check and write would undo the dead-man's vent when it continues: this vents
  // again.
  guard_.check_rewriting();
}

devices::PressureReading GuardedSource::feedback() {
  const devices::PressureReading reading = source_->feedback();
  guard_.note_feedback(reading.pressure, reading.time);
  return reading;
}

bool GuardedSource::vent() noexcept {
  const bool read_back = source_->vent();
  try {
    guard_.vented(read_back);
  } catch (...) {  // a log that fails must not stop a vent
  }
  return read_back;
}

devices::PressureReading GuardedReference::read() {
  const devices::PressureReading reading = reference_->read();
  guard_.note_reference(reading.pressure, reading.time);
  return reading;
}

void GuardedStage::arm() {
  before_arming_();
  stage_.arm();
  guard_.stage_armed();
}

void GuardedStage::check(Axis axis, double target_mm, std::optional<MillimetresPerSecond> speed) {
  guard_.check_move(axis, target_mm, speed ? speed->value() : guard_.axis_limits(axis).speed_mm_per_s,
                    [&](Axis asked) { return stage_.state(asked); });
}

void GuardedStage::home(Axis axis) {
  guard_.check_home(axis, [&](Axis asked) { return stage_.state(asked); });
  stage_.home(axis);
}

void GuardedStage::start_move_to(Axis axis, Millimetres position, std::optional<MillimetresPerSecond> speed) {
  check(axis, position.value(), speed);
  stage_.start_move_to(axis, position, speed);
  guard_.set_moving(axis, true);
}

void GuardedStage::start_move_by(Axis axis, Millimetres distance, std::optional<MillimetresPerSecond> speed) {
  check(axis, (stage_.state(axis).position + distance).value(), speed);
  stage_.start_move_by(axis, distance, speed);
  guard_.set_moving(axis, true);
}

void GuardedStage::start_speed(Axis axis, MillimetresPerSecond speed) {
  const double target = speed.value() > 0.0 ? guard_.axis_limits(axis).high_mm : guard_.axis_limits(axis).low_mm;
  check(axis, target, MillimetresPerSecond(std::abs(speed.value())));
  stage_.start_speed(axis, speed);
  guard_.set_moving(axis, true);
}

Millimetres GuardedStage::wait(Axis axis) {
  const Millimetres where = stage_.wait(axis);
  guard_.set_moving(axis, false);
  return where;
}

Millimetres GuardedStage::stop(Axis axis) {
  const Millimetres where = stage_.stop(axis);
  guard_.set_moving(axis, false);
  return where;
}

bool GuardedStage::halt() noexcept { return guard_.may_use_stage_line() && stage_.halt(); }

devices::ForceReading GuardedForce::read(int records) {
  try {
    devices::ForceReading reading = sensor_->read(records);
    if (tared_) guard_.note_force(reading.wrench, reading.time);
    return reading;
  } catch (const devices::Fault& fault) {
    if (tared_ && guard_.armed() && (fault.id() == "TB-FORCE-OVERLOAD" || fault.id() == "TB-FORCE-SATURATED")) {
      guard_.trip("TB-FORCE-TRIP", fault.what());
      throw devices::Fault("TB-FORCE-TRIP", fault.device(), std::string(fault.what()) + guard_.halt_text(),
                           fault.remedy());
    }
    throw;
  }
}

devices::ForceReading GuardedForce::bias(int records) {
  devices::ForceReading removed = sensor_->bias(records);
  tared_ = true;
  return removed;
}

void FeedingClock::wait_until(devices::Nanoseconds time) {
  for (feed_(); clock_.now() < time; feed_()) clock_.wait_until(std::min(time, clock_.now() + slice_));
}

}  // namespace tactbench::bench
