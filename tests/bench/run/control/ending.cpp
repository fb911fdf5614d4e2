// Reasons for the end of a run, and parsing of its answers: without a rig and without a socket.

#include <fcntl.h>
#include <pty.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <functional>
#include <optional>
#include <string>

#include "bench/common/error.h"
#include "bench/common/terminal.h"
#include "bench/run/control/control.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/progress.h"
#include "bench/run/end_reason.h"
#include "bench/run/recorder.h"
#include "devices/device.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// Throws `thrown` and catches it.
template <class Thrown>
void met(EndReason& ending, const Thrown& thrown) {
  try {
    throw thrown;
  } catch (...) {
    ending.by_exception("here");
  }
}

const devices::Fault kDeviceFault("TB-SCANNER-LOST", "scanner", "gone", "plug it in");
const devices::Fault kTripFault("TB-CHAMBER-TRIP", "chamber", "67 psi", "look");

}  // namespace

TEST_CASE("answers: sender and acceptance are read, text that is not from a run gives no answer") {
  const auto live = read_answer("B/process/3", {12, 34, true},
                                R"({"bench":"B","run":9,"state":"paused","taken":true,"denied":true,"text":"t"})");
  REQUIRE(live);
  CHECK((live->name == "B/process/3" && live->bench == "B" && live->text == "t"));
  CHECK((live->server.process == 12 && live->server.user == 34 && live->server.in_group));
  CHECK((live->status.run == 9 && live->status.state == RunState::kPaused));
  CHECK((live->taken && live->denied));
  const auto bare = read_answer("B", {}, "{}");
  REQUIRE(bare);
  CHECK_FALSE((bare->taken || bare->denied || bare->status.run != 0));
  const std::vector<std::string> states = {"prepared",  "running",  "pausing", "paused",
                                           "suspended", "stopping", "ended"};
  for (std::size_t i = 0; i < states.size(); ++i) CHECK(to_string(static_cast<RunState>(i)) == states[i]);
  for (const char* strange : {"", "[]", "7", "{", R"({"run":"x"})", R"({"taken":1})"})
    CHECK_FALSE(read_answer("B", {}, strange));
}

TEST_CASE("ending: a command gives its outcome and exit code") {
  const auto ended = [](Command command, int signal) {
    const StopRequest signals;
    Control control;
    EndReason ending(control, signals);
    met(ending, RunEndRequested{command, signal, "bob"});
    CHECK(ending.error().value().where() == "here");
    CHECK_FALSE(ending.store_failed());
    CHECK_THAT(ending.error()->what(), Catch::Contains("bob"));
    return std::tuple(ending.error()->id(), ending.error()->code(), ending.outcome());
  };
  CHECK(ended(Command::kStop, 0) == std::tuple("TB-RUN-STOPPED", ExitCode::kStopped, db::Outcome::kStopped));
  CHECK(ended(Command::kStop, SIGTERM) == std::tuple("TB-RUN-STOPPED", ExitCode::kTerminated, db::Outcome::kStopped));
  CHECK(ended(Command::kAbort, 0) == std::tuple("TB-RUN-ABORTED", ExitCode::kStopped, db::Outcome::kAborted));
  CHECK(ended(Command::kPanic, 0) == std::tuple("TB-RUN-PANIC", ExitCode::kStopped, db::Outcome::kAborted));
}

