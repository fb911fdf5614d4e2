// Carries out compiled steps on a rig: command, settle, dwell, read, record. Decides what a fault means: nobody else
// does. Reads as a list of steps.
#pragma once

#include <optional>

#include "bench/rig.h"
#include "bench/run/progress.h"
#include "bench/run/recorder.h"
#include "bench/run/stop_request.h"
#include "bench/safety/safe_state.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

// Thrown when a signal asked for an end.
struct Stopped {
  int signal = 0;
};

class Sequencer {
 public:
  Sequencer(Rig& rig, Recorder& recorder, Progress& progress, const StopRequest& stop)
      : rig_(rig), recorder_(recorder), progress_(progress), stop_(stop) {}

  // Reads the unloaded array and both pressures; throws Fault TB-CHAMBER-NOT-VENTED when pressure stands in the
  // chamber.
  Baseline read_baseline();
  // Throws Fault (device, TB-CHAMBER-TIMEOUT, TB-CHAMBER-TRIP) or Stopped; the caller makes safe.
  void run(const std::vector<sequences::Step>& steps, const std::string& label);

 private:
  void carry_out(const sequences::Step& step);
  void settle(const sequences::Step& step, StepReadings& readings);
  void dwell(const sequences::Step& step, StepReadings& readings);
  void poll(StepReadings& readings);  // feeds when due, reads both witnesses, trips
  void check_agreement(const StepReadings& readings);
  void wait_until(devices::Nanoseconds time);
  Rig& rig_;
  Recorder& recorder_;
  Progress& progress_;
  const StopRequest& stop_;
  std::optional<devices::Nanoseconds> disagree_since_;  // feedback and reference
};

}  // namespace tactbench::bench
