// Which commands a run takes in each of its states, and what Control remembers of them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <map>
#include <string>
#include <vector>

#include "bench/run/control/control.h"
#include "bench/run/control/run_status.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

RunStatus asked_status(RunState state, const std::string& question = {}) {
  RunStatus status;
  status.run = 7;
  status.state = state;
  status.question = question;
  status.question_id = question.empty() ? 0 : 4;
  return status;
}

}  // namespace

TEST_CASE("run states: they follow the table and nothing else") {
  using S = RunState;
  const std::vector<S> all = {S::kPrepared,  S::kRunning,  S::kPausing, S::kPaused,
                              S::kSuspended, S::kStopping, S::kEnded};
  const std::map<S, std::vector<S>> allowed = {{S::kPrepared, {S::kRunning, S::kStopping}},
                                               {S::kRunning, {S::kPausing, S::kSuspended, S::kStopping}},
                                               {S::kPausing, {S::kPaused, S::kRunning, S::kSuspended, S::kStopping}},
                                               {S::kPaused, {S::kRunning, S::kStopping}},
                                               {S::kSuspended, {S::kRunning, S::kPaused, S::kStopping}},
                                               {S::kStopping, {S::kEnded}},
                                               {S::kEnded, {}}};
  for (const S from : all) {
    for (const S to : all) {
      INFO(to_string(from) << " -> " << to_string(to));
      const auto& next = allowed.at(from);
      CHECK(may_follow(from, to) == (std::find(next.begin(), next.end(), to) != next.end()));
    }
  }
}

TEST_CASE("control's answers: which command is taken in which state, and who asked") {
  using S = RunState;
  const std::vector<S> alive = {S::kPrepared, S::kRunning, S::kPausing, S::kPaused, S::kSuspended};
  const std::map<Command, std::vector<S>> taken_in = {
      {Command::kStatus, {S::kPrepared, S::kRunning, S::kPausing, S::kPaused, S::kSuspended, S::kStopping, S::kEnded}},
      {Command::kPause, {S::kPrepared, S::kRunning, S::kPausing, S::kSuspended}},
      {Command::kResume, {S::kPausing, S::kPaused}},
      {Command::kStop, alive},
      {Command::kAbort, alive},
      {Command::kPanic, alive}};
  for (const auto& [command, states] : taken_in) {
    for (int i = 0; i <= static_cast<int>(S::kEnded); ++i) {
      const auto state = static_cast<S>(i);
      INFO(to_string(command) << " in " << to_string(state));
      const bool taken = std::ranges::find(states, state) != states.end();
      Control control;
      control.publish(asked_status(state));
      const Control::Answer answer = control.ask(command, "bob");
      CHECK(answer.taken == taken);
      if (command == Command::kStatus) CHECK(answer.text == to_string(state));
      if (command != Command::kStatus) CHECK(answer.text.find("7") != std::string::npos);
      CHECK(control.who() == (taken && command != Command::kStatus ? "bob" : ""));
    }
  }
  for (const S state : {S::kPaused, S::kPausing}) {  // it answers what is asked
    Control control;
    control.publish(asked_status(state, "Mounted?"));
    CHECK_THAT(control.ask(Command::kResume, "bob").text, Catch::Contains("Mounted?"));
  }
  const std::vector<std::string> words = {"status", "pause", "resume", "stop", "abort", "panic"};
  for (std::size_t i = 0; i < words.size(); ++i) CHECK(to_string(static_cast<Command>(i)) == words[i]);
}

TEST_CASE("commands: the end is attributed to the first sender of the strongest command") {
  const StopRequest signals;
  Control control;
  CHECK(control.ask(Command::kAbort, "alice").taken);
  CHECK(control.ask(Command::kStop, "bob").taken);
  CHECK(control.ask(Command::kAbort, "carol").taken);
  REQUIRE(control.asked(signals));
  CHECK(control.asked(signals)->who == "alice");
  CHECK(control.asked(signals)->command == Command::kAbort);
  CHECK(control.who() == "carol");
  int panics = 0;
  control.on_panic([&] { ++panics; });
  CHECK(control.ask(Command::kPanic, "dora").taken);
  CHECK(panics == 1);
  CHECK(control.asked(signals)->who == "dora");
  Control lone;  // without anybody to call
  CHECK(lone.ask(Command::kPanic, "e").taken);
}

