// The watches of a run at their limits: branch guard, conditioning, surroundings, stuck rows, and the time spent.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "bench/config/config.h"
#include "bench/rig/rig.h"
#include "bench/run/time_estimate.h"
#include "bench/run/watch/watches.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace std::chrono_literals;
using namespace tactbench::bench;
using bench::LostTime;

namespace {

sequences::Suspension rule_of(const std::string& quantity, bool below, double trip, double resume, double hold_s) {
  sequences::Suspension rule;
  rule.quantity = quantity;
  rule.below = below;
  rule.trip = trip;
  rule.resume = resume;
  rule.hold_s = hold_s;
  rule.timeout_s = 77.0;
  return rule;
}

devices::ScanSet scans_with(int rows, int columns, const std::vector<std::uint16_t>& counts) {
  devices::ScanSet scans;
  scans.rows = rows;
  scans.columns = columns;
  scans.scans = static_cast<int>(counts.size()) / (rows * columns);
  scans.counts = counts;
  return scans;
}

}  // namespace

TEST_CASE("branch guard: exactly the tolerance passes in both directions, a break is reported with its values") {
  BranchGuard rising(2.0, 10.0, 0.25);
  CHECK_FALSE(rising.see(5.0));
  CHECK_FALSE(rising.see(4.75));
  const auto back = rising.see(4.5);
  REQUIRE(back);
  for (const char* number : {"5.00", "4.50", "2", "10", "0.25"}) CHECK(back->find(number) != std::string::npos);
  CHECK_FALSE(rising.see(9.0));
  CHECK_FALSE(rising.see(8.75));
  BranchGuard falling(10.0, 2.0, 0.25);
  CHECK_FALSE(falling.see(5.0));
  CHECK_FALSE(falling.see(5.25));
  CHECK_THAT(falling.see(5.5).value(), Catch::Contains("5.00") && Catch::Contains("5.50"));
  CHECK_FALSE(falling.see(4.0));
  CHECK_FALSE(falling.see(1.0));
  BranchGuard level(3.0, 3.0, 0.25);
  CHECK_FALSE(level.see(3.0));
  CHECK_FALSE(level.see(3.25));
  CHECK_FALSE(level.see(3.0));
  CHECK(level.see(2.75));
  BranchGuard other(3.0, 3.0, 0.25);
  CHECK_FALSE(other.see(3.0));
  CHECK(other.see(3.5));
  for (const double none : {std::numeric_limits<double>::infinity(), std::nan("")}) CHECK(level.see(none));
}

TEST_CASE("conditioning: ends after the minimum cycles once the change is below its limit, as share of the loop span") {
  sequences::Conditioning rule;
  rule.cycles = 5;
  rule.least = 3;
  rule.change_percent = 2.0;
  ConditioningWatch watch(rule);
  CHECK(watch.wants_output());
  const auto cycle = [&](int number, std::uint16_t peak, std::uint16_t zero) {
    sequences::Step step;
    step.repeat = number;
    watch.see(step, {peak, static_cast<std::uint16_t>(peak + 20)});
    if (number > 0) CHECK(watch.changes().size() == static_cast<std::size_t>(number - 1));
    watch.see(step, {zero, zero});
  };
  cycle(0, 990, 0);
  CHECK(watch.changes().empty());
  CHECK_FALSE(watch.enough(1));
  cycle(1, 991, 1);  // from 1000 and 0 to 1001 and 1: 1 of 1000
  REQUIRE(watch.changes().size() == 1);
  CHECK(watch.changes()[0] == Approx(0.1));
  CHECK_FALSE(watch.enough(2));
  CHECK(watch.enough(3));
  cycle(2, 1011, 21);  // by 20 of 1000: just the limit
  REQUIRE(watch.changes().size() == 2);
  CHECK(watch.changes()[1] == 2.0);
  CHECK_FALSE(watch.enough(3));
  CHECK(watch.verdict() == "warning");
  const auto detail = nlohmann::json::parse(watch.detail_json());
  CHECK(detail["cycles_at_most"] == 5);
  CHECK(detail["cycles_done"] == 3);
  CHECK(detail["change_limit_percent"] == 2.0);
  CHECK(detail["last_change_percent"] == 2.0);
  cycle(3, 1011, 21);
  CHECK(watch.enough(4));
  CHECK(watch.verdict() == "pass");
  rule.change_percent = 0.0;
  ConditioningWatch counting(rule);
  CHECK_FALSE(counting.wants_output());
  CHECK(counting.verdict() == "pass");
  const auto plain = nlohmann::json::parse(counting.detail_json());
  CHECK_FALSE(plain.contains("cycles_done"));
  CHECK_FALSE(plain.contains("last_change_percent"));
}

