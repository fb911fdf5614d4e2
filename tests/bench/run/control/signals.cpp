// Signals to a run: what each of them asks for, and what becomes of the handlers of before.
#include <catch2/catch.hpp>
#include <csignal>

#include "bench/common/error.h"
#include "bench/run/control/control.h"

using namespace tactbench;
using namespace tactbench::bench;

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
