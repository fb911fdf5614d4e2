// The sequencer's waits: in slices, so that commands and signals are heard.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "bench/common/process_time.h"
#include "bench/run/sequencer.h"
#include "devices/fault.h"

namespace tactbench::bench {

using devices::Fault;
using devices::Nanoseconds;
using sequences::Step;

void Sequencer::poll_commands() {
  control_.poll(signals_);
  if (listener_) listener_();
}

void Sequencer::wait_until(Nanoseconds time) {
  devices::Clock& clock = rig_.clock();
  const double slice_s = pace_ > 0.0 ? 0.1 * pace_ : rig_.config().in_process ? 0.5 : 0.1 * rig_.config().rate;
  const Nanoseconds slice = seconds(slice_s);
  do {
    clock.wait_until(std::min(time, clock.now() + slice));
    if (pace_ > 0.0) keep_pace();
    poll_commands();
  } while (clock.now() < time);
  if (clock.now() > step_deadline_) {
    throw Fault("TB-STEP-TIMEOUT", "sequencer", fmt::format("a step took longer than {:g} s", recipe_->step_timeout_s));
  }
  check_conditions();
}

// Work that took longer than its time is not caught up.
void Sequencer::keep_pace() {
  const auto real = std::chrono::steady_clock::now();
  const Nanoseconds process = rig_.clock().now();
  const std::chrono::duration<double, std::nano> due(static_cast<double>((process - paced_at_).count()) / pace_);
  const auto until = paced_ + std::chrono::duration_cast<Nanoseconds>(due);
  if (until > real) std::this_thread::sleep_until(until);
  paced_ = std::max(until, real);
  paced_at_ = process;
}

void Sequencer::hold_vented(double duration_s) {
  Step rest;
  rest.dwell_s = duration_s;
  rest.settle = false;
  readings_.in_band_since = rig_.clock().now();
  dwell(rest);
}

namespace {
constexpr auto kTurn = std::chrono::milliseconds(200);
}

void Sequencer::stand() {
  step_deadline_ = Nanoseconds::max();
  if (rig_.config().in_process) {  // what is waited for takes real time, and nothing happens on this rig meanwhile
    std::this_thread::sleep_for(kTurn / 10);
    return poll_commands();
  }
  rig_.clock().wait_until(rig_.clock().now() + seconds(0.1 * rig_.config().rate));
  poll_commands();
  if (rig_.source().armed()) poll();
}

void Sequencer::idle() {
  step_deadline_ = Nanoseconds::max();
  // A manual clock does not wait, but a person needs real time.
  if (rig_.config().in_process) std::this_thread::sleep_for(kTurn / 10);
  const Nanoseconds end = rig_.clock().now() + kTurn;
  while (rig_.clock().now() < end) {
    rig_.clock().wait_until(std::min(end, rig_.clock().now() + seconds(0.1 * rig_.config().rate)));
    poll_commands();
  }
  poll();
}

}  // namespace tactbench::bench
