#include "bench/run/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "bench/common/terminal.h"
#include "bench/common/utc.h"
#include "bench/rig/rig.h"
#include "bench/run/control/progress.h"
#include "db/sqlite.h"
#include "devices/device.h"

namespace tactbench::bench {
namespace {

using RealClock = std::chrono::steady_clock;
// The module is fed meanwhile, so a try is short against the time between two feedings.
constexpr std::chrono::milliseconds kTry{20}, kBetweenTries{20}, kUsual{db::sqlite::kBusyTimeoutMs};

double seconds_since(RealClock::time_point begun) {
  return std::chrono::duration<double>(RealClock::now() - begun).count();
}

}  // namespace

Recorder::Recorder(db::RunWriter& store, std::int64_t run, const devices::Clock& clock, devices::Nanoseconds offset)
    : store_(store), run_(run), clock_(clock), offset_(offset), void_frames_(store.void_frame_count(run)) {
  for (const db::BranchRecord& branch : store.branches(run)) {
    int& next = attempts_[{branch.sequence, branch.repeat, branch.ordinal}];
    next = std::max(next, branch.attempt + 1);
  }
}

bool Recorder::flush() {
  if (waiting_.empty()) return true;
  if (RealClock::now() < next_try_) return false;
  store_.wait_for_locks(kTry);
  try {
    for (; !waiting_.empty(); waiting_.pop_front()) waiting_.front()();
    store_.wait_for_locks(kUsual);
    return true;
  } catch (const std::exception& failure) {
    store_.wait_for_locks(kUsual);
    const auto* const error = dynamic_cast<const db::StoreError*>(&failure);
    if (error == nullptr || error->id() != "TB-STORE-LOCKED") {
      waiting_.pop_front();
      throw;
    }
    locked_ = *error;
    next_try_ = RealClock::now() + kBetweenTries;
    return false;
  }
}

void Recorder::write(std::function<void()> job) {
  constexpr double kWorthAWord = 0.5;
  const auto begun = RealClock::now();
  waiting_.push_back(std::move(job));
  bool waited = false;
  while (!flush()) {
    waited = true;
    const double waited_s = seconds_since(begun);
    if (on_lock_retry_) {
      if (!on_lock_retry_(*locked_, waited_s)) return;
    } else if (waited_s * 1000.0 > static_cast<double>(kUsual.count())) {
      throw db::StoreError(*locked_);
    } else {
      std::this_thread::sleep_for(kBetweenTries);
    }
  }
  if (const double waited_s = seconds_since(begun); waited && waited_s > kWorthAWord)
    event("warning", locked_->id(), fmt::format("waited {:.1f} s: {}", waited_s, locked_->what()));
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
  write([this, branch] { branch_ = store_.begin_branch(run_, branch); });
  write([this] { store_.set_seen(run_, utc_now()); });
}

void Recorder::void_branch(const std::string& reason) {
  write([this, stored = as_stored(reason)] {
    if (branch_ == 0) return;
    store_.void_branch(branch_, stored);
    branch_ = 0;
    void_frames_ = store_.void_frame_count(run_);
  });
}

void Recorder::void_repeat(int sequence, int repeat, const std::string& reason) {
  write([this, sequence, repeat, stored = as_stored(reason)] {
    for (const db::BranchRecord& branch : store_.branches(run_)) {
      if (!branch.is_void && branch.sequence == sequence && branch.repeat == repeat) {
        store_.void_branch(branch.branch, stored);
      }
    }
    void_frames_ = store_.void_frame_count(run_);
  });
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
  polls_.clear();
  max_exchanges_ = std::max(max_exchanges_, readings.exchanges);
  write([this, stored = std::move(frame)] {
    const auto start = RealClock::now();
    store_.append_frame(run_, stored);
    store_seconds_ += seconds_since(start);
    ++frames_;
  });
}

std::function<void()> Recorder::storing(const std::string& kind, const std::string& id, const std::string& detail) {
  return [this, event = db::EventRecord{now_ns(), kind, id, as_stored(detail)}] { store_.append_event(run_, event); };
}

void Recorder::event(const std::string& kind, const std::string& id, const std::string& detail) {
  write(storing(kind, id, detail));
}

void Recorder::log(const std::string& kind, const std::string& id, const std::string& detail) {
  waiting_.push_back(storing(kind, id, detail));
  (void)flush();
}

void Recorder::check(const std::string& kind, const std::string& verdict, const std::string& detail_json,
                     std::vector<double> data) {
  write([this, stored = db::CheckRecord{run_, now_ns(), kind, verdict, detail_json, std::move(data)}] {
    store_.append_check(run_, stored);
  });
}

void Recorder::state(RunState next, const std::string& reason) {
  if (!may_follow(state_, next)) {
    throw std::logic_error(std::string("run state ") + to_string(state_) + " -> " + to_string(next));
  }
  db::EventRecord change{now_ns(), "state", "",
                         std::string(to_string(state_)) + " -> " + to_string(next) + ": " + as_stored(reason)};
  state_ = next;
  write([this, next, stored = std::move(change)] { store_.set_state(run_, to_string(next), stored); });
}

void Recorder::end(db::Outcome outcome, const std::string& reason, db::SafeState safe) {
  write([=, this, stored = as_stored(reason)] { store_.end_run(run_, outcome, stored, safe, utc_now()); });
}

namespace {

std::string notice_text(const DeadManNotice& news) {
  return news.id.empty() ? news.what : fmt::format("warning: {} [{}]", news.what, news.id);
}

}  // namespace

void record_notices(Rig& rig, Recorder& recorder, Progress& progress) {
  const auto record = [&](const char* kind, const DeadManNotice& news) {
    recorder.event(kind, news.id, news.what);
    progress.note(notice_text(news));
  };
  for (const std::string& text : rig.take_busy_report()) record("warning", {"TB-MODBUS-BUSY", text});
  if (rig.dead_man() == nullptr) return;
  for (const DeadManNotice& news : rig.dead_man()->take_notices()) record("dead-man", news);
}

void print_dead_man_notices(Rig& rig) {
  if (rig.dead_man() == nullptr) return;
  for (const DeadManNotice& news : rig.dead_man()->take_notices()) tty::print(stderr, "{}\n", notice_text(news));
}

void check_dead_man(Rig& rig) {
  if (rig.dead_man() == nullptr) return;
  if (const auto lost = rig.dead_man()->lost()) throw devices::Fault(lost->id, "dead-man", lost->what, lost->remedy);
}

}  // namespace tactbench::bench