TEST_CASE("conditioning: an array without response gives no change, of several steps the largest change counts") {
  sequences::Conditioning rule;
  rule.cycles = 3;
  rule.change_percent = 1.0;
  ConditioningWatch flat(rule);
  sequences::Step step;
  for (int number = 0; number < 3; ++number) {
    step.repeat = number;
    flat.see(step, {500, 500});
    flat.see(step, {500, 500});
  }
  CHECK(flat.changes().empty());
  CHECK_FALSE(flat.enough(2));
  CHECK(flat.verdict() == "warning");
  ConditioningWatch first_counts(rule);
  for (int number = 0; number < 2; ++number) {
    step.repeat = number;
    first_counts.see(step, {static_cast<std::uint16_t>(number == 0 ? 150 : 200)});
    first_counts.see(step, {static_cast<std::uint16_t>(number == 0 ? 90 : 100)});
  }
  REQUIRE(first_counts.changes().size() == 1);
  CHECK(first_counts.changes()[0] == 50.0);  // 50 of 100, not the 10 at zero
}

TEST_CASE("suspension: each rule trips in its direction, not without a reading, and the longest hold time applies") {
  SuspensionWatch watch;
  CHECK(watch.empty());
  watch.follow({rule_of("supply_bar", true, 6.0, 6.5, 10.0), rule_of("temperature_c", false, 30.0, 28.0, 20.0)});
  CHECK_FALSE(watch.empty());
  CHECK_FALSE(watch.tripped({}));
  CHECK_FALSE(watch.tripped({{"supply_bar", 6.0}, {"temperature_c", 30.0}}));
  const auto cold = watch.tripped({{"supply_bar", std::nextafter(6.0, 0.0)}});
  REQUIRE(cold);
  CHECK(cold->timeout_s == 77.0);
  const auto hot = watch.tripped({{"supply_bar", 7.0}, {"temperature_c", 30.25}});
  REQUIRE(hot);
  CHECK_THAT(hot->what, Catch::Contains("temperature_c") && Catch::Contains("30.25") && Catch::Contains("30"));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.5}, {"temperature_c", std::nextafter(28.0, 29.0)}}, 0s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.5}, {"temperature_c", 28.0}}, 5s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.5}, {"temperature_c", 28.0}}, 25s - 1ns));
  CHECK(watch.may_resume({{"supply_bar", 6.5}, {"temperature_c", 28.0}}, 25s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.5}, {"temperature_c", 28.0}}, 26s));  // begins anew
  watch.follow({rule_of("supply_bar", true, 6.0, 6.5, 10.0)});
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.5}}, 5s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.4}}, 14s));  // fluttered
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.6}}, 16s));
  CHECK_FALSE(watch.may_resume({{"supply_bar", 6.6}}, 25s));
  CHECK(watch.may_resume({{"supply_bar", 6.6}}, 26s));
  CHECK(watch.may_resume({}, 100s));
  watch.follow({rule_of("temperature_c", false, 30.0, 28.0, 0.0), rule_of("supply_bar", true, 6.0, 6.5, 0.0)});
  CHECK(watch.may_resume({}, 0s));
}

TEST_CASE("stuck rows: judged from the least load on, a change of one taxel in one scan clears the row") {
  StuckRowWatch watch;
  const std::vector<std::uint16_t> counts = {10, 11, 12, 13, 14, 15, 20, 21, 22, 23, 24, 25};  // 3 x 2, two scans
  CHECK(watch.see(scans_with(3, 2, counts), 5.0, 1.0).rows.empty());
  CHECK(watch.see(scans_with(3, 2, counts), std::nextafter(6.0, 0.0), 1.0).rows.empty());
  auto now = counts;
  now[6 + 3] = 99;  // the second row, in its second scan, in its second column
  const StuckRows stuck = watch.see(scans_with(3, 2, now), 6.0, 1.0);
  CHECK(stuck.rows == std::vector<int>{0, 2});
  CHECK_FALSE(stuck.all);
  const StuckRows again = watch.see(scans_with(3, 2, now), 7.0, 1.0);
  CHECK(again.rows == std::vector<int>{0, 1, 2});
  CHECK(again.all);
  now[0] = now[1] = now[6] = now[7] = 0;  // the first row at the converter's foot: it has nothing to tell any more
  const StuckRows low = watch.see(scans_with(3, 2, now), 7.5, 1.0);
  CHECK(low.rows == std::vector<int>{1, 2});
  CHECK(low.all);
  CHECK(watch.see(scans_with(3, 2, now), 4.0, 1.0).rows == std::vector<int>{1, 2});  // less load also shows it
  now[0] = 1;
  CHECK(watch.see(scans_with(3, 2, now), 9.0, 1.0).rows == std::vector<int>{1, 2});
  CHECK(watch.see(scans_with(3, 2, now), 10.0, 1.0).rows == std::vector<int>{0, 1, 2});
  // Another shape starts again.
  CHECK(watch.see(scans_with(2, 3, now), 20.0, 1.0).rows.empty());
  CHECK(watch.see(scans_with(2, 3, now), 21.0, 1.0).rows == std::vector<int>{0, 1});
  CHECK(watch.see(scans_with(2, 3, {1, 2, 3, 4, 5, 6}), 30.0, 1.0).rows.empty());
  StuckRowWatch limits;
  const std::vector<std::uint16_t> ends = {0, UINT16_MAX, 0, UINT16_MAX};
  CHECK(limits.see(scans_with(2, 2, ends), 0.0, 1.0).rows.empty());
  CHECK_FALSE(limits.see(scans_with(2, 2, ends), 5.0, 1.0).all);
}

