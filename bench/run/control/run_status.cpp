#include "bench/run/control/run_status.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "analysis/json_fields.h"
#include "bench/common/terminal.h"

namespace tactbench::bench {

namespace {

RunState state_of(const std::string& text) {
  for (int i = 0; i <= static_cast<int>(RunState::kEnded); ++i) {
    if (text == to_string(static_cast<RunState>(i))) return static_cast<RunState>(i);
  }
  return RunState::kEnded;
}

}  // namespace

std::string stage_of(const std::string& phase) { return phase.substr(0, phase.find(", step ")); }

void add_status_json(nlohmann::json& object, const RunStatus& status) {
  object.update({{"run", status.run},
                 {"state", to_string(status.state)},
                 JSON_FIELDS(status, store, label),
                 {"reason", one_line(status.reason, kMaxAnswerColumns)},
                 {"question", one_line(status.question, kMaxAnswerColumns)},
                 {"question_id", status.question_id},
                 {"phase", one_line(status.phase, kMaxAnswerColumns)},
                 JSON_FIELDS(status, step, steps, frames, frames_void, frames_planned, left_s, left_low_s, left_high_s,
                             prompts_left, rate, age_s)});
  if (status.answer)
    object["answer"] = {{"question", status.answer->question},
                        {"text", one_line(status.answer->text, kMaxAnswerColumns)},
                        {"who", one_line(status.answer->who, kMaxAnswerColumns)}};
  if (status.target_n) object["target_n"] = *status.target_n;
  if (!status.readings) return;
  const RunReadings& now = *status.readings;
  nlohmann::json& readings = object["readings"];
  readings = {JSON_FIELDS(now, time_s, setpoint_psi, feedback_psi, reference_psi, settled)};
  if (now.force_n) readings["force_n"] = *now.force_n;
}

RunStatus status_from_json(const nlohmann::json& object) {
  RunStatus status;
  status.run = object.value("run", std::int64_t{0});
  status.state = state_of(object.value("state", ""));
  status.store = object.value("store", "");
  status.label = object.value("label", "");
  status.reason = object.value("reason", "");
  status.question = object.value("question", "");
  status.question_id = object.value("question_id", 0);
  if (object.contains("answer")) {
    const nlohmann::json& answer = object.at("answer");
    status.answer = GivenAnswer{answer.value("question", 0), answer.value("text", ""), answer.value("who", "")};
  }
  status.phase = object.value("phase", "");
  status.step = object.value("step", 0);
  status.steps = object.value("steps", 0);
  status.frames = object.value("frames", std::int64_t{0});
  status.frames_void = object.value("frames_void", std::int64_t{0});
  status.frames_planned = object.value("frames_planned", std::int64_t{0});
  status.left_s = object.value("left_s", 0.0);
  status.left_low_s = object.value("left_low_s", 0.0);
  status.left_high_s = object.value("left_high_s", 0.0);
  status.prompts_left = object.value("prompts_left", 0);
  status.rate = object.value("rate", 1.0);
  status.age_s = object.value("age_s", 0.0);
  if (object.contains("target_n")) status.target_n = object.at("target_n").get<double>();
  if (!object.contains("readings")) return status;
  const nlohmann::json& readings = object.at("readings");
  RunReadings& now = status.readings.emplace();
  now.time_s = readings.value("time_s", 0.0);
  now.setpoint_psi = readings.value("setpoint_psi", 0.0);
  now.feedback_psi = readings.value("feedback_psi", 0.0);
  now.reference_psi = readings.value("reference_psi", 0.0);
  now.settled = readings.value("settled", false);
  if (readings.contains("force_n")) now.force_n = readings.at("force_n").get<double>();
  return status;
}

namespace {

using S = RunState;

struct Row {
  RunState state;
  const char* word;
  std::vector<RunState> next;
};

// A run that fails before its first step still goes through stopping: the safe state is proved on every way out.
const std::array<Row, 7>& table() {
  static const std::array<Row, 7> rows = {{
      {S::kPrepared, "prepared", {S::kRunning, S::kStopping}},
      {S::kRunning, "running", {S::kPausing, S::kSuspended, S::kStopping}},
      {S::kPausing, "pausing", {S::kPaused, S::kRunning, S::kSuspended, S::kStopping}},
      {S::kPaused, "paused", {S::kRunning, S::kStopping}},
      {S::kSuspended, "suspended", {S::kRunning, S::kPaused, S::kStopping}},
      {S::kStopping, "stopping", {S::kEnded}},
      {S::kEnded, "ended", {}},
  }};
  return rows;
}

const Row& row_of(RunState state) { return table()[static_cast<std::size_t>(state)]; }

}  // namespace

const char* to_string(RunState state) { return row_of(state).word; }

bool may_follow(RunState from, RunState to) {
  const std::vector<RunState>& next = row_of(from).next;
  return std::find(next.begin(), next.end(), to) != next.end();
}

}  // namespace tactbench::bench
