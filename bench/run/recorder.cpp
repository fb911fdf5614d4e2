#include "bench/run/recorder.h"

#include <algorithm>
#include <stdexcept>

namespace tactbench::bench {

void Recorder::frame(const sequences::Step& step, const StepReadings& readings) {
  if (step.sequence != sequence_ || step.repeat != repeat_ || step.branch != ordinal_) {
    db::BranchRecord branch;
    branch.sequence = sequence_ = step.sequence;
    branch.repeat = repeat_ = step.repeat;
    branch.ordinal = ordinal_ = step.branch;
    branch.from_psi = step.branch_from.value();
    branch.to_psi = step.branch_to.value();
    branch_ = store_.begin_branch(run_, branch);
  }
  db::FrameRecord frame;
  frame.branch = branch_;
  frame.ordinal = step.ordinal;
  frame.setpoint_psi = step.setpoint.value();
  frame.setpoint_counts = readings.setpoint_counts;
  frame.feedback_psi = readings.feedback.pressure.value();
  frame.feedback_counts = readings.feedback.counts;
  frame.reference_psi = readings.reference.pressure.value();
  frame.reference_counts = readings.reference.counts;
  frame.time_ns = readings.scans.time.count();
  frame.since_command_ns = (readings.scans.time - readings.commanded_at).count();
  frame.in_band_ns = (readings.scans.time - readings.in_band_since).count();
  frame.device_time_us = readings.scans.device_time_us;
  frame.status = readings.scans.status;
  frame.exchanges = readings.exchanges;
  frame.rows = readings.scans.rows;
  frame.columns = readings.scans.columns;
  frame.scans = readings.scans.scans;
  frame.counts = readings.scans.counts;
  store_.append_frame(run_, frame);
  ++frames_;
  most_exchanges_ = std::max(most_exchanges_, readings.exchanges);
}

void Recorder::event(const std::string& kind, const std::string& id, const std::string& detail) {
  store_.append_event(run_, {clock_.now().count(), kind, id, detail});
}

void Recorder::state(RunState next, const std::string& reason) {
  if (!may_follow(state_, next)) {
    throw std::logic_error(std::string("run state ") + to_string(state_) + " -> " + to_string(next));
  }
  store_.set_state(
      run_, to_string(next),
      {clock_.now().count(), "state", "", std::string(to_string(state_)) + " -> " + to_string(next) + ": " + reason});
  state_ = next;
}

}  // namespace tactbench::bench
