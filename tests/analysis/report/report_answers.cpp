// What the report's pages are made of beside the evaluation, against answers worked out on paper: judgements of levels,
// spreads, what happened on a run's way, certificates, lines that changed places, mounts that lie otherwise.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "analysis/report/history.h"
#include "analysis/report/parts.h"
#include "analysis/statistics/sensor/health.h"
#include "analysis/statistics/sensor/seating.h"
#include "analysis/statistics/studies/studies.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::tests;

namespace {

const double kNotKnown = std::numeric_limits<double>::quiet_NaN();

// With the sensor's seating before it.
RunHistory whole_history(const db::RunStore& store, std::int64_t run) {
  const db::RunRecord record = store.run(run);
  RunHistory history = load_history(read_run(store, record));
  CHECK(history.earlier_seating_v.empty());
  add_earlier_seating(history, store, record);
  return history;
}

}  // namespace

TEST_CASE("a level is worse by what compensation widened: the distance, the spread going up, the spread going down") {
  LevelFigures level;
  level.raw_std_up = level.raw_std_down = 0.1;
  level.comp_std_up = level.comp_std_down = 0.1;  // alike is not worse
  CHECK_FALSE(judge_level(level).any());
  level.comp_std_up = 0.11;
  CHECK((judge_level(level).std_up && !judge_level(level).std_down && !judge_level(level).distance));
  level.comp_std_up = 0.09;
  level.comp_std_down = 0.11;
  CHECK((!judge_level(level).std_up && judge_level(level).std_down && judge_level(level).any()));
  level.comp_std_down = 0.09;
  level.made_worse = true;
  CHECK((judge_level(level).distance && judge_level(level).any()));
}

TEST_CASE("deviations and spreads by hand leave out what is not finite") {
  const Deviation off = deviation(std::vector{1.0, 2.0, kNotKnown, 5.0}, std::vector{1.5, 0.5, 3.0, 5.0});
  CHECK(off.mean == Approx((0.5 + 1.5 + 0.0) / 3));
  CHECK(off.maximum == Approx(1.5));
  CHECK(std::isnan(deviation(std::vector{kNotKnown}, std::vector{1.0}).mean));
  const Spread even = spread_of({4.0, 1.0, kNotKnown, 3.0, 10.0});
  CHECK((even.low == 1.0 && even.median == 3.5 && even.high == 10.0 && even.count == 4));
  CHECK(spread_of({4.0, 1.0, 3.0}).median == 3.0);
  CHECK(std::isnan(spread_of({kNotKnown}).high));
}

TEST_CASE("a figure of observable taxels is none where every fitted taxel is flat") {
  LevelFigures level;
  level.comp_distance_observable = 0.02;
  level.flat_taxels = 2;
  CHECK(observable(level, &LevelFigures::comp_distance_observable, 3) == 0.02);
  CHECK(std::isnan(observable(level, &LevelFigures::comp_distance_observable, 2)));
}

TEST_CASE("a run's way is counted by frames that count, that carry a flag, and that lie in void branches") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.append_frame(begun.run, example_frame(begun.branch, 1));
  store.void_branch(begun.branch, "scanner lost");
  db::BranchRecord again = example_branch();
  again.attempt = 1;
  const std::int64_t branch = store.begin_branch(begun.run, again);
  int ordinal = 0;
  for (const char* flags : {"dwell retried", "dwell", ""}) {
    db::FrameRecord frame = example_frame(branch, ordinal++);
    frame.flags = flags;
    store.append_frame(begun.run, frame);
  }
  // Two taxels, unloaded then loaded: 100 to 300 and 50 to 450 counts of 0.1 mV.
  store.append_check(begun.run,
                     {begun.run, 4, "seating", "pass", R"({"volts_per_count":0.0001})", {100, 50, 300, 450}});
  const RunHistory history = whole_history(store, begun.run);
  CHECK(history.frames == 3);
  CHECK(history.flagged == 2);
  CHECK(history.void_frames == 2);
  CHECK(history.flags.at("dwell") == 2);
  CHECK(history.flags.at("retried") == 1);
  REQUIRE(history.seating_v.size() == 2);
  CHECK(history.seating_v[0] == Approx(0.02));
  CHECK(history.seating_v[1] == Approx(0.04));
  CHECK(history.earlier_seating_v.empty());

  // The next run of the sensor is held against this one, an ill-seated one in between against neither.
  const auto next_run = [&](const char* verdict, std::vector<double> data) {
    const std::int64_t run = store.begin_run(example_run());
    store.append_check(run, {run, 4, "seating", verdict, R"({"volts_per_count":0.0001})", std::move(data)});
    return whole_history(store, run);
  };
  CHECK(next_run("fail", {100, 50, 200, 150}).earlier_seating_run == begun.run);
  const RunHistory last = next_run("pass", {100, 50, 400, 250});
  CHECK(last.seating_v[0] == Approx(0.03));
  CHECK(last.earlier_seating_run == begun.run);
  REQUIRE(last.earlier_seating_v.size() == 2);
  CHECK(last.earlier_seating_v[1] == Approx(0.04));
}

TEST_CASE("the mean response of a seating is loaded less unloaded over all taxels, dead ones too") {
  SeatingFrames frames{8.0, {0.1, 0.2, 0.1, 0.0}, {0.5, 0.8, 0.3, 0.0}};
  CHECK(check_seating(2, 2, frames, std::nullopt).mean_response_v == Approx((0.4 + 0.6 + 0.2 + 0.0) / 4));
}
