// Commands and signals to a live run. Any thread may request a command; only the sequencer's thread carries it out, at
// its next wait.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "bench/common/stop_request.h"
#include "bench/run/control/progress.h"
#include "bench/run/control/run_status.h"

namespace tactbench::bench {

// Every command that ends the run vents and retracts; the commands differ in the run's outcome and in urgency.
enum class Command {
  kStatus,
  kPause,   // continues to the end of the branch, then vents and waits
  kResume,  // a paused run continues: conditioned again, from the next branch
  kStop,    // ends now; the measured data count (outcome stopped)
  kAbort,   // ends now, because something is wrong (outcome aborted)
  kPanic,   // vents and halts immediately, without the sequencer; latches a trip
};
const char* to_string(Command command);

// Thrown from the sequencer's wait when the run is to end.
struct RunEndRequested {
  Command command = Command::kStop;
  int signal = 0;   // SIGINT, SIGTERM, SIGHUP, ...; 0: by a command
  std::string who;  // "Ctrl-C", "alice (pid 812)"
};

class Control {
 public:
  struct Answer {
    bool taken = false;
    std::string text;
  };
  // Answers from the present status; never waits for the sequencer.
  Answer ask(Command command, const std::string& who);
  // Answers the question with that number, from any client. The first answer is accepted; a later one is refused, with
  // the name of the person who gave the first.
  Answer answer(int question, const std::string& text, const std::string& who);
  // Grows with each publish() and see().
  [[nodiscard]] std::uint64_t news() const { return news_.load(std::memory_order_relaxed); }
  [[nodiscard]] RunStatus status() const;
  // Sets the action that a panic starts immediately, on the requesting thread. To be set before the socket opens.
  void on_panic(std::function<void()> action) { panic_ = std::move(action); }

  // For a run without an operator who could resume it after a pause: the first Ctrl-C ends it. To be set before the run
  // begins.
  void end_by_first_interrupt() { interrupts_that_end_ = 1; }

  // The sequencer's side. poll() throws RunEndRequested when the run is to end; otherwise it turns signals into
  // commands.
  void poll(const StopRequest& signals);
  // The RunEndRequested that poll() would throw: a panic has precedence over signals, and signals over other commands.
  // None: the run continues.
  [[nodiscard]] std::optional<RunEndRequested> asked(const StopRequest& signals) const;
  // To be called when all steps are done. Throws RunEndRequested for commands received so far; a later pause or stop is
  // answered as too late. Abort and panic are still accepted.
  void finish(const StopRequest& signals);
  // From now on no command is accepted; returns the last one accepted.
  std::optional<RunEndRequested> close(const StopRequest& signals);
  [[nodiscard]] bool pause_wanted() const;
  // True once after a resume.
  [[nodiscard]] bool consume_resume();
  // The answer to the question with that number; none: not answered yet. A resume is an answer without text.
  [[nodiscard]] std::optional<GivenAnswer> answer_to(int question) const;
  // Keeps the readings that see() gave.
  void publish(const RunStatus& status);
  // Never waits: while another thread reads the status, these readings are dropped and the next ones are used.
  void see(const RunReadings& readings);
  [[nodiscard]] std::string who() const;  // source of the last command

 private:
  [[nodiscard]] std::optional<RunEndRequested> leave(const StopRequest& signals) const;  // with the lock held
  Answer accept_answer(int question, const std::string& text, const std::string& who);   // with the lock held
  mutable std::mutex mutex_;
  RunStatus status_;
  std::chrono::steady_clock::time_point reported_at_ =
      std::chrono::steady_clock::now();  // time of the last publish() or see()
  bool finished_ = false, closed_ = false;
  Command command_ = Command::kStatus;  // the strongest command so far; kStatus: none
  bool pause_ = false, resume_ = false;
  int interrupts_seen_ = 0, interrupts_answered_ = 0;  // answered: the pause was revoked or ended
  int interrupts_that_end_ = 2;
  std::string who_, end_requested_by_;  // source of the last command; source of the command that ends the run
  std::optional<GivenAnswer> answer_;   // the last one
  std::atomic<std::uint64_t> news_{0};
  std::function<void()> panic_;
};

// The sequencer's side of a run's status: it is shown in the progress line and sent to clients of the run.
// One thread; nothing here waits for a reader.
class StatusBoard {
 public:
  // Both must outlive this.
  StatusBoard(Control& control, Progress& progress) : control_(control), progress_(progress) {}
  // The status to be changed; publish() then sends it. Readings come from the sequencer (Control::see).
  [[nodiscard]] RunStatus& now() { return now_; }
  void publish();
  // Sets the run's current activity in words, publishes and shows it.
  void phase(const std::string& text);
  // To be called often: renews the progress line when that is due.
  void refresh();
  // To be called when all steps up to now().step are done: the last step is always shown.
  void step_done();
  void note(const std::string& text) { progress_.note(text); }
  [[nodiscard]] Progress& progress() { return progress_; }

 private:
  Control& control_;
  Progress& progress_;
  RunStatus now_;
  Pace pace_;
};

}  // namespace tactbench::bench
