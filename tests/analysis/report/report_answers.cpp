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

TEST_CASE("a certificate's standard uncertainty is its U over its own coverage factor, linear between its readings") {
  db::RunRecord run;
  run.devices = {{"pressure reference", "P", "2", "", "simulated",
                  R"({"correction":{"reading_psi":[0,60],"correction_psi":[0,0],)"
                  R"("expanded_uncertainty_psi":[0.06,0.18],"coverage_factor":3}})"}};
  const ReferenceUncertainty reference = reference_uncertainty(run);
  CHECK(reference.coverage_factor == 3.0);
  CHECK(reference.certificate_u(0.0) == Approx(0.02));
  CHECK(reference.certificate_u(15.0) == Approx(0.03));  // a quarter of the way from 0.02 to 0.06
  CHECK(reference.certificate_u(90.0) == Approx(0.06));
  CHECK(reference.largest_certificate_u() == Approx(0.06));
}

TEST_CASE("swapped rows are reported with the lower correlation of either reading of the frame, by hand") {
  // Eight taxels a row. a, b, c are sign patterns that are orthogonal to each other and to a constant. The rows were a
  // and a + b; now they are a + b and a + c / 2. Exchanged they correlate by 1 and 1 / sqrt(1.25), as they are by
  // 1 / sqrt 2 and 1 / sqrt(2 x 1.25).
  const double a[] = {1, 1, 1, 1, -1, -1, -1, -1}, b[] = {1, 1, -1, -1, 1, 1, -1, -1},
               c[] = {1, -1, 1, -1, 1, -1, 1, -1};
  std::vector<double> before(16), now(16);
  for (std::size_t i = 0; i < 8; ++i) {
    before[i] = 5 + a[i];
    before[8 + i] = now[i] = 5 + a[i] + b[i];
    now[8 + i] = 5 + a[i] + 0.5 * c[i];
  }
  const std::vector<SwappedLines> swaps = swapped_lines(2, 8, now, before);
  REQUIRE(swaps.size() == 1);
  CHECK((swaps[0].rows && swaps[0].first == 0 && swaps[0].second == 1));
  CHECK(swaps[0].exchanged == Approx(1.0 / std::sqrt(1.25)));
  CHECK(swaps[0].as_is == Approx(1.0 / std::sqrt(2.5)));
}

TEST_CASE("the mean response of a seating is loaded less unloaded over all taxels, dead ones too") {
  SeatingFrames frames{8.0, {0.1, 0.2, 0.1, 0.0}, {0.5, 0.8, 0.3, 0.0}};
  CHECK(check_seating(2, 2, frames, std::nullopt).mean_response_v == Approx((0.4 + 0.6 + 0.2 + 0.0) / 4));
}

TEST_CASE("turned maps by hand: what a half turn separates, and what neither map explains") {
  // Two taxels, a half turn. As made: sensor +1 and -1, chamber +2 and -2 at its two places, so that the taxels read
  // 3, -3 upright (twice) and -1, 1 turned.
  const std::vector<std::vector<int>> places{{0, 1}, {1, 0}, {0, 1}};
  const std::vector<std::vector<double>> exact{{3, -3}, {-1, 1}, {3, -3}};
  const TurnedMaps maps = separate_maps(exact, places);
  CHECK(maps.sensor[0] == Approx(1.0));
  CHECK(maps.sensor[1] == Approx(-1.0));
  CHECK(maps.chamber[0] == Approx(2.0));
  CHECK(maps.chamber[1] == Approx(-2.0));
  CHECK(maps.undetermined == 1);
  // Six equations, two taxels and two places of which one constant is free: three degrees of freedom.
  CHECK(maps.degrees == 3.0);
  CHECK(maps.residual == Approx(0.0).margin(1e-12));
  // One taxel's two upright readings 0.3 above and below: no map explains it, 0.18 over three degrees.
  const TurnedMaps rough = separate_maps(std::vector<std::vector<double>>{{3.3, -3}, {-1, 1}, {2.7, -3}}, places);
  CHECK(rough.residual == Approx(std::sqrt(0.18 / 3)));
}
