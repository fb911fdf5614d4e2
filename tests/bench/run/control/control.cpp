// Which commands a run takes in each of its states, and what Control remembers of them.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/run/control/control.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "bench/run/control/progress.h"
#include "bench/run/control/run_status.h"
#include "bench/run/end_reason.h"
#include "tests/bench/monitor/status_example.h"
#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace std::chrono_literals;
using namespace tactbench::bench;
using namespace tactbench::tests;

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

TEST_CASE("run states: only the transitions of the table are allowed") {
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

TEST_CASE("control: which command is accepted in which state, and who sent it") {
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

TEST_CASE("commands: the end of a run is attributed to the first sender of the strongest command") {
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

TEST_CASE("control: after the last step pause, resume and stop are too late, abort and panic are accepted") {
  const StopRequest signals;
  for (const Command command : {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic}) {
    Control control;
    control.publish(asked_status(RunState::kRunning));
    control.finish(signals);
    const bool late = command < Command::kAbort;
    const Control::Answer answer = control.ask(command, "bob");
    CHECK(answer.taken == !late);
    CHECK_FALSE(control.pause_wanted());
    CHECK_FALSE(control.consume_resume());
  }
  Control before;
  CHECK(before.ask(Command::kStop, "bob").taken);
  try {
    before.finish(signals);
    FAIL("it was asked to stop before");
  } catch (const RunEndRequested& leave) {
    CHECK((leave.command == Command::kStop && leave.signal == 0 && leave.who == "bob"));
  }
  try {
    before.poll(signals);
    FAIL("it was asked to stop before");
  } catch (const RunEndRequested& leave) {
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

TEST_CASE("control: pause and resume requests are pending until used or cancelled") {
  Control control;
  control.publish(asked_status(RunState::kRunning));
  CHECK_FALSE(control.consume_resume());
  (void)control.ask(Command::kPause, "a");
  CHECK(control.pause_wanted());
  CHECK_FALSE(control.consume_resume());
  CHECK(control.pause_wanted());
  (void)control.ask(Command::kResume, "a");
  CHECK_FALSE(control.pause_wanted());
  CHECK(control.consume_resume());
  CHECK_FALSE(control.consume_resume());
  CHECK_FALSE(control.pause_wanted());
}

TEST_CASE("control: a question gets one answer, from a client or by resume") {
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
  CHECK_FALSE(control.consume_resume());
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

TEST_CASE("control: each status, reading and answer counts as an update, a command does not") {
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

// Requests of a client over the control socket, read and written.

TEST_CASE("client messages: a written message is read back, including the person that it is sent for") {
  const ClientRequest pause = parse_client_request(command_packet(Command::kPause, "bob of 127.0.0.1"));
  CHECK(pause.word == ClientRequestKind::kCommand);
  CHECK(pause.command == Command::kPause);
  CHECK(pause.behalf == "bob of 127.0.0.1");
  const ClientRequest answer = parse_client_request(answer_packet(3, "mounted, 2 Nm", ""));
  CHECK(answer.word == ClientRequestKind::kAnswer);
  CHECK(answer.question == 3);
  CHECK(answer.text == "mounted, 2 Nm");
  CHECK(answer.behalf.empty());
  CHECK(parse_client_request(answer_packet(3, "", "bob")).text.empty());
  CHECK(parse_client_request("follow").word == ClientRequestKind::kFollow);
  for (const Command command : {Command::kStatus, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic})
    CHECK(parse_client_request(to_string(command)).command == command);
}

TEST_CASE("client messages: unknown text counts as a status request, and text cannot add a line") {
  for (const char* text : {"", " ", "halt", "pausee", "PAUSE", "\npause", "answers 1"}) {
    INFO(text);
    CHECK(parse_client_request(text).word == ClientRequestKind::kCommand);
    CHECK(parse_client_request(text).command == Command::kStatus);
  }
  for (const char* text : {"answer", "answer ", "answer x", "answer 3x yes", "answer 99999999999 yes"})
    CHECK(parse_client_request(text).question == 0);
  const ClientRequest read = parse_client_request(answer_packet(1, "yes\nabort\x1b[31m", "bob\nroot"));
  CHECK(read.word == ClientRequestKind::kAnswer);
  CHECK(read.text.find('\n') == std::string::npos);
  CHECK(read.text.find('\x1b') == std::string::npos);
  CHECK(read.behalf.find('\n') == std::string::npos);
  CHECK(read.behalf.starts_with("bob"));
  CHECK(command_packet(Command::kStop, std::string(5000, 'x')).size() < 500);
}

TEST_CASE("client messages: text is cut to its maximum width, and a command ends at the first blank") {
  const std::string long_text(1000, 'x');
  const std::string cut_behalf = std::string(kMaxBehalfColumns - 1, 'x') + "\u2026";
  const std::string cut_reply = std::string(kMaxReplyColumns - 1, 'x') + "\u2026";
  CHECK(command_packet(Command::kStop, "") == "stop");
  CHECK(command_packet(Command::kStop, "ann") == "stop\nann");
  CHECK(command_packet(Command::kStop, long_text) == "stop\n" + cut_behalf);
  CHECK(answer_packet(12, "a b", "") == "answer 12 a b");
  CHECK(answer_packet(12, long_text, "ann") == "answer 12 " + cut_reply + "\nann");
  CHECK(parse_client_request("stop now").command == Command::kStop);
  CHECK(parse_client_request("stop\n" + long_text).behalf == cut_behalf);
  CHECK(parse_client_request("stop\n").behalf.empty());
  CHECK(parse_client_request("follow me\nann").word == ClientRequestKind::kFollow);
  CHECK(parse_client_request("follow me\nann").behalf == "ann");
  const ClientRequest read = parse_client_request("answer 12  two blanks\nann");
  CHECK((read.word == ClientRequestKind::kAnswer && read.question == 12 && read.text == " two blanks" &&
         read.behalf == "ann"));
  CHECK(parse_client_request("answer 12 " + long_text).text == cut_reply);
  CHECK(parse_client_request("answer -3 x").question == -3);
}

TEST_CASE("peers: are shown by user name, or by number if the name is unknown") {
  CHECK(peer_text({812, 0, false}) == "root (pid 812)");
  CHECK(peer_text({812, 3999999999U, false}) == "user 3999999999 (pid 812)");
  CHECK_FALSE(peer_of(-1));
}

// A run's status: through the socket's JSON and back, kept by Control, and as the progress line.

TEST_CASE("status: a client reads every member of the status that a run sends") {
  RunStatus sent = example_status();
  sent.question_id = 4;
  sent.frames_void = 3;
  sent.answer = GivenAnswer{3, "mounted", "bob"};
  nlohmann::json told, bare, again;
  add_status_json(told, sent);
  add_status_json(bare, status_from_json(nlohmann::json::object()));
  CHECK(told.size() == 22);
  for (const auto& [key, value] : told.items()) {
    INFO(key);
    CHECK((!bare.contains(key) || bare.at(key) != value));  // no member of the example is what is read of nothing
  }
  add_status_json(again, status_from_json(nlohmann::json::parse(told.dump())));
  CHECK(again == told);
  CHECK((told.at("readings").size() == 6 && told.at("answer").size() == 3));
  const RunStatus read = status_from_json(told);
  CHECK((read.run == 7 && read.step == 19 && read.steps == 217));
  CHECK((read.frames == 12 && read.frames_void == 3 && read.frames_planned == 211));
  CHECK((read.left_low_s == 630.0 && read.left_s == 645.0 && read.left_high_s == 680.0 && read.age_s == 0.25));
  CHECK((read.readings->feedback_psi == 39.98 && read.readings->reference_psi == 40.01 && read.target_n == 10.0));
  const RunStatus nothing = status_from_json(nlohmann::json::object());
  CHECK((nothing.run == 0 && nothing.state == RunState::kEnded && nothing.rate == 1.0));
  CHECK_FALSE((nothing.readings || nothing.target_n || nothing.answer));
  const nlohmann::json empty = nlohmann::json::object();
  const RunStatus hollow = status_from_json({{"readings", empty}, {"answer", empty}});
  REQUIRE((hollow.readings && hollow.answer));
  CHECK_FALSE((hollow.readings->settled || hollow.readings->force_n || hollow.answer->question != 0));
  for (int i = 0; i <= static_cast<int>(RunState::kEnded); ++i) {
    const auto state = static_cast<RunState>(i);
    CHECK(status_from_json({{"state", to_string(state)}}).state == state);
  }
  CHECK_THROWS_AS(status_from_json({{"readings", 3}}), nlohmann::json::exception);
}

TEST_CASE("status: an answer is short and free of control characters, however long the question of a recipe is") {
  RunStatus status = example_status();
  status.question = "is\x1b[2J it \n" + std::string(100000, 'q');
  status.phase = status.reason = status.question;
  nlohmann::json told;
  add_status_json(told, status);
  CHECK(told.dump().size() < 4000);
  CHECK_THAT(told["question"].get<std::string>(), Catch::StartsWith("is\\x1b[2J it \\x0a"));
}

TEST_CASE("status: Control keeps the readings when the step changes, and reports their age") {
  Control control;
  CHECK_FALSE(control.status().readings);
  control.see({1.0, 2.0, 3.0, 4.0, true, 5.0});
  RunStatus next;
  next.phase = "next";
  next.age_s = 99.0;
  control.publish(next);
  const RunStatus status = control.status();
  CHECK(status.phase == "next");
  REQUIRE(status.readings);
  CHECK((status.readings->reference_psi == 4.0 && status.readings->force_n == 5.0));
  CHECK(status.age_s >= 0.0);
  CHECK(status.age_s < 60.0);
}

TEST_CASE("progress: the first phase is due at once in real time, but not as a plain line in virtual time") {
  RunStatus status;
  status.phase = "opening the devices";
  for (const Progress::Mode mode : {Progress::Mode::kPlain, Progress::Mode::kTerminal}) {
    CHECK(Progress(mode).due(status));
    RunStatus turned = status;
    turned.rate = 0.0;
    if (mode == Progress::Mode::kPlain) CHECK_FALSE(Progress(mode).due(turned));
  }
  CHECK_FALSE(Progress(Progress::Mode::kQuiet).due(status));
}

TEST_CASE("progress: in plain lines a step is not a separate phase, a conditioning cycle is") {
  CHECK(stage_of("small, step 7 of 22, repeat 1 of 2, loading") == "small");
  CHECK(stage_of("conditioning 2 of 6") == "conditioning 2 of 6");
  CHECK(stage_of("").empty());
}

TEST_CASE("status board: a new phase is reported to clients") {
  Control control;
  Progress progress(Progress::Mode::kQuiet);
  StatusBoard board(control, progress);
  board.now().run = 7;
  board.now().store = "/s.db";
  CHECK(control.status().run == 0);
  board.phase("warming up");
  CHECK(control.status().run == 7);
  CHECK(control.status().phase == "warming up");
  // Without an estimate the time left is by the pace so far; with one it stays.
  board.now().steps = 100;
  board.now().rate = 150.0;
  board.publish();
  CHECK(control.status().left_s == 0.0);
  board.now().step = 10;
  board.publish();
  CHECK((control.status().left_s > 0.0 && control.status().left_high_s == 0.0));
  board.now().left_s = 50.0;
  board.now().left_high_s = 60.0;
  board.publish();
  CHECK(control.status().left_s == 50.0);
}

TEST_CASE(
    "pace: the time left follows from the pace so far, and restarts after a return path or a rest over a minute") {
  const auto start = Pace::Clock::now();
  Pace pace(start);
  CHECK(pace.left_s(start, 0, 100) < 0.0);
  CHECK(pace.left_s(start + 10s, 10, 100) == 90.0);
  CHECK(pace.left_s(start + 20s, 40, 100) == 30.0);
  CHECK(pace.left_s(start + 25s, 5, 100) < 0.0);  // the repeat is done again
  CHECK(pace.left_s(start + 35s, 10, 100) == 180.0);
  Pace rested(start);
  CHECK(rested.left_s(start + 60s, 10, 40) == 180.0);
  CHECK(rested.left_s(start + 120s, 10, 40) == 360.0);  // the same step again gives no new information
  CHECK(rested.left_s(start + 180s + 1ns, 20, 40) < 0.0);
  CHECK(rested.left_s(start + 190s + 1ns, 20, 40) < 0.0);
  CHECK(rested.left_s(start + 200s + 1ns, 30, 40) == 20.0);
  CHECK(rested.left_s(start + 201s, 40, 40) == 0.0);
}

TEST_CASE("status: the phase of a step has its number, its repeat and its direction") {
  sequences::Recipe recipe;
  recipe.name = "descending";
  recipe.repeats = 5;
  recipe.conditioning.cycles = 6;
  sequences::Step step;
  const auto has = [&](const std::vector<std::string>& parts) {
    const std::string phase = phase_of(step, recipe, 19, 217);
    INFO(phase);
    for (const std::string& part : parts) CHECK(phase.find(part) != std::string::npos);
  };
  step.kind = sequences::StepKind::kConditioning;
  step.branch = -1;
  step.repeat = 1;
  has({"2 of 6"});
  const std::string counted = phase_of(step, recipe, 3, 217);
  recipe.conditioning.change_percent = 0.1;  // fewer may do
  CHECK(phase_of(step, recipe, 3, 217) != counted);
  step.kind = sequences::StepKind::kApproach;  // of a conditioning press
  has({"2 of", "6"});
  step.branch = 0;
  CHECK(phase_of(step, recipe, 3, 217).find("6") == std::string::npos);
  step.kind = sequences::StepKind::kMeasure;
  step.branch_from = devices::Psi(60.0);
  has({"descending", "19 of 217", "2 of 5"});
  const std::string falling = phase_of(step, recipe, 19, 217);
  step.branch_to = devices::Psi(61.0);
  CHECK(phase_of(step, recipe, 19, 217) != falling);
  step.kind = sequences::StepKind::kConditioning;  // on the way back
  step.setpoint = devices::Psi(20.0);
  has({"20 psi"});
  step.kind = sequences::StepKind::kPress;
  step.force_n = 10.0;
  step.frame = false;
  has({"10 N"});
  step.kind = sequences::StepKind::kMoveXy;
  step.x_mm = 12.5;
  has({"x 12.5 mm", "y 0 mm"});
  step.kind = sequences::StepKind::kConditioning;
  recipe.conditioning.cycles = 0;  // conditioned once on the way back
  recipe.conditioning.change_percent = 0.0;
  step.branch = -1;
  step.repeat = 0;
  has({"1 of 1"});
}

// Commands that are told of a run's events.

TEST_CASE("notify: the command gets event, run and reason in its environment, in its own shell") {
  const TemporaryFolder folder;
  const std::string told = folder.path("told");
  const auto appears = [&](const std::string& text) {
    return comes_true([&] { return std::filesystem::exists(told) && read_file(told) == text; });
  };
  const Variable own("TACTBENCH_EVENT", "of an outer run");
  const Notify notify("printf '%s|%s|%s' \"$TACTBENCH_EVENT\" \"$TACTBENCH_RUN\" \"$TACTBENCH_REASON\" >'" +
                      folder.path("new") + "'; mv '" + folder.path("new") + "' '" + told + "' # a comment");
  notify.run_command("done", 17, "all steps 'done'; \"really\"");
  CHECK(appears("done|17|all steps 'done'; \"really\""));
  std::filesystem::remove(told);
  Notify("").run_command("done", 17, "x");
  notify.run_command("waiting", -1, "");
  CHECK(appears("waiting|-1|"));
}
