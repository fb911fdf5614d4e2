#include "bench/run/sequencer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/process_time.h"
#include "devices/fault.h"

namespace tactbench::bench {

using devices::Fault;
using devices::Nanoseconds;
using sequences::Step;
using sequences::StepKind;

namespace {

double in_seconds(Nanoseconds time) { return static_cast<double>(time.count()) * 1e-9; }

}  // namespace

Baseline Sequencer::read_baseline() {
  StepReadings readings;
  poll(readings);
  const double highest = std::max(readings.feedback.pressure.value(), readings.reference.pressure.value());
  if (highest >= rig_.config().limits.safe_psi) {
    throw Fault("TB-CHAMBER-NOT-VENTED", "chamber",
                fmt::format("{:.1f} psi stand in the chamber before the first command", highest),
                "vent the chamber; check the zero of regulator and reference");
  }
  return baseline_of(rig_.array().read(rig_.config().scans_per_frame));
}

void Sequencer::run(const std::vector<Step>& steps, const std::string& label) {
  int done = 0;
  for (const Step& step : steps) {
    carry_out(step);
    ++done;
    progress_.step(label, done, static_cast<int>(steps.size()), step.setpoint.value());
  }
}

void Sequencer::carry_out(const Step& step) {
  const std::uint64_t exchanges_before = rig_.exchanges();
  StepReadings readings;
  settle(step, readings);
  dwell(step, readings);
  if (step.kind == StepKind::kConditioning) return;
  readings.scans = rig_.array().read(rig_.config().scans_per_frame);
  readings.exchanges = static_cast<int>(rig_.exchanges() - exchanges_before);
  recorder_.frame(step, readings);
}

void Sequencer::settle(const Step& step, StepReadings& readings) {
  const Settling& settling = rig_.config().settling;
  devices::Clock& clock = rig_.clock();
  readings.commanded_at = clock.now();
  readings.setpoint_counts = rig_.source().command(step.setpoint);
  const Nanoseconds deadline = readings.commanded_at + seconds(settling.timeout_s);
  const Nanoseconds feed = rig_.config().regulator.feed_interval;
  // The first look when the first feeding is due, then a few quick ones while a small step arrives; a long way is
  // watched only as often as the module is fed, to spare exchanges.
  constexpr int kQuickPolls = 4;
  double last_reference = std::numeric_limits<double>::infinity();
  for (int polls = 0;; ++polls) {
    const bool quick = polls > 0 && polls <= kQuickPolls;
    const Nanoseconds pause = quick ? seconds(settling.poll_s) : std::max(seconds(settling.poll_s), feed);
    const Nanoseconds before = clock.now();
    wait_until(before + pause);
    poll(readings);
    const double reference = readings.reference.pressure.value();
    const double slope = std::abs(reference - last_reference) / in_seconds(clock.now() - before);
    last_reference = reference;
    const double miss = std::abs((readings.feedback.pressure - step.setpoint).value());
    if (miss <= settling.band_psi && slope <= settling.slope_psi_per_s) break;
    if (clock.now() >= deadline) {
      throw Fault("TB-CHAMBER-TIMEOUT", "chamber",
                  fmt::format("chamber did not reach {:.1f} psi ({:.1f} kPa) within {:g} s; last reading {:.2f} psi by "
                              "the regulator, {:.2f} psi by the reference, moving {:.2f} psi/s",
                              step.setpoint.value(), devices::kilopascals(step.setpoint), settling.timeout_s,
                              readings.feedback.pressure.value(), reference, slope),
                  "check the compressor supply and for leaks; raise [settling] timeout_s or band_psi");
    }
  }
  readings.in_band_since = clock.now();
}

void Sequencer::dwell(const Step& step, StepReadings& readings) {
  const Nanoseconds end = readings.in_band_since + seconds(step.dwell_s);
  const Nanoseconds feed = rig_.config().regulator.feed_interval;
  while (rig_.clock().now() < end) {
    wait_until(std::min(end, rig_.source().last_fed() + feed));
    poll(readings);
  }
}

void Sequencer::poll(StepReadings& readings) {
  rig_.source().keep_alive();
  readings.feedback = rig_.source().feedback();
  readings.reference = rig_.reference().read();
  const double trip = rig_.config().limits.trip_psi;
  const double highest = std::max(readings.feedback.pressure.value(), readings.reference.pressure.value());
  if (highest > trip) {
    throw Fault("TB-CHAMBER-TRIP", "chamber",
                fmt::format("{:.1f} psi measured, above the trip of {:.1f} psi", highest, trip),
                "check regulator and reference before the next run; the limit is [limits] trip_psi");
  }
  check_agreement(readings);
}

// On the way to a level the two may differ by what one lags behind the other; standing apart, one of them lies.
void Sequencer::check_agreement(const StepReadings& readings) {
  const SafetyLimits& limits = rig_.config().limits;
  const double apart = std::abs((readings.feedback.pressure - readings.reference.pressure).value());
  if (apart <= limits.disagreement_psi) {
    disagree_since_.reset();
    return;
  }
  const Nanoseconds now = rig_.clock().now();
  if (!disagree_since_) disagree_since_ = now;
  if (now - *disagree_since_ < seconds(limits.disagreement_s)) return;
  throw Fault("TB-CHAMBER-DISAGREE", "chamber",
              fmt::format("the regulator's feedback reads {:.2f} psi and the reference {:.2f} psi, apart for {:.1f} s",
                          readings.feedback.pressure.value(), readings.reference.pressure.value(),
                          in_seconds(now - *disagree_since_)),
              "check both against a hand gauge (`tactbench devices calibrate-reference`), the transducer's wiring and "
              "spans; the limits are [limits] disagreement_psi and disagreement_s");
}

void Sequencer::wait_until(Nanoseconds time) {
  rig_.clock().wait_until(time);
  if (stop_.signal() != 0) throw Stopped{stop_.signal()};
}

}  // namespace tactbench::bench