TEST_CASE("ending: a fault gives its outcome, and which command outranks which fault") {
  const StopRequest signals;
  const auto ended = [&](const auto& thrown, std::optional<Command> word) {
    Control control;
    if (word) CHECK(control.ask(*word, "bob").taken);
    EndReason ending(control, signals);
    met(ending, thrown);
    return std::tuple(ending.error().value().id(), ending.error()->code(), ending.outcome(), ending.store_failed());
  };
  using db::Outcome;
  CHECK(ended(kDeviceFault, {}) == std::tuple("TB-SCANNER-LOST", ExitCode::kDevice, Outcome::kFailed, false));
  CHECK(ended(kTripFault, {}) == std::tuple("TB-CHAMBER-TRIP", ExitCode::kStopped, Outcome::kAborted, false));
  const db::StoreError full("TB-STORE-FULL", "full", "make room");
  CHECK(ended(full, {}) == std::tuple("TB-STORE-FULL", ExitCode::kStore, Outcome::kFailed, true));
  CHECK(ended(kDeviceFault, Command::kStop) ==
        std::tuple("TB-RUN-STOPPED", ExitCode::kStopped, Outcome::kStopped, false));
  CHECK(ended(kDeviceFault, Command::kAbort) ==
        std::tuple("TB-RUN-ABORTED", ExitCode::kStopped, Outcome::kAborted, false));
  CHECK(ended(kTripFault, Command::kAbort) ==
        std::tuple("TB-CHAMBER-TRIP", ExitCode::kStopped, Outcome::kAborted, false));
  CHECK(ended(kTripFault, Command::kPanic) == std::tuple("TB-RUN-PANIC", ExitCode::kStopped, Outcome::kAborted, false));
  CHECK(ended(full, Command::kStop) == std::tuple("TB-STORE-FULL", ExitCode::kStore, Outcome::kFailed, true));
  CHECK(ended(full, Command::kPanic) == std::tuple("TB-RUN-PANIC", ExitCode::kStopped, Outcome::kAborted, true));
  const Error unsafe("TB-SAFE-UNVERIFIED", "not proved", "");
  CHECK(ended(unsafe, Command::kPanic) == std::tuple("TB-RUN-PANIC", ExitCode::kUnsafe, Outcome::kAborted, false));
}

TEST_CASE("ending: a late abort or panic ends a run that nothing else has ended") {
  const StopRequest signals;
  struct Answers {
    std::optional<Error> error;
    db::Outcome outcome;
    std::vector<std::string> events;
  };
  const auto told = [&](const std::function<void(EndReason&, Control&)>& act) {
    const tests::TemporaryFolder folder;
    db::RunStore store = db::RunStore::open(folder.path("s.db"), db::Durability::kNormal);
    const std::int64_t number = tests::begin_example(store).run;
    devices::ManualClock clock;
    Recorder recorder(store, number, clock);
    Control control;
    EndReason ending(control, signals);
    act(ending, control);
    ending.record_last_command("at the end");
    CHECK_FALSE(control.ask(Command::kAbort, "late").taken);
    ending.write(recorder);
    Answers what{ending.error(), ending.outcome(), {}};
    for (const db::EventRecord& event : store.events(number)) what.events.push_back(event.kind + " " + event.id);
    return what;
  };
  using Events = std::vector<std::string>;
  const Answers done = told([](EndReason&, Control&) {});
  CHECK_FALSE(done.error);
  CHECK(done.outcome == db::Outcome::kCompleted);
  CHECK(done.events.empty());
  const Answers stop = told([](EndReason&, Control& control) { (void)control.ask(Command::kStop, "x"); });
  CHECK_FALSE(stop.error);
  CHECK(stop.events == Events{"word TB-RUN-STOPPED"});
  const Answers abort = told([](EndReason&, Control& control) { (void)control.ask(Command::kAbort, "x"); });
  CHECK(abort.error.value().id() == "TB-RUN-ABORTED");
  CHECK(abort.events == Events{"fault TB-RUN-ABORTED"});
  const Answers both = told([](EndReason& ending, Control& control) {
    met(ending, kDeviceFault);
    (void)control.ask(Command::kAbort, "x");
    ending.by(Error("TB-SAFE-UNVERIFIED", "", ""));  // something has ended it already
  });
  CHECK(both.error.value().id() == "TB-SCANNER-LOST");
  CHECK(both.events == Events{"fault TB-SCANNER-LOST", "word TB-RUN-ABORTED"});
  const Answers same = told([](EndReason& ending, Control& control) {
    (void)control.ask(Command::kStop, "x");
    met(ending, kDeviceFault);
  });
  CHECK(same.error.value().id() == "TB-RUN-STOPPED");
  CHECK_THAT(same.error->what(), Catch::Contains("TB-SCANNER-LOST"));
  CHECK(same.events == Events{"fault TB-SCANNER-LOST", "fault TB-RUN-STOPPED"});
  const Answers unsafe =
      told([](EndReason& ending, Control&) { ending.by(Error("TB-SAFE-UNVERIFIED", "not proved", "")); });
  CHECK(unsafe.error.value().id() == "TB-SAFE-UNVERIFIED");
  CHECK(unsafe.outcome == db::Outcome::kFailed);
}

