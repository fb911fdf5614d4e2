#include "bench/run/recorder.h"
#include "bench/common/utc.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace tactbench::bench {

Recorder::Recorder(db::RunStore& store, std::int64_t run, const devices::Clock& clock, devices::Nanoseconds offset)
    : store_(store), run_(run), clock_(clock), offset_(offset), void_frames_(store.void_frame_count(run)) {
  for (const db::BranchRecord& branch : store.branches(run)) {
    int& next = attempts_[{branch.sequence, branch.repeat, branch.ordinal}];
    next = std::max(next, branch.attempt + 1);
  }
}

void Recorder::open_branch(const sequences::Step& step) {
  db::BranchRecord branch;
  branch.sequence = step.sequence;
  branch.repeat = step.repeat;
  branch.ordinal = step.branch;
  branch.attempt = attempts_[{step.sequence, step.repeat, step.branch}]++;
  branch.from_psi = step.branch_from.value();
  branch.to_psi = step.branch_to.value();
  if (step.kind == sequences::StepKind::kPress) {
    branch.from_n = step.force_from_n;
    branch.to_n = step.force_to_n;
  }
  branch_ = store_.begin_branch(run_, branch);
  store_.set_seen(run_, utc_now());
}

void Recorder::void_branch(const std::string& reason) {
  if (branch_ == 0) return;
  store_.void_branch(std::exchange(branch_, 0), as_stored(reason));
  void_frames_ = store_.void_frame_count(run_);
}

void Recorder::void_repeat(int sequence, int repeat, const std::string& reason) {
  for (const db::BranchRecord& branch : store_.branches(run_)) {
    if (!branch.is_void && branch.sequence == sequence && branch.repeat == repeat) {
      store_.void_branch(branch.branch, as_stored(reason));
    }
  }
  void_frames_ = store_.void_frame_count(run_);
}

void Recorder::poll(devices::Psi setpoint, const devices::PressureReading& feedback,
                    const devices::PressureReading& reference) {
  const auto narrow = [](devices::Psi pressure) { return static_cast<float>(pressure.value()); };
  polls_.push_back({clock_.now(), narrow(setpoint), narrow(feedback.pressure), narrow(reference.pressure)});
}

void Recorder::frame(const sequences::Step& step, const StepReadings& readings) {
  db::FrameRecord frame;
  frame.branch = branch_;
  frame.ordinal = step.ordinal;
  frame.setpoint_psi = step.setpoint.value();
  frame.setpoint_counts = readings.setpoint_counts;
  frame.feedback_psi = readings.feedback.pressure.value();
  frame.feedback_counts = readings.feedback.counts;
  frame.reference_psi = readings.reference.pressure.value();
  frame.reference_counts = readings.reference.counts;
  frame.time_ns = (readings.scans.time + offset_).count();
  frame.since_command_ns = (readings.scans.time - readings.commanded_at).count();
  frame.in_band_ns = (readings.scans.time - readings.in_band_since).count();
  frame.device_time_us = readings.scans.device_time_us;
  frame.status = readings.scans.status;
  frame.exchanges = readings.exchanges;
  frame.rows = readings.scans.rows;
  frame.columns = readings.scans.columns;
  frame.scans = readings.scans.scans;
  frame.counts = readings.scans.counts;
  frame.flags = readings.flags;
  frame.wrench = readings.wrench;
  for (const Poll& poll : polls_) {
    const std::chrono::duration<float> before = readings.scans.time - poll.time;
    frame.trace.push_back({before.count(), poll.setpoint_psi, poll.feedback_psi, poll.reference_psi});
  }
  const auto start = std::chrono::steady_clock::now();
  store_.append_frame(run_, frame);
  store_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  polls_.clear();
  ++frames_;
  most_exchanges_ = std::max(most_exchanges_, readings.exchanges);
}

void Recorder::event(const std::string& kind, const std::string& id, const std::string& detail) {
  store_.append_event(run_, {now_ns(), kind, id, as_stored(detail)});
}

void Recorder::check(const std::string& kind, const std::string& verdict, const std::string& detail_json,
                     std::vector<double> data) {
  store_.append_check(run_, {run_, now_ns(), kind, verdict, detail_json, std::move(data)});
}

void Recorder::state(RunState next, const std::string& reason) {
  if (!may_follow(state_, next)) {
    throw std::logic_error(std::string("run state ") + to_string(state_) + " -> " + to_string(next));
  }
  store_.set_state(
      run_, to_string(next),
      {now_ns(), "state", "", std::string(to_string(state_)) + " -> " + to_string(next) + ": " + as_stored(reason)});
  state_ = next;
}

}  // namespace tactbench::bench
