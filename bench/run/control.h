// What people and signals ask of a live run. Any thread may ask; the sequencer's thread alone acts, at its next wait.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "bench/run/run_state.h"
#include "bench/run/stop_request.h"

namespace tactbench::bench {

// Every way out vents and retracts; they differ in what the run is worth afterwards and in haste.
enum class Word {
  kStatus,
  kPause,   // goes on to the end of the branch, then vents and waits
  kResume,  // a paused run goes on: conditioned again, from the next branch
  kStop,    // ends now; what is measured counts (outcome stopped)
  kAbort,   // ends now; somebody saw something wrong (outcome aborted)
  kPanic,   // vents and halts at once, past the sequencer; latches a trip
};
const char* to_string(Word word);

// Thrown from the sequencer's wait when the run is to end.
struct Leave {
  Word word = Word::kStop;
  int signal = 0;   // SIGINT, SIGTERM; 0: asked by a word
  std::string who;  // "Ctrl-C twice", "pid 812"
};

struct RunStatus {
  std::int64_t run = 0;
  RunState state = RunState::kPrepared;
  std::string store, label, reason;  // reason of the last change of state
  int step = 0, steps = 0;
  double left_s = 0.0;  // process time
};

class Control {
 public:
  struct Answer {
    bool taken = false;
    std::string text;
  };
  // Answers from what is known now; never waits for the sequencer.
  Answer ask(Word word, const std::string& who);
  [[nodiscard]] RunStatus status() const;
  // Called at once, on the asking thread, when somebody panics. Set before the socket opens.
  void on_panic(std::function<void()> action) { panic_ = std::move(action); }

  // The sequencer's side. look() throws Leave when the run is to end; otherwise it turns signals into words.
  void look(const StopRequest& signals);
  // What look() would throw: a panic before signals before other words. Nothing: the run goes on.
  [[nodiscard]] std::optional<Leave> asked(const StopRequest& signals) const;
  // From now on no word is taken; what was asked until now.
  std::optional<Leave> close(const StopRequest& signals);
  [[nodiscard]] bool pause_wanted() const;
  // True once after a resume was asked.
  [[nodiscard]] bool take_resume();
  void publish(const RunStatus& status);
  [[nodiscard]] std::string who() const;  // asked last

 private:
  [[nodiscard]] std::optional<Leave> leave(const StopRequest& signals) const;  // under the lock
  mutable std::mutex mutex_;
  RunStatus status_;
  bool closed_ = false;
  Word word_ = Word::kStatus;  // the strongest asked so far; kStatus: nothing
  bool pause_ = false, resume_ = false;
  int interrupts_seen_ = 0, interrupts_answered_ = 0;  // answered: the pause was taken back or ended
  std::string who_, leaver_;                           // asked last; asked for the end
  std::function<void()> panic_;
};

}  // namespace tactbench::bench
