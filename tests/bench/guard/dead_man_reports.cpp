// How the sequencer evaluates its dead-man's answers. The processes themselves: dead_man_watched_realtime.cpp.
#include "bench/guard/dead_man_process.h"

#include <catch2/catch.hpp>

#include "bench/common/process_time.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

const devices::Nanoseconds kTimeout = seconds(0.4);

std::string lost_id(const DeadManReports& reports) { return reports.lost() ? reports.lost()->id : ""; }

}  // namespace

TEST_CASE("dead-man reports: an answer later than the timeout makes it silent permanently") {
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
  CHECK_THAT(reports.lost()->what, Catch::Contains(" 0.40 s") && Catch::Contains(" 0.4 s"));
  reports.heard("fed");
  CHECK(lost_id(reports) == "TB-DEADMAN-SILENT");
  CHECK_FALSE(reports.fired());
}

TEST_CASE("dead-man reports: blind is reported once, and ends the run at the second report if configured") {
  const bool ends = GENERATE(true, false);
  DeadManReports reports(kTimeout, ends);
  reports.heard("sees");
  CHECK(reports.take_notices().empty());  // it saw before
  reports.heard("blind: nobody answers at 192.168.0.10:502");
  CHECK(lost_id(reports) == "");
  auto news = reports.take_notices();
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "TB-DEADMAN-BLIND");
  CHECK_THAT(news[0].what, Catch::Contains("nobody answers at 192.168.0.10:502"));
  reports.heard("sees");
  reports.heard("sees");
  news = reports.take_notices();
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "");
  reports.heard("busy: for 20 ms");
  news = reports.take_notices();
  REQUIRE(news.size() == 1);
  CHECK((news[0].id == "TB-MODBUS-BUSY" && news[0].what == "for 20 ms"));
  CHECK(lost_id(reports) == "");
  reports.heard("blind: a");  // not in a row with the first
  CHECK(lost_id(reports) == "");
  reports.heard("blind: b");
  CHECK(lost_id(reports) == (ends ? "TB-DEADMAN-BLIND" : ""));
  if (ends) CHECK_THAT(reports.lost()->what, Catch::Contains("b") && Catch::Contains("2 "));
  reports.heard("blind: c");
  CHECK(reports.take_notices().size() == 1);
  reports.ended();
  CHECK(lost_id(reports) == (ends ? "TB-DEADMAN-BLIND" : "TB-DEADMAN-ENDED"));  // the first cause stays
  reports.heard("something else");
  CHECK_FALSE(reports.fired());
}

TEST_CASE("dead-man reports: a dead-man that ends by itself is lost, one that ends after firing is not") {
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
