// The status that a live run reports. The sequencer's thread fills it in (control.h), Control keeps the newest,
// the control socket sends it as JSON, and a client reads it back.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

// The sequencer's states in one table; each change is an event with time and reason. The outcome is separate.

namespace tactbench::bench {

enum class RunState {
  kPrepared,
  kRunning,
  kPausing,    // a pause was requested: continues to the end of the branch
  kPaused,     // vented, waits for a person
  kSuspended,  // vented, waits for a condition (supply pressure, temperature)
  kStopping,   // teardown, safe state
  kEnded,
};

const char* to_string(RunState state);
// Whether the table allows the change of state.
[[nodiscard]] bool may_follow(RunState from, RunState to);

// The newest readings of a run.
struct RunReadings {
  double time_s = 0.0;  // process time since the run's start
  double setpoint_psi = 0.0, feedback_psi = 0.0, reference_psi = 0.0;
  bool settled = false;           // the set-point is constant, and the feedback is within its band
  std::optional<double> force_n;  // magnitude; none: no force was read
};

// An answer of an operator, or of a person who answered in place of one.
struct GivenAnswer {
  int question = 0;
  std::string text, who;  // text: empty if the answer was only "done"
};

struct RunStatus {
  std::int64_t run = 0;
  RunState state = RunState::kPrepared;
  std::string store, label, reason;   // reason of the last change of state
  std::string question;               // to the operator, while it waits for the answer; empty: none
  int question_id = 0;                // of the last question of this process, counted from 1
  std::optional<GivenAnswer> answer;  // the last one; filled in by Control
  std::string phase;                  // current activity in words: "conditioning 2 of 6"
  int step = 0, steps = 0;
  // Frames stored by this process and earlier ones: in valid branches, and in void ones; and planned by the recipes.
  std::int64_t frames = 0, frames_void = 0, frames_planned = 0;
  // Process time (real time if rate is 0): median and 10-90 % band, without waits; prompts are counted separately.
  // Without an estimate the band is 0 and left_s follows from the pace so far; 0: not known yet.
  double left_s = 0.0, left_low_s = 0.0, left_high_s = 0.0;
  int prompts_left = 0;
  double rate = 1.0;               // process seconds per real second; 0: a simulated clock that the program advances
  std::optional<double> target_n;  // target of a step that presses
  std::optional<RunReadings> readings;  // none: not read yet
  double age_s = 0.0;                   // real time since the run's last sign of work
};

// A phase without the number of its step: plain output has one line per stage.
std::string stage_of(const std::string& phase);

// Texts of a recipe may be long; in an answer they are cut to this many columns.
inline constexpr std::size_t kMaxAnswerColumns = 300;

// Adds the members of `status` to the JSON object `object`.
void add_status_json(nlohmann::json& object, const RunStatus& status);
// The reverse; missing members keep their defaults. Throws nlohmann::json::exception for a member of another type.
RunStatus status_from_json(const nlohmann::json& object);

}  // namespace tactbench::bench