TEST_CASE("time spent: parts from 0.001 s on are listed, a nested stretch resumes the activity that it interrupted") {
  devices::ManualClock clock;
  clock.wait_until(3s);
  TimeSpent times(clock);
  CHECK(times.start(Spent::kDwelling) == Spent::kSetup);
  clock.wait_until(3s + 998'000'000ns);
  CHECK(times.start(Spent::kMoving) == Spent::kDwelling);
  clock.wait_until(3s + 999'100'000ns);
  CHECK(times.start(Spent::kReading) == Spent::kMoving);
  clock.wait_until(3s + 1'000'000'000ns);
  (void)times.start(Spent::kWaiting);
  CHECK(times.total() == Approx(1.0));
  CHECK_THAT(times.text(), Catch::Contains(" 99.8 %") && Catch::Contains(" 0.1 %"));
  CHECK(std::ranges::count(times.text(), '%') == 2);
  try {
    const TimeSpent::Stretch stretch(times, Spent::kConditioning);
    CHECK(times.start(Spent::kSettling) == Spent::kConditioning);
    clock.wait_until(5s);
    throw std::runtime_error("a stretch may end so, too");
  } catch (const std::runtime_error&) {
  }
  CHECK(times.seconds(Spent::kConditioning) == Approx(1.0));
  (void)times.start(Spent::kTeardown);
  CHECK(times.seconds(Spent::kSettling) == 0.0);
  CHECK(times.text().find("50.0 %") < times.text().find("49.9 %"));  // the longest first
}

// Lost time of a stored run, frame by frame: which interruptions are before a frame, and how much of the gap they are.

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// Frames and events of one run, told in their order; times in seconds.
class Diary {
 public:
  Diary() {
    store_.add_sensor({"S-1", "type", "", "", "", "", ""});
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    for (int i = 0; i < 2; ++i) run.sequences.push_back({i, "r", "", "", 1, 99});
    run_ = store_.begin_run(run);
    state("prepared -> running: begin", 0.0);
  }
  Diary& frames(std::initializer_list<double> times, int sequence = 0, bool kept = true) {
    db::BranchRecord branch;
    branch.sequence = sequence;
    branch.ordinal = branches_++;
    const std::int64_t number = store_.begin_branch(run_, branch);
    for (const double time : times) {
      db::FrameRecord frame;
      frame.branch = number;
      frame.ordinal = ordinal_++;
      frame.time_ns = static_cast<std::int64_t>(time * 1e9);
      frame.rows = frame.columns = frame.scans = 1;
      frame.counts = {0};
      store_.append_frame(run_, frame);
    }
    if (!kept) store_.void_branch(number, "done again");
    return *this;
  }
  Diary& state(const std::string& detail, double time) { return event("state", detail, time); }
  Diary& pause(double from, double to) {
    state("running -> pausing: asked by Ctrl-C", from - 0.5);
    state("pausing -> paused: asked by Ctrl-C", from);
    return state("paused -> running: resumed", to);
  }
  Diary& path_to_branch(double time) { return event("way-back", "conditioned again", time); }
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::int64_t>> lost() const {
    std::vector<std::pair<std::int64_t, std::int64_t>> told;
    for (const LostTime& one : bench::lost_times(store_, run_, store_.last_position(run_))) {
      told.emplace_back(one.position, one.ns / kSecond);
      CHECK(one.ns % kSecond == 0);
    }
    return told;
  }

 private:
  Diary& event(const std::string& kind, const std::string& detail, double time) {
    store_.append_event(run_, {static_cast<std::int64_t>(time * 1e9), kind, "", detail});
    return *this;
  }
  tests::TemporaryFolder folder_;
  db::RunStore store_ = db::RunStore::open(folder_.path("runs.db"), db::Durability::kNormal);
  std::int64_t run_ = 0;
  int branches_ = 0, ordinal_ = 0;
};

using Lost = std::vector<std::pair<std::int64_t, std::int64_t>>;

}  // namespace

