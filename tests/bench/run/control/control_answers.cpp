// What Control answers in each state and remembers of it, and the words of its clients at their lengths.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include "bench/common/for_people.h"
#include "bench/run/control/client_words.h"
#include "bench/run/control/control.h"
#include "bench/run/control/peer.h"
#include "bench/run/control/progress.h"
#include "bench/run/control/run_status.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace std::chrono_literals;

namespace {

RunStatus asked_status(RunState state, const std::string& question = {}) {
  RunStatus status;
  status.run = 7;
  status.state = state;
  status.question = question;
  status.question_id = question.empty() ? 0 : 4;
  return status;
}

// What a run in that state answers to a command: "+" taken, "-" refused.
std::string answer_in(RunState state, Command command, const std::string& question = {}) {
  Control control;
  control.publish(asked_status(state, question));
  const Control::Answer answer = control.ask(command, "bob");
  CHECK(control.who() == (answer.taken && command != Command::kStatus ? "bob" : ""));
  return (answer.taken ? "+" : "-") + answer.text;
}

}  // namespace

TEST_CASE("control's answers: a resume in each state, with and without a question") {
  const std::string on = "+run 7 continues: ";
  CHECK(answer_in(RunState::kPaused, Command::kResume) == on + "conditioned again, then the next branch");
  CHECK(answer_in(RunState::kPausing, Command::kResume) == on + "the pause is taken back");
  CHECK(answer_in(RunState::kPaused, Command::kResume, "Mounted?") == on + "it takes this as the answer to: Mounted?");
  CHECK(answer_in(RunState::kPausing, Command::kResume, "Mounted?") == on + "it takes this as the answer to: Mounted?");
  for (const RunState state : {RunState::kPrepared, RunState::kRunning, RunState::kSuspended})
    CHECK(answer_in(state, Command::kResume) == std::string("-run 7 is ") + to_string(state) + ", not paused");
}