// Signals to a run: what each of them asks for, and what becomes of the handlers of before.

TEST_CASE("signals: each signal except Ctrl-C requests the end at once, with its own exit code") {
  const auto [number, code] = GENERATE(table<int, int>({{SIGTERM, 143},
                                                        {SIGHUP, 129},
                                                        {SIGQUIT, 131},
                                                        {SIGUSR1, 138},
                                                        {SIGUSR2, 140},
                                                        {SIGALRM, 142},
                                                        {SIGVTALRM, 154},
                                                        {SIGPROF, 155},
                                                        {SIGIO, 157},
                                                        {SIGPWR, 158},
                                                        {64, 192}}));
  const auto before = std::signal(SIGHUP, SIG_DFL);  // the tests may run under nohup
  {
    const StopRequest signals;
    const Control control;
    CHECK(signals.ending() == 0);
    std::raise(number);
    std::raise(SIGINT);
    CHECK(signals.signal() == number);
    const auto leave = control.asked(signals);
    REQUIRE(leave);
    CHECK(leave->signal == number);
    CHECK(leave->command == Command::kStop);
    CHECK_FALSE(leave->who.empty());
    for (const int other : {SIGTERM, SIGHUP, SIGQUIT, SIGINT})
      CHECK((signal_text(other) == leave->who) == (other == number));
    CHECK(static_cast<int>(code_of_signal(leave->signal)) == code);
  }
  std::signal(SIGHUP, before);
}

TEST_CASE("signals: an ignored hang-up, as under nohup, stays ignored") {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  {
    const StopRequest signals;
    std::raise(SIGHUP);
    CHECK(signals.ending() == 0);
  }
  std::signal(SIGHUP, before);
}

TEST_CASE("signals: a signal during two stop requests reaches both") {
  const StopRequest whole;
  {
    const StopRequest part;
    std::raise(SIGTERM);
  }
  std::raise(SIGINT);
  CHECK((whole.signal() == SIGTERM && whole.interrupts() == 1));
  const StopRequest next;
  CHECK((next.ending() == SIGTERM && next.interrupts() == 1));
}

TEST_CASE("signals: a timer signal used by other code of the process is left alone") {
  static int rung = 0;
  rung = 0;
  const auto before = std::signal(SIGALRM, [](int) { rung = 1; });
  {
    const StopRequest signals;
    std::raise(SIGALRM);
    CHECK((rung == 1 && signals.ending() == 0));
  }
  std::signal(SIGALRM, before);
}

TEST_CASE("signals: the old handlers are restored, and a new request starts without signals") {
  static int old_seen;
  old_seen = 0;
  const auto before = std::signal(SIGUSR2, [](int) { ++old_seen; });
  {
    const StopRequest first;
    std::raise(SIGUSR2);
    CHECK(first.ending() == SIGUSR2);
  }
  std::raise(SIGUSR2);
  CHECK(old_seen == 1);
  std::signal(SIGUSR2, before);
  const StopRequest fresh;
  CHECK((fresh.signal() == 0 && fresh.ending() == 0 && fresh.interrupts() == 0));
}

TEST_CASE("Ctrl-C: the first pauses and the second ends, the first ends an unattended run") {
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
  CHECK_THROWS_AS(attended.poll(signals), RunEndRequested);
  CHECK(attended.close(signals)->signal == SIGINT);
}