TEST_CASE("lost time: a pause between two frames lasts from the end of work to its continuation") {
  CHECK(Diary().frames({10, 20, 30}).lost().empty());
  CHECK(Diary().frames({10, 20, 30}).pause(31, 91).frames({102, 110}).lost() == Lost{{4, 60}});
  CHECK(Diary().pause(2, 6).frames({10, 20}).lost() == Lost{{1, 4}});
  CHECK(Diary().frames({10, 20}).pause(20, 50).frames({60}).lost() == Lost{{3, 30}});  // from the frame's own time on
  CHECK(Diary().frames({10, 20}).pause(21, 50).lost().empty());                        // nothing came later
  CHECK(Diary().frames({10, 20}).pause(12, 15).lost() == Lost{{2, 3}});
  Diary open;
  open.frames({10}).state("pausing -> paused: x", 12).frames({20});
  CHECK(open.lost().empty());  // it never went on
}

TEST_CASE("lost time: pauses before the same frame add up, pauses before different frames are separate") {
  CHECK(Diary().frames({10}).pause(11, 14).pause(16, 21).frames({30, 40}).lost() == Lost{{2, 8}});
  CHECK(Diary().frames({10}).pause(11, 14).frames({20}).pause(21, 26).frames({30}).lost() == Lost{{2, 3}, {3, 5}});
}

TEST_CASE("lost time: after a return path within a sequence the frame intervals still count, two at most") {
  const auto after = [](std::initializer_list<double> frames) {
    return Diary().frames({10, 20, 30}).pause(31, 91).path_to_branch(92).frames(frames).lost();
  };
  CHECK(after({150, 158, 165}) == Lost{{4, 120 - 7}});
  CHECK(after({150, 158, 167}) == Lost{{4, 120 - 8}});
  CHECK(after({150, 158, 167, 168}) == Lost{{4, 120 - 8}});
  CHECK(after({150, 158}) == Lost{{4, 120 - 8}});
  CHECK(after({150, 450}) == Lost{{4, 0}});  // no less than nothing
  CHECK(after({150}) == Lost{{4, 61}});      // no pace: from the frame before until it goes on
  // A way back of before the pause is none of it.
  CHECK(Diary().frames({10, 20}).path_to_branch(25).pause(31, 91).frames({150, 158}).lost() == Lost{{3, 60}});
  // One that begins after the frame neither.
  CHECK(Diary().frames({10, 20}).pause(31, 91).frames({150}).path_to_branch(155).frames({160}).lost() == Lost{{3, 60}});
  // The first of two counts.
  CHECK(Diary()
            .frames({10, 20, 30})
            .pause(31, 91)
            .path_to_branch(92)
            .frames({150, 158, 165})
            .path_to_branch(170)
            .lost() == Lost{{4, 113}});
}

TEST_CASE("lost time: a return path into another sequence is not lost, work begun before the pause is") {
  CHECK(Diary().frames({10, 20}).pause(31, 91).path_to_branch(92).frames({150, 158}, 1).lost() == Lost{{3, 71}});
  CHECK(Diary().frames({10, 20}).pause(31, 91).frames({150, 158}, 1).lost() == Lost{{3, 60}});
  // The pace ends where the sequence does.
  CHECK(Diary().frames({10, 20}).pause(31, 91).path_to_branch(92).frames({150}).frames({158}, 1).lost() ==
        Lost{{3, 71}});
}

TEST_CASE("lost time: in a stopped and resumed run it starts at the last valid frame") {
  const auto resumed = [](const std::string& between) {
    Diary diary;
    diary.frames({10, 20}).frames({25, 28}, 0, false).state("running -> stopping: " + between, 30);
    diary.state("stopping -> ended: " + between, 31).state("ended -> prepared: resumed", 100);
    return diary.state("prepared -> running: again", 110).frames({140, 150}).lost();
  };
  CHECK(resumed("stopped") == Lost{{5, 90}});
  // Void frames are none, on either side.
  Diary both;
  both.frames({10, 20}).pause(31, 91).frames({95, 99}, 0, false).path_to_branch(101).frames({150, 158});
  CHECK(both.lost() == Lost{{5, 130 - 8}});
  Diary suspended;
  suspended.frames({10}).state("running -> suspended: supply", 15).state("suspended -> running: back", 40).frames({50});
  CHECK(suspended.lost() == Lost{{2, 25}});
  Diary odd;
  odd.frames({10}).state("no change of state", 12).state("running -> paused", 13).state("paused -> running", 17);
  CHECK(odd.frames({20}).lost() == Lost{{2, 4}});
}
