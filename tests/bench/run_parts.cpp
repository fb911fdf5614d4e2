// The small parts of a run without a rig: states, words, the branch guard, conditioning by criterion, suspension.
#include <catch2/catch.hpp>
#include <csignal>
#include <map>

#include "bench/run/branch_guard.h"
#include "bench/run/conditioning.h"
#include "bench/run/control.h"
#include "bench/run/suspension.h"
#include "bench/run/time_spent.h"

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

TEST_CASE("words: the strongest wins, resume takes a pause back, an ended run takes none") {
  const StopRequest signals;
  Control control;
  RunStatus status;
  status.run = 7;
  status.state = RunState::kRunning;
  control.publish(status);
  CHECK_FALSE(control.ask(Word::kResume, "t").taken);
  CHECK(control.ask(Word::kPause, "t").taken);
  CHECK(control.pause_wanted());
  CHECK_NOTHROW(control.look(signals));
  CHECK(control.ask(Word::kResume, "t").taken);
  CHECK_FALSE(control.pause_wanted());
  CHECK(control.take_resume());
  CHECK_FALSE(control.take_resume());
  bool panicked = false;
  control.on_panic([&] { panicked = true; });
  CHECK(control.ask(Word::kStop, "t").taken);
  CHECK_FALSE(panicked);
  CHECK(control.ask(Word::kPanic, "who").taken);
  CHECK(panicked);
  CHECK(control.ask(Word::kAbort, "t").taken);
  try {
    control.look(signals);
    FAIL("nobody left");
  } catch (const Leave& leave) {
    CHECK(leave.word == Word::kPanic);
    CHECK(leave.signal == 0);
  }
  status.state = RunState::kStopping;
  control.publish(status);
  CHECK_FALSE(control.ask(Word::kStop, "t").taken);
}

TEST_CASE("Ctrl-C once asks to pause, twice to stop") {
  const StopRequest signals;
  Control control;
  std::raise(SIGINT);
  CHECK_NOTHROW(control.look(signals));
  CHECK(control.pause_wanted());
  std::raise(SIGINT);
  try {
    control.look(signals);
    FAIL("nobody left");
  } catch (const Leave& leave) {
    CHECK(leave.word == Word::kStop);
    CHECK(leave.signal == SIGINT);
  }
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