TEST_CASE("Ctrl-C: a cancelled or finished pause no longer counts, panic outranks signals, signals outrank commands") {
  const StopRequest signals;
  Control control;
  RunStatus running;
  running.state = RunState::kRunning;
  control.publish(running);
  CHECK_FALSE(control.pause_wanted());
  control.poll(signals);
  CHECK_FALSE(control.pause_wanted());
  std::raise(SIGINT);
  CHECK(signals.interrupts() == 1);
  control.poll(signals);
  CHECK(control.pause_wanted());
  CHECK(control.ask(Command::kResume, "t").taken);
  CHECK(control.consume_resume());
  control.poll(signals);
  CHECK_FALSE(control.pause_wanted());  // the old Ctrl-C does not pause again
  std::raise(SIGINT);
  CHECK_NOTHROW(control.poll(signals));  // the first since then
  CHECK(control.pause_wanted());
  CHECK(control.ask(Command::kAbort, "x").taken);
  CHECK(control.asked(signals)->command == Command::kAbort);
  std::raise(SIGINT);
  REQUIRE(control.asked(signals));
  CHECK(control.asked(signals)->command == Command::kStop);
  CHECK(control.asked(signals)->signal == SIGINT);
  std::raise(SIGTERM);
  CHECK(control.asked(signals)->signal == SIGTERM);
  CHECK(signals.signal() == SIGINT);
  CHECK(control.ask(Command::kPanic, "p").taken);
  CHECK(control.asked(signals)->command == Command::kPanic);
  CHECK(control.asked(signals)->signal == 0);
}

// The progress line as it reaches standard error, in each mode, and which mode a process takes.

