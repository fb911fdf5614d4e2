// A run's way from its records by hand: which events are told and by what name, surroundings, void branches, seatings.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/history.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

RunHistory history_of_events(std::vector<db::EventRecord> events) {
  StoredRun run;
  run.events = std::move(events);
  return load_history(run);
}

// The kind that one event is told as; empty: it is not.
std::string told_as(const char* kind, const char* detail) {
  const RunHistory history = history_of_events({{7, kind, "", detail}});
  return history.events.empty() ? std::string() : history.events.front().kind;
}

RunHistory seating_check(const char* detail, std::vector<double> data) {
  StoredRun run;
  run.checks = {{1, 0, "seating", "pass", detail, std::move(data)}};
  return load_history(run);
}

}  // namespace

TEST_CASE("a run's events by hand: which are told, as what, and when") {
  for (const char* kind : {"attempt", "branch-broken", "warning", "fault", "prompt", "word"}) {
    INFO(kind);
    CHECK(told_as(kind, "x") == kind);
  }
  CHECK(told_as("state", "running -> paused: asked") == "pause");
  CHECK(told_as("state", "running -> suspended: air") == "suspension");
  CHECK(told_as("state", "paused -> running") == "");
  CHECK(told_as("seating", "left out") == "note");
  for (const char* kind : {"note", "safe", "conditioning"}) CHECK(told_as(kind, "x") == "");
  const RunHistory history = history_of_events({{2'500'000'000, "fault", "TB-X", "no air"},
                                                {1, "time", "", "settling 40 %"},
                                                {3'000'000'000, "prompt", "", "ready?"}});
  REQUIRE(history.events.size() == 2);
  CHECK((history.events[0].time_s == Approx(2.5) && history.events[0].text == "no air"));
  CHECK(history.events[1].time_s == Approx(3.0));
  CHECK(history.time_spent == "settling 40 %");
  CHECK((history.loaded && !history.presses));
}

TEST_CASE("a run's surroundings by hand: lowest, highest and number of readings of each quantity") {
  const RunHistory history = history_of_events({{1, "environment", "temperature_c", "23.0"},
                                                {2, "environment", "supply_bar", "6.5"},
                                                {3, "environment", "temperature_c", "22.5"},
                                                {4, "environment", "temperature_c", "24 C"},
                                                {5, "environment", "temperature_c", "warm"},
                                                {6, "environment", "temperature_c", "inf"},
                                                {7, "environment", "temperature_c", ""}});
  REQUIRE(history.surroundings.size() == 2);
  CHECK((history.surroundings[0].quantity == "temperature_c" && history.surroundings[0].readings == 3));
  CHECK((history.surroundings[0].low == 22.5 && history.surroundings[0].high == 24.0));
  CHECK((history.surroundings[1].quantity == "supply_bar" && history.surroundings[1].readings == 1));
  CHECK((history.surroundings[1].low == 6.5 && history.surroundings[1].high == 6.5));
  CHECK(history.events.empty());
}

TEST_CASE("a run's branches by hand: void ones with sequence, repeat, branch and attempt, those of force press") {
  StoredRun run;
  run.record.sequences = {{0, "up", "", "", 1, 1}, {1, "down", "", "", 1, 1}};
  db::BranchRecord good, broken, lost;
  good.branch = 5;
  broken.branch = 6;
  broken.sequence = 1;
  broken.repeat = 2;
  broken.ordinal = 3;
  broken.attempt = 4;
  broken.is_void = true;
  broken.void_reason = "went back";
  lost = broken;
  lost.branch = 7;
  lost.sequence = 9;
  run.branches = {good, broken, lost};
  db::FrameRecord frame;
  for (const std::int64_t branch : {5, 5, 6, 7, 7}) {
    frame.branch = branch;
    run.frames.push_back(frame);
  }
  run.frames[1].flags = "dwell retried";
  run.frames[2].flags = "dwell";
  RunHistory history = load_history(run);
  REQUIRE(history.voids.size() == 2);
  CHECK((history.voids[0].sequence == "down" && history.voids[0].repeat == 2 && history.voids[0].branch == 3));
  CHECK((history.voids[0].attempt == 4 && history.voids[0].reason == "went back" && history.voids[1].sequence.empty()));
  CHECK((history.frames == 2 && history.void_frames == 3 && history.flagged == 1));
  CHECK(history.flags == std::map<std::string, int>{{"dwell", 1}, {"retried", 1}});
  CHECK_FALSE(history.presses);
  run.branches[0].from_n = 0.0;
  CHECK(load_history(run).presses);
  run.branches[0].from_n.reset();
  run.branches[2].to_n = 0.0;
  CHECK(load_history(run).presses);
  run.branches[2].to_n.reset();
  run.frames[4].wrench.emplace();
  CHECK(load_history(run).presses);
}

TEST_CASE("a run's seating by hand: loaded less unloaded in volts, of the newest check, none of another shape") {
  CHECK(seating_check(R"({"volts_per_count":0.5})", {1, 2, 4, 8}).seating_v == std::vector<double>{1.5, 3.0});
  for (const char* other : {"", "[]", "{}", R"({"volts_per_count":"0.5"})"})
    CHECK(seating_check(other, {1, 2, 4, 8}).seating_v.empty());
  StoredRun run;
  run.checks = {{1, 0, "seating", "pass", R"({"volts_per_count":1})", {1, 2}},
                {1, 1, "seating", "fail", R"({"volts_per_count":1})", {1, 7}},
                {1, 2, "tare", "pass", R"({"volts_per_count":1})", {1, 9}}};
  CHECK(load_history(run).seating_v == std::vector<double>{6.0});
  CHECK(load_history(run).checks.size() == 3);
  run.checks.erase(run.checks.begin(), run.checks.begin() + 2);
  CHECK(load_history(run).seating_v.empty());
}