TEST_CASE("control's answers: after the last step a pause, a resume and a stop come too late, the others do not") {
  const StopRequest signals;
  for (const Command command : {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic}) {
    Control control;
    control.publish(asked_status(RunState::kRunning));
    control.finish(signals);
    const bool late = command < Command::kAbort;
    const Control::Answer answer = control.ask(command, "bob");
    CHECK(answer.taken == !late);
    CHECK_FALSE(control.pause_wanted());
    CHECK_FALSE(control.take_resume());
  }
  Control before;
  CHECK(before.ask(Command::kStop, "bob").taken);
  try {
    before.finish(signals);
    FAIL("it was asked to stop before");
  } catch (const Leave& leave) {
    CHECK((leave.command == Command::kStop && leave.signal == 0 && leave.who == "bob"));
  }
  try {
    before.poll(signals);
    FAIL("it was asked to stop before");
  } catch (const Leave& leave) {
    CHECK((leave.command == Command::kStop && leave.signal == 0));
  }
  Control none;
  CHECK_NOTHROW(none.poll(signals));
  CHECK_FALSE(none.asked(signals));
  CHECK_NOTHROW(none.finish(signals));
  CHECK_FALSE(none.close(signals));
  CHECK_FALSE(none.ask(Command::kAbort, "e").taken);
  CHECK(none.ask(Command::kStatus, "e").taken);
  Control aborted;
  aborted.finish(signals);
  CHECK(aborted.ask(Command::kAbort, "t").taken);
  CHECK(aborted.close(signals));
}

TEST_CASE("control's answers: pauses and resumes, as they are wanted") {
  Control control;
  control.publish(asked_status(RunState::kRunning));
  CHECK_FALSE(control.take_resume());
  (void)control.ask(Command::kPause, "a");
  CHECK(control.pause_wanted());
  CHECK_FALSE(control.take_resume());
  CHECK(control.pause_wanted());
  (void)control.ask(Command::kResume, "a");
  CHECK_FALSE(control.pause_wanted());
  CHECK(control.take_resume());
  CHECK_FALSE(control.take_resume());
  CHECK_FALSE(control.pause_wanted());
}

TEST_CASE("control's answers: one answer to a question, from the page or by a resume") {
  Control control;
  CHECK_FALSE(control.answer(4, "yes", "ann").taken);
  control.publish(asked_status(RunState::kPaused, "Mounted?"));
  CHECK_FALSE(control.answer(3, "yes", "ann").taken);
  CHECK(control.who().empty());
  CHECK_FALSE(control.answer_to(4));
  CHECK_FALSE(control.status().answer);
  const Control::Answer taken = control.answer(4, "yes", "ann");
  CHECK(taken.taken);
  CHECK(control.who() == "ann");
  REQUIRE(control.answer_to(4));
  CHECK((control.answer_to(4)->text == "yes" && control.answer_to(4)->who == "ann"));
  CHECK(control.status().answer->question == 4);
  CHECK_FALSE(control.answer_to(5));
  const Control::Answer second = control.answer(4, "no", "eve"), resumed = control.ask(Command::kResume, "eve");
  for (const Control::Answer& late : {second, resumed}) {
    CHECK_FALSE(late.taken);
    CHECK_THAT(late.text, Catch::Contains("ann"));
  }
  CHECK(control.who() == "ann");
  CHECK_FALSE(control.take_resume());
  for (const RunState state : {RunState::kStopping, RunState::kEnded}) {
    Control ending;
    ending.publish(asked_status(state, "Mounted?"));
    const Control::Answer late = ending.answer(4, "yes", "ann");
    CHECK_FALSE(late.taken);
  }
  Control closed;
  closed.publish(asked_status(RunState::kPaused, "Mounted?"));
  CHECK_FALSE(closed.close(StopRequest()));
  CHECK_FALSE(closed.answer(4, "yes", "ann").taken);
}

TEST_CASE("control's answers: each status, each reading and each answer is a piece of news, a command is none") {
  Control control;
  CHECK(control.news() == 0);
  control.publish(asked_status(RunState::kPaused, "Mounted?"));
  CHECK(control.news() == 1);
  control.see({1.0, 2.0, 3.0, 4.0, true, {}});
  CHECK(control.news() == 2);
  (void)control.answer(4, "yes", "ann");
  CHECK(control.news() == 3);
  (void)control.answer(4, "no", "ann");
  (void)control.ask(Command::kStatus, "ann");
  (void)control.ask(Command::kStop, "ann");
  CHECK(control.news() == 3);
}