namespace {

// Standard error goes elsewhere while this lives.
class StandardErrorTo {
 public:
  explicit StandardErrorTo(int descriptor) : before_(::dup(STDERR_FILENO)) {
    std::fflush(stderr);
    ::dup2(descriptor, STDERR_FILENO);
  }
  ~StandardErrorTo() {
    std::fflush(stderr);
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  StandardErrorTo(const StandardErrorTo&) = delete;
  StandardErrorTo& operator=(const StandardErrorTo&) = delete;

 private:
  int before_;
};

std::string said_by(const std::function<void()>& act) {
  Captured said(stderr);
  act();
  return said.text();
}

RunStatus status_with_estimate() {
  RunStatus status;
  status.label = "run";
  status.phase = "warming up";
  status.step = 1;
  status.steps = 4;
  status.left_s = 120.0;
  status.left_high_s = 150.0;
  status.rate = 2.0;
  return status;
}

}  // namespace

TEST_CASE("progress: a plain line, a line that is overwritten, or none in quiet mode") {
  const RunStatus status = status_with_estimate();
  const std::string plain = said_by([&] { Progress(Progress::Mode::kPlain).show(status); });
  CHECK(std::ranges::count(plain, '\n') == 1);
  CHECK_THAT(plain, Catch::Contains("25 %") && Catch::Contains("1:00") && Catch::EndsWith("warming up\n"));
  CHECK(said_by([&] { Progress(Progress::Mode::kQuiet).show(status); }).empty());
  const std::string renewed = said_by([&] {
    Progress progress(Progress::Mode::kTerminal);
    progress.show(status);
    progress.show(status);
    progress.note("look");
    progress.finish();
    progress.finish();
  });
  CHECK(std::ranges::count(renewed, '\r') == 2);
  CHECK(std::ranges::count(renewed, '\n') == 2);
  CHECK_THAT(renewed, Catch::EndsWith("\nlook\n"));  // a note stays
  for (const auto mode : {Progress::Mode::kQuiet, Progress::Mode::kPlain, Progress::Mode::kTerminal})
    CHECK(said_by([&] { Progress(mode).note("look"); }) == "look\n");
}

TEST_CASE("progress: without an estimate, or in virtual time, the time left follows from the pace only") {
  RunStatus status = status_with_estimate();
  status.step = 0;  // no pace yet
  const auto has_time = [&] {
    return said_by([&] { Progress(Progress::Mode::kPlain).show(status); }).find("1:00") != std::string::npos;
  };
  CHECK(has_time());
  status.left_high_s = 0.0;
  CHECK_FALSE(has_time());
  status.left_high_s = 150.0;
  status.rate = 0.0;
  CHECK_FALSE(has_time());
}

TEST_CASE("progress: the line has the fraction of steps, the time left, set-point and readings") {
  RunStatus status;
  status.phase = "travelling";
  const auto has = [&](double left_s, const std::string& part) {
    return progress_line(status, left_s).find(part) != std::string::npos;
  };
  CHECK((has(3661.9, "61:01") && has(0.0, "0:00") && has(59.99, "0:59") && has(60.0, "1:00")));
  CHECK_FALSE((has(-0.1, ":0") || has(-0.1, "%")));
  status.steps = 1;
  CHECK(has(-0.1, " 0 %"));
  status.step = 1;
  CHECK(has(-0.1, "100 %"));
  CHECK_FALSE(has(-0.1, "psi"));
  status.readings = RunReadings{1.0, 20.0, 19.0, 18.5, false, 9.6};
  CHECK((has(-0.1, "20.0 psi") && has(-0.1, "18.5")));
  status.target_n = 2.0;
  CHECK((has(-0.1, "2.0 N") && has(-0.1, "9.6")));
}

TEST_CASE("progress: after a line the next one is not due at once, even for another phase") {
  RunStatus status = status_with_estimate();
  said_by([&] {
    for (const auto mode : {Progress::Mode::kPlain, Progress::Mode::kTerminal}) {
      Progress progress(mode);
      CHECK(progress.due(status));
      const auto before = Pace::Clock::now();
      progress.show(status);
      RunStatus next = status;
      next.phase = "conditioning 1 of 6";
      const bool due = progress.due(next);
      if (Pace::Clock::now() - before < std::chrono::milliseconds(90)) CHECK_FALSE(due);
    }
  });
}

TEST_CASE("progress: the overwritten line is used only on terminals that support it, outside CI") {
  int terminal = -1, program = -1;
  REQUIRE(::openpty(&terminal, &program, nullptr, nullptr, nullptr) == 0);
  const auto mode_with = [](int error, const std::optional<std::string>& term, const std::optional<std::string>& ci,
                            bool quiet) {
    const Variable first("TERM", term), second("CI", ci);
    const StandardErrorTo elsewhere(error);
    return Progress::mode_for(quiet);
  };
  CHECK(mode_with(program, "xterm", std::nullopt, false) == Progress::Mode::kTerminal);
  CHECK(mode_with(program, "xterm", std::nullopt, true) == Progress::Mode::kQuiet);
  CHECK(mode_with(program, "dumb", std::nullopt, false) == Progress::Mode::kPlain);
  CHECK(mode_with(program, std::nullopt, std::nullopt, false) == Progress::Mode::kPlain);
  CHECK(mode_with(program, "xterm", "true", false) == Progress::Mode::kPlain);
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  CHECK(mode_with(null, "xterm", std::nullopt, false) == Progress::Mode::kPlain);
  for (const int descriptor : {terminal, program, null}) ::close(descriptor);
}

TEST_CASE("status board: the last step is printed before it is due, an earlier step and a refresh are not") {
  Control control;
  const auto shown = [&](int step, bool done) {
    return said_by([&] {
      Progress progress(Progress::Mode::kPlain);
      StatusBoard board(control, progress);
      board.now() = status_with_estimate();
      board.now().rate = 0.0;
      board.now().step = step;
      board.publish();
      if (done)
        board.step_done();
      else
        board.refresh();
    });
  };
  said_by([] { tty::print(stderr, "\n"); });  // ends what another test left open
  CHECK(shown(3, true).empty());
  CHECK(shown(4, false).empty());
  CHECK_THAT(shown(4, true), Catch::Contains("100 %"));
}
