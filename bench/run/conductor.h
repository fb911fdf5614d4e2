// Carries out a run branch by branch and handles broken branches, device failures, tripped conditions and operators'
// commands. A branch is completed or repeated as a whole, starting from a conditioned state, since a hysteretic
// sensor's output depends on its history.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "bench/run/control/control.h"
#include "bench/run/control/progress.h"
#include "bench/run/sequencer.h"
#include "bench/run/stage_steps.h"
#include "bench/run/time_estimate.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

struct Work {
  std::vector<sequences::Recipe> recipes;
  std::vector<sequences::Step> steps;                   // compile(recipes)
  std::set<sequences::BranchKey> done;                  // branches completed by an earlier process
  std::function<void(const sequences::Step&)> on_step;  // called with each step before it is carried out; may be empty
  std::function<void()> on_poll;                        // called whenever commands are polled; may be empty
  const TimeEstimate* estimate = nullptr;               // estimate of the time left; null: none
  bool assume_yes = false;                              // operator prompts are answered with yes
};

class Conductor {
 public:
  // The board's status has run, store and label filled in, and the frames of earlier processes. All arguments must
  // outlive this.
  Conductor(Sequencer& sequencer, Recorder& recorder, Control& control, StatusBoard& board, const Notify& notify,
            Work work, UnloadedFrame baseline);
  // Runs until all branches are done. Throws the exception that ends the run: Fault, Error, RunEndRequested,
  // StoreError.
  void run();
  void set_state(RunState state, const std::string& reason);
  // Repeats `work` after each suspension that it throws.
  void run_through_suspensions(const std::function<void()>& work);
  [[nodiscard]] StageSteps& press_steps() { return stage_; }
  [[nodiscard]] int redone() const { return redone_; }  // branches voided and repeated

 private:
  // Waits, vented, until the conditions hold again and everything is stored. Throws Fault TB-RUN-SUSPENDED, StoreError
  // TB-STORE-LOCKED, RunEndRequested.
  void suspend(const Suspended& suspended);
  bool handle_store_lock(const db::StoreError& locked, double waited_s);
  [[nodiscard]] std::size_t first_span();
  void branch(const sequences::BranchSpan& span);
  void attempt(const sequences::BranchSpan& span, bool tolerant);
  void conditioning(const sequences::BranchSpan& span);
  bool condition(const sequences::BranchSpan& span);
  void travel(const sequences::BranchSpan& span);
  // `before` is put in front of the step's text in the status.
  void carry_out(const sequences::Step& step, const std::string& before = {});
  void go_back(const sequences::BranchKey& key);
  void fail_fast(const sequences::Step& step);
  void give_up(const std::string& reason);  // voids the open branch; the sensor's state is no longer the expected one
  void pause(const std::string& why);
  void prompt(const sequences::Step& step);
  bool vented(const std::string& why);  // vents; true: the safe state was proved
  void vent(const std::string& why);    // throws if the safe state cannot be proved
  void wait_for_resume();
  // Where work continues after a rest: at `next`, or after a long one at the first branch of its repeat.
  [[nodiscard]] std::size_t after_rest(std::size_t next);
  void recover();    // arms the source and reopens the array
  bool recovered();  // the same; false if a device does not come back
  void publish();
  void listen();
  Sequencer& sequencer_;
  Recorder& recorder_;
  Control& control_;
  StatusBoard& board_;
  const Notify& notify_;
  Work work_;
  UnloadedFrame baseline_;
  RunStatus& status_;           // the board's
  std::int64_t frames_before_;  // frames of earlier processes
  StageSteps stage_;
  std::vector<sequences::BranchSpan> spans_;
  bool displaced_ = false;  // the next branch needs the path to its start
  double rested_s_ = 0.0;   // duration of the last wait without load
  bool peak_seen_ = false;  // the fail-fast limits have been checked
  bool working_ = false;    // a suspension thrown now is caught, and the work repeated
  int redone_ = 0;
};

}  // namespace tactbench::bench
