// The small parts of a run without a rig: states, words, the branch guard, conditioning by criterion, suspension.
#include <catch2/catch.hpp>
#include <csignal>
#include <map>

#include "bench/common/error.h"
#include "bench/run/control/control.h"
#include "bench/run/time_spent.h"
#include "bench/run/watch/branch_guard.h"
#include "bench/run/watch/conditioning.h"
#include "bench/run/watch/suspension.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("run states follow the table and nothing else") {
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

TEST_CASE("commands: the strongest wins, resume cancels a pause, an ended run accepts none") {
  const StopRequest signals;
  Control control;
  RunStatus status;
  status.run = 7;
  status.state = RunState::kRunning;
  control.publish(status);
  CHECK_FALSE(control.ask(Command::kResume, "t").taken);
  CHECK(control.ask(Command::kPause, "t").taken);
  CHECK(control.pause_wanted());
  CHECK_NOTHROW(control.poll(signals));
  CHECK(control.ask(Command::kResume, "t").taken);
  CHECK_FALSE(control.pause_wanted());
  CHECK(control.take_resume());
  CHECK_FALSE(control.take_resume());
  bool panicked = false;
  control.on_panic([&] { panicked = true; });
  CHECK(control.ask(Command::kStop, "t").taken);
  CHECK_FALSE(panicked);
  CHECK(control.ask(Command::kPanic, "who").taken);
  CHECK(panicked);
  CHECK(control.ask(Command::kAbort, "t").taken);
  try {
    control.poll(signals);
    FAIL("nobody left");
  } catch (const Leave& leave) {
    CHECK(leave.command == Command::kPanic);
    CHECK(leave.signal == 0);
  }
  status.state = RunState::kStopping;
  control.publish(status);
  CHECK_FALSE(control.ask(Command::kStop, "t").taken);
}

TEST_CASE("commands: resume reports its effect: an answer, a pause ended or cancelled") {
  Control control;
  RunStatus status;
  status.run = 7;
  status.state = RunState::kPaused;
  control.publish(status);
  CHECK_THAT(control.ask(Command::kResume, "t").text, Catch::Contains("conditioned again"));
  status.question = "Point indenter mounted?";
  control.publish(status);
  CHECK(control.ask(Command::kResume, "t").text ==
        "run 7 continues: it takes this as the answer to: Point indenter mounted?");
  status.question.clear();
  status.state = RunState::kPausing;
  control.publish(status);
  CHECK_THAT(control.ask(Command::kResume, "t").text, Catch::Contains("taken back"));
}

TEST_CASE("signals: each but Ctrl-C asks for the end at once, named, with its own exit code") {
  const auto [number, text, code] = GENERATE(table<int, std::string, int>({{SIGTERM, "terminate", 143},
                                                                           {SIGHUP, "hang-up", 129},
                                                                           {SIGQUIT, "quit", 131},
                                                                           {SIGUSR1, "signal 10", 138},
                                                                           {SIGUSR2, "signal 12", 140},
                                                                           {SIGALRM, "signal 14", 142},
                                                                           {SIGVTALRM, "signal 26", 154},
                                                                           {SIGPROF, "signal 27", 155},
                                                                           {SIGIO, "signal 29", 157},
                                                                           {64, "signal 64", 192}}));
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
    CHECK_THAT(leave->who, Catch::Contains(text));
    CHECK(static_cast<int>(code_of_signal(leave->signal)) == code);
  }
  std::signal(SIGHUP, before);
}

TEST_CASE("signals: a hang-up that is ignored, as under nohup, stays so") {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  {
    const StopRequest signals;
    std::raise(SIGHUP);
    CHECK(signals.ending() == 0);
  }
  std::signal(SIGHUP, before);
}

