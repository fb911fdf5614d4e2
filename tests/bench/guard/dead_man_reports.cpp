// What the sequencer makes of its dead-man's answers, and what its guard does about it. The processes themselves:
// dead_man_watched_realtime.cpp.
#include "bench/guard/dead_man_reports.h"

#include <catch2/catch.hpp>

#include "bench/common/process_time.h"
#include "bench/guard/guard.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

const devices::Nanoseconds kTimeout = seconds(0.4);

std::string lost_id(const DeadManReports& reports) { return reports.lost() ? reports.lost()->id : ""; }

// At watch until it is told otherwise.
class TalkingWatcher final : public Watcher {
 public:
  void feed() override {}
  [[nodiscard]] bool fired() override { return reports.fired(); }
  [[nodiscard]] std::optional<WatcherLost> lost() override { return reports.lost(); }
  [[nodiscard]] bool wait_ended(devices::Nanoseconds) override { return false; }
  DeadManReports reports{kTimeout, true};
};

}  // namespace

TEST_CASE("dead-man's answers: an answer overdue beyond its time makes it silent permanently") {
  DeadManReports reports(kTimeout, true);
  reports.judge(seconds(9.0));  // nothing was asked
  reports.asked(seconds(10.0));
  reports.asked(seconds(10.2));  // the oldest counts
  reports.judge(seconds(10.4));
  CHECK(lost_id(reports) == "");
  reports.heard("fed");
  reports.judge(seconds(20.0));
  CHECK(lost_id(reports) == "");
  reports.asked(seconds(30.0));
  reports.excuse();
  reports.judge(seconds(31.0));
  CHECK(lost_id(reports) == "");
  reports.asked(seconds(40.0));
  reports.judge(seconds(40.4));
  CHECK(lost_id(reports) == "");
  reports.judge(seconds(40.4) + devices::Nanoseconds(1));
  REQUIRE(lost_id(reports) == "TB-DEADMAN-SILENT");
  CHECK_THAT(reports.lost()->what, Catch::Contains("0.40 s") && Catch::Contains("0.4 s"));
  reports.heard("fed");
  CHECK(lost_id(reports) == "TB-DEADMAN-SILENT");
  CHECK_FALSE(reports.fired());
}

TEST_CASE("dead-man's answers: blind is reported once, and ends the run at the second reading if so configured") {
  const bool ends = GENERATE(true, false);
  DeadManReports reports(kTimeout, ends);
  reports.heard("sees");
  CHECK(reports.take_news().empty());  // it saw before
  reports.heard("blind: nobody answers at 192.168.0.10:502");
  CHECK(lost_id(reports) == "");
  auto news = reports.take_news();
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "TB-DEADMAN-BLIND");
  CHECK_THAT(news[0].what, Catch::Contains("nobody answers at 192.168.0.10:502"));
  reports.heard("sees");
  reports.heard("sees");
  news = reports.take_news();
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "");
  reports.heard("blind: a");  // not in a row with the first
  CHECK(lost_id(reports) == "");
  reports.heard("blind: b");
  CHECK(lost_id(reports) == (ends ? "TB-DEADMAN-BLIND" : ""));
  if (ends) CHECK_THAT(reports.lost()->what, Catch::Contains("b") && Catch::Contains("2 "));
  reports.heard("blind: c");
  CHECK(reports.take_news().size() == 1);
  reports.ended();
  CHECK(lost_id(reports) == (ends ? "TB-DEADMAN-BLIND" : "TB-DEADMAN-ENDED"));  // the first cause stays
  reports.heard("something else");
  CHECK_FALSE(reports.fired());
}

TEST_CASE("dead-man's answers: one that ends by itself is lost, one that ends after firing is not") {
  DeadManReports gone(kTimeout, true), fired(kTimeout, true);
  gone.ended();
  CHECK(lost_id(gone) == "TB-DEADMAN-ENDED");
  fired.heard("fired");
  fired.ended();
  fired.asked(seconds(1.0));
  fired.judge(seconds(9.0));
  CHECK(fired.fired());
  CHECK(lost_id(fired) == "");
}

TEST_CASE("guard: without a working dead-man no load is allowed, and the stage may still retract") {
  devices::TurnedClock clock;
  GuardLimits limits;
  limits.axes.fill({0.0, 50.0, 8.0});
  Guard guard(limits, clock);
  std::vector<Trip> stored;
  guard.set_trip_sink([&](const Trip& trip) { stored.push_back(trip); });
  TalkingWatcher watcher;
  guard.set_watcher(&watcher);
  guard.arm();
  guard.source_armed();
  guard.note_feedback(devices::Psi(0.0), clock.now());
  guard.note_reference(devices::Psi(0.0), clock.now());
  guard.check_pressure(devices::Psi(2.0));
  guard.set_pressure(devices::Psi(2.0));
  watcher.reports.ended();
  const auto fault = devices::fault_of([&] { guard.check_pressure(devices::Psi(1.0)); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-DEADMAN-ENDED");
  REQUIRE(guard.tripped());
  CHECK(guard.tripped()->id == "TB-DEADMAN-ENDED");
  CHECK(stored.size() == 1);
  const Guard::ReadAxis read = [](devices::Axis) { return devices::AxisState{}; };
  CHECK_NOTHROW(guard.check_home(devices::Axis::kZ, read));
  CHECK(guard.line_is_ours());  // it does not work on the line: nobody waits for it
}