TEST_CASE("control's answers: a pause, a stop, an abort and a panic in each state") {
  const std::string pauses = "+run 7 pauses at the end of this branch; 'stop' ends it at once";
  for (const RunState state : {RunState::kPrepared, RunState::kRunning, RunState::kPausing, RunState::kSuspended})
    CHECK(answer_in(state, Command::kPause) == pauses);
  CHECK(answer_in(RunState::kPaused, Command::kPause) == "-run 7 is paused already");
  for (const RunState state : {RunState::kPrepared, RunState::kRunning, RunState::kPausing, RunState::kPaused}) {
    for (const Command command : {Command::kStop, Command::kAbort})
      CHECK(answer_in(state, command) == "+run 7 ends: vents, retracts and proves it");
    CHECK(answer_in(state, Command::kPanic) == "+run 7 ends: vented and halted past the sequencer");
    CHECK(answer_in(state, Command::kStatus) == std::string("+") + to_string(state));
  }
  for (const RunState state : {RunState::kStopping, RunState::kEnded})
    for (const Command command : {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic})
      CHECK(answer_in(state, command) == std::string("-run 7 is ") + to_string(state) + " already");
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
    if (late) CHECK(answer.text == "run 7 has done all its steps: it vents, retracts, proves it and ends");
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
  CHECK(control.answer(4, "yes", "ann").text == "run 0 does not wait for an answer to question 4");
  control.publish(asked_status(RunState::kPaused, "Mounted?"));
  CHECK(control.answer(3, "yes", "ann").text == "run 7 does not wait for an answer to question 3");
  CHECK(control.who().empty());
  CHECK_FALSE(control.answer_to(4));
  CHECK_FALSE(control.status().answer);
  const Control::Answer taken = control.answer(4, "yes", "ann");
  CHECK(taken.taken);
  CHECK(taken.text == "run 7 continues: question 4 is answered");
  CHECK(control.who() == "ann");
  REQUIRE(control.answer_to(4));
  CHECK((control.answer_to(4)->text == "yes" && control.answer_to(4)->who == "ann"));
  CHECK(control.status().answer->question == 4);
  CHECK_FALSE(control.answer_to(5));
  const Control::Answer second = control.answer(4, "no", "eve"), resumed = control.ask(Command::kResume, "eve");
  for (const Control::Answer& late : {second, resumed}) {
    CHECK_FALSE(late.taken);
    CHECK(late.text == "question 4 has its answer already, by ann");
  }
  CHECK(control.who() == "ann");
  CHECK_FALSE(control.take_resume());
  for (const RunState state : {RunState::kStopping, RunState::kEnded}) {
    Control ending;
    ending.publish(asked_status(state, "Mounted?"));
    const Control::Answer late = ending.answer(4, "yes", "ann");
    CHECK_FALSE(late.taken);
    CHECK(late.text == "run 7 is ending: it waits for no answer");
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

TEST_CASE("control's answers: the first Ctrl-C pauses, the second ends, the first alone where nobody is there") {
  const StopRequest signals;
  Control alone, attended;
  alone.end_by_first_interrupt();
  std::raise(SIGINT);
  CHECK(alone.asked(signals));
  CHECK_FALSE(attended.asked(signals));
  attended.poll(signals);
  CHECK(attended.pause_wanted());
  std::raise(SIGINT);
  REQUIRE(attended.asked(signals));
  CHECK(attended.close(signals)->signal == SIGINT);
}

TEST_CASE("client words: texts are cut to their columns, and words end at the first blank") {
  const std::string long_text(1000, 'x');
  const std::string cut_behalf = std::string(kLongestBehalf - 1, 'x') + "\u2026";
  const std::string cut_reply = std::string(kLongestReply - 1, 'x') + "\u2026";
  CHECK(command_words(Command::kStop, "") == "stop");
  CHECK(command_words(Command::kStop, "ann") == "stop\nann");
  CHECK(command_words(Command::kStop, long_text) == "stop\n" + cut_behalf);
  CHECK(answer_words(12, "a b", "") == "answer 12 a b");
  CHECK(answer_words(12, long_text, "ann") == "answer 12 " + cut_reply + "\nann");
  CHECK(read_words("stop now").command == Command::kStop);
  CHECK(read_words("stop\n" + long_text).behalf == cut_behalf);
  CHECK(read_words("stop\n").behalf.empty());
  CHECK(read_words("follow me\nann").word == ClientWord::kFollow);
  CHECK(read_words("follow me\nann").behalf == "ann");
  const ClientWords read = read_words("answer 12  two blanks\nann");
  CHECK(
      (read.word == ClientWord::kAnswer && read.question == 12 && read.text == " two blanks" && read.behalf == "ann"));
  CHECK(read_words("answer 12 " + long_text).text == cut_reply);
  CHECK(read_words("answer -3 x").question == -3);
}

TEST_CASE("progress lines: other units, thousands of seconds, no share without steps, no readings") {
  RunStatus status;
  status.label = "run";
  status.phase = "travelling to 20 psi";
  CHECK(progress_line(status, 3661.9) == "run: 61:01 left  travelling to 20 psi");
  CHECK(progress_line(status, 0.0) == "run: 0:00 left  travelling to 20 psi");
  CHECK(progress_line(status, 59.99) == "run: 0:59 left  travelling to 20 psi");
  CHECK(progress_line(status, 60.0) == "run: 1:00 left  travelling to 20 psi");
  status.steps = 1;
  CHECK(progress_line(status, -0.1) == "run:   0 %  travelling to 20 psi");
  status.step = 1;
  CHECK(progress_line(status, -0.1) == "run: 100 %  travelling to 20 psi");
  status.readings = RunReadings{1.0, 20.0, 19.0, 18.5, false, {}};
  CHECK(progress_line(status, -0.1) == "run: 100 %  travelling to 20 psi  20.0 psi (reference 18.5)");
  status.target_n = 2.0;
  CHECK(progress_line(status, -0.1) == "run: 100 %  travelling to 20 psi  2.0 N (force 0.0)");
}

TEST_CASE("pace: a minute's rest is none, a longer one begins anew, and the same step again tells nothing more") {
  const auto start = Pace::Clock::now();
  Pace pace(start);
  CHECK(pace.left_s(start + 60s, 10, 40) == 180.0);
  CHECK(pace.left_s(start + 120s, 10, 40) == 360.0);
  CHECK(pace.left_s(start + 180s + 1ns, 20, 40) < 0.0);
  CHECK(pace.left_s(start + 190s + 1ns, 20, 40) < 0.0);
  CHECK(pace.left_s(start + 200s + 1ns, 30, 40) == 20.0);
}

TEST_CASE("peers: their names from the user database, or their numbers") {
  CHECK(peer_text({812, 0, false}) == "root (pid 812)");
  CHECK(peer_text({812, 3999999999U, false}) == "user 3999999999 (pid 812)");
  CHECK_FALSE(peer_of(-1));
}