TEST_CASE("signals: a signal while two stop requests exist reaches both") {
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

TEST_CASE("signals: a timer that other code of the process uses is left alone") {
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

TEST_CASE("Ctrl-C once asks to pause, twice to stop") {
  const StopRequest signals;
  Control control;
  std::raise(SIGINT);
  CHECK_NOTHROW(control.poll(signals));
  CHECK(control.pause_wanted());
  std::raise(SIGINT);
  try {
    control.poll(signals);
    FAIL("nobody left");
  } catch (const Leave& leave) {
    CHECK(leave.command == Command::kStop);
    CHECK(leave.signal == SIGINT);
  }
}

TEST_CASE("Ctrl-C once ends an unattended run") {
  const StopRequest signals;
  Control control;
  control.end_by_first_interrupt();
  std::raise(SIGINT);
  CHECK_THROWS_AS(control.poll(signals), Leave);
}

TEST_CASE("commands: one before the last step ends the run, a stop after it is answered as too late") {
  const StopRequest signals;
  Control asked, done;
  CHECK(asked.ask(Command::kStop, "t").taken);
  CHECK_THROWS_AS(asked.finish(signals), Leave);
  CHECK_NOTHROW(done.finish(signals));
  for (const Command late : {Command::kPause, Command::kResume, Command::kStop}) {
    const Control::Answer answer = done.ask(late, "t");
    CHECK_FALSE(answer.taken);
    CHECK_THAT(answer.text, Catch::Contains("has done all its steps"));
  }
  CHECK_FALSE(done.pause_wanted());
  CHECK_FALSE(done.close(signals));
  CHECK(done.ask(Command::kStatus, "t").taken);
  Control aborted;
  aborted.finish(signals);
  CHECK(aborted.ask(Command::kAbort, "t").taken);
  CHECK(aborted.close(signals));
}

TEST_CASE("branch guard: a step back beyond the tolerance breaks a branch, one within does not") {
  BranchGuard rising(0.0, 60.0, 0.2);
  CHECK_FALSE(rising.see(10.0));
  CHECK_FALSE(rising.see(10.2));
  CHECK_FALSE(rising.see(10.0));  // exactly the tolerance, but for rounding
  CHECK_FALSE(rising.see(20.0));
  REQUIRE(rising.see(19.7));
  BranchGuard falling(60.0, 0.0, 0.2);
  CHECK_FALSE(falling.see(40.0));
  CHECK_FALSE(falling.see(39.0));
  CHECK_THAT(falling.see(39.3).value(), Catch::Contains("rose again to 39.30"));
  BranchGuard level(20.0, 20.0, 0.2);
  CHECK_FALSE(level.see(20.0));
  CHECK_FALSE(level.see(20.15));
  CHECK(level.see(20.4));
  BranchGuard broken_reading(0.0, 60.0, 0.2);
  CHECK(broken_reading.see(std::nan("")));
}

TEST_CASE("conditioning ends when a loop no longer differs from the one before it") {
  sequences::Conditioning rule;
  rule.cycles = 6;
  rule.least = 2;
  rule.change_percent = 1.0;
  rule.peak = devices::Psi(60.0);
  ConditioningWatch watch(rule);
  const auto cycle = [&](int number, std::uint16_t peak, std::uint16_t zero) {
    sequences::Step step;
    step.repeat = number;
    step.setpoint = rule.peak;
    watch.see(step, {peak, peak});
    step.setpoint = devices::Psi(0.0);
    watch.see(step, {zero, zero});
  };
  CHECK_FALSE(watch.enough(0));
  cycle(0, 10000, 100);
  CHECK_FALSE(watch.enough(1));
  cycle(1, 10300, 100);  // 3 %
  CHECK_FALSE(watch.enough(2));
  CHECK(watch.verdict() == "warning");
  cycle(2, 10301, 190);  // 0.9 %, at zero
  CHECK(watch.enough(3));
  CHECK(watch.verdict() == "pass");
  REQUIRE(watch.changes().size() == 2);
  CHECK(watch.changes()[0] == Approx(100.0 * 300 / 10200));
  CHECK(watch.changes()[1] == Approx(100.0 * 90 / 10111));
  rule.change_percent = 0.0;
  const ConditioningWatch counting(rule);
  CHECK_FALSE(counting.enough(5));
  CHECK(counting.verdict() == "pass");
}

TEST_CASE("suspension: trips at one threshold, resumes at another, and only after holding") {
  using namespace std::chrono_literals;
  sequences::Suspension supply;
  supply.quantity = "supply_bar";
  supply.below = true;
  supply.trip = 6.0;
  supply.resume = 6.5;
  supply.hold_s = 10.0;
  SuspensionWatch watch;
  watch.follow({supply});
  CHECK_FALSE(watch.tripped({{"supply_bar", 6.0}}));
  CHECK_FALSE(watch.tripped({{"temperature_c", 1.0}}));
  CHECK_THAT(watch.tripped({{"supply_bar", 5.9}}).value().what, Catch::Contains("5.90, below 6"));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.4}}, 0s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.5}}, 5s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.4}}, 14s));  // fluttered
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.6}}, 16s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.6}}, 25s));
  CHECK(watch.may_resume({{"supply_bar", 6.6}}, 26s));
}

TEST_CASE("time spent: parts add up, a stretch counts as one") {
  using namespace std::chrono_literals;
  devices::TurnedClock clock;
  TimeSpent times(clock);
  clock.wait_until(1s);
  (void)times.start(Spent::kDwelling);
  clock.wait_until(4s);
  try {
    const TimeSpent::Stretch stretch(times, Spent::kRedoing);
    (void)times.start(Spent::kSettling);
    clock.wait_until(9s);
    throw std::runtime_error("a stretch may end so, too");
  } catch (const std::runtime_error&) {
  }
  (void)times.start(Spent::kReading);
  clock.wait_until(10s);
  (void)times.start(Spent::kTeardown);
  CHECK(times.seconds(Spent::kSetup) == Approx(1.0));
  CHECK(times.seconds(Spent::kDwelling) == Approx(3.0));
  CHECK(times.seconds(Spent::kRedoing) == Approx(5.0));
  CHECK(times.seconds(Spent::kSettling) == 0.0);
  CHECK(times.total() == Approx(10.0));
  CHECK(times.text() == "redoing 50.0 %, dwelling 30.0 %, setting up 10.0 %, reading 10.0 %");
}
