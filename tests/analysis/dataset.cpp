// From a run's record to branches and loops: scales, noise, times, temperatures, records that do not fit; branches,
// averages, external loops; ranges that do not begin at 0.

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "analysis/compensate/document.h"
#include "analysis/dataset.h"
#include "analysis/identify/elam/elam.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/linearise.h"
#include "analysis/judgement/judgement.h"
#include "analysis/loop.h"
#include "analysis/scanner_scale.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;
using namespace tactbench;

namespace {

db::FrameRecord frame_of_two(std::int64_t branch, int ordinal, std::vector<std::uint16_t> counts) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.ordinal = ordinal;
  frame.setpoint_psi = 10.0 * ordinal;
  frame.reference_psi = 10.0 * ordinal + 0.5;
  frame.time_ns = 1'500'000'000 + 1'000'000'000LL * ordinal;
  frame.since_command_ns = 250'000'000;
  frame.rows = 1;
  frame.columns = 2;
  frame.scans = static_cast<int>(counts.size() / 2);
  frame.counts = std::move(counts);
  return frame;
}

// One sequence of two frames per repeat, two repeats; a scan has two taxels.
StoredRun record_of_four() {
  StoredRun run;
  run.record.run = 6;
  run.record.sequences = {{0, "s", "", "", 2, 2}};
  run.record.devices = {{"force sensor", "", "", "", "", "{}"},
                        {"tactile scanner", "", "", "", "", R"({"volts_per_count":0.001})"}};
  for (int repeat = 0; repeat < 2; ++repeat) {
    db::BranchRecord branch;
    branch.branch = 11 + repeat;
    branch.repeat = repeat;
    run.branches.push_back(branch);
  }
  run.frames = {frame_of_two(11, 0, {100, 7, 104, 7, 108, 7}), frame_of_two(11, 1, {200, 7, 200, 7, 200, 7}),
                frame_of_two(12, 1, {300, 7, 300, 7, 300, 7}), frame_of_two(12, 0, {150, 7, 150, 7, 150, 7})};
  return run;
}

std::string refusal_of(const StoredRun& run) {
  return id_of_refusal([&] { return load_dataset(run); });
}

}  // namespace

TEST_CASE("load_dataset: times, references, mean volts of the scans, noise and step order match hand-computed values") {
  const Dataset data = load_dataset(record_of_four());
  CHECK((data.run == 6 && data.rows == 1 && data.columns == 2 && data.scans == 3));
  REQUIRE(data.sequences.size() == 1);
  REQUIRE(data.sequences[0].repeats.size() == 2);
  const Repeat &first = data.sequences[0].repeats[0], &second = data.sequences[0].repeats[1];
  CHECK((first.steps[1].setpoint_psi == 10.0 && first.steps[1].reference_psi == 10.5));
  CHECK(first.steps[1].time_s == Approx(2.5));
  CHECK(first.steps[1].held_s == Approx(0.25));
  CHECK(first.volts[0] == Approx(0.104));
  CHECK(first.volts[2] == Approx(0.2));
  CHECK(second.volts[0] == Approx(0.15));  // stored last, and the first step
  CHECK(second.volts[2] == Approx(0.3));
  // One frame of four has squares of 16 + 16 about its mean: 32 over 4 x 2 degrees of freedom, of a mean of three.
  CHECK(data.noise_v[0] == Approx(0.001 * std::sqrt(4.0 / 3.0)));
  CHECK(data.noise_v[1] == Approx(0.001 * std::sqrt(1.0 / 12.0 / 3.0)));  // the converter's own rounding
  CHECK((!data.at_limit[0] && !data.at_limit[1]));
}

TEST_CASE("load_dataset: unequal scan counts are weighted in the noise, single scans give no noise") {
  StoredRun run = record_of_four();
  run.frames[3] = frame_of_two(12, 0, {150, 65535});
  const Dataset data = load_dataset(run);
  // 3 + 3 + 3 + 1 scans of four frames: 2.5 in the mean, six degrees of freedom.
  CHECK(data.noise_v[0] == Approx(0.001 * std::sqrt(32.0 / 6.0 / 2.5)));
  CHECK((!data.at_limit[0] && !data.at_limit[1]));  // in one frame alone
  for (int i = 0; i < 4; ++i) run.frames[static_cast<std::size_t>(i)] = frame_of_two(11 + i / 2, i % 2, {5, 65534});
  const Dataset single = load_dataset(run);
  CHECK(single.noise_v == std::vector<double>{0.0, 0.0});
  CHECK(single.scans == 1);
  CHECK_FALSE(single.at_limit[1]);
}

TEST_CASE("load_dataset: incomplete repeats are left out, and a run without a complete repeat is refused") {
  StoredRun run = record_of_four();
  run.frames.erase(run.frames.begin());
  CHECK(load_dataset(run).sequences[0].repeats.size() == 1);
  CHECK(load_dataset(run).sequences[0].repeats[0].volts[0] == Approx(0.15));
  run.frames.pop_back();
  run.record.sequences.push_back({1, "t", "", "", 1, 5});
  CHECK(refusal_of(run) == "TB-ANALYSIS-EMPTY");
  run.record.sequences.clear();
  run.frames.clear();
  CHECK(refusal_of(run) == "TB-ANALYSIS-EMPTY");
}

TEST_CASE("load_dataset: frames that do not fit the run are refused, frames of void branches are not checked") {
  const auto with = [](auto change) {
    StoredRun run = record_of_four();
    change(run);
    return refusal_of(run);
  };
  CHECK(with([](StoredRun&) {}).empty());
  const double none = std::numeric_limits<double>::infinity();
  const std::vector<std::function<void(StoredRun&)>> changes = {
      [](StoredRun& run) { run.frames[1].rows = 2; },
      [](StoredRun& run) { run.frames[1].columns = 1; },
      [](StoredRun& run) { run.frames[1].scans = 0; },
      [](StoredRun& run) { run.frames[1].counts.pop_back(); },
      [](StoredRun& run) { run.frames[1].ordinal = 2; },
      [](StoredRun& run) { run.frames[1].ordinal = -1; },
      [=](StoredRun& run) { run.frames[1].setpoint_psi = none; },
      [=](StoredRun& run) { run.frames[1].reference_psi = none; },
      [](StoredRun& run) { run.frames[1].branch = 99; },
      [](StoredRun& run) { run.branches[1].sequence = 5; },
      [](StoredRun& run) { run.frames[1].ordinal = 0; },  // stored twice
      [](StoredRun& run) { run.record.sequences[0].frames_per_repeat = 10'000'001; },
      [](StoredRun& run) { run.record.sequences[0].frames_per_repeat = -1; }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    CAPTURE(i);
    CHECK(with(changes[i]) == "TB-ANALYSIS-FRAME");
  }
  // A void branch of unknown frames is not checked.
  CHECK(with([](StoredRun& run) {
          run.branches[1].is_void = true;
          run.frames[2].rows = 9;
        }).empty());
}

TEST_CASE("volts per count: comes from the tactile scanner, and is refused unless it is a positive number") {
  const auto scale = [](const std::string& role, const std::string& json) {
    db::RunRecord run;
    run.devices = {{"tactile array", "", "", "", "", R"({"volts_per_count":9})"}, {role, "", "", "", "", json}};
    return volts_per_count(run);
  };
  CHECK(scale("tactile scanner", R"({"volts_per_count":0.25})") == 0.25);
  for (const auto& [role, json] : {std::pair("tactile scanner", R"({"volts_per_count":0})"),
                                   {"tactile scanner", R"({"volts_per_count":-1})"},
                                   {"tactile scanner", R"({"volts_per_count":"1"})"},
                                   {"tactile scanner", "{}"},
                                   {"tactile scanner", "[]"},
                                   {"tactile scanner", "no json"},
                                   {"scanner", R"({"volts_per_count":1})"}}) {
    CAPTURE(role, json);
    CHECK(id_of_refusal([&, role = role, json = json] { return scale(role, json); }) == "TB-ANALYSIS-NO-CALIBRATION");
  }
}

TEST_CASE("load_dataset: temperatures come from environment events only, values that are not finite are refused") {
  StoredRun run = record_of_four();
  const auto event = [](const char* kind, const char* id, const char* detail) {
    db::EventRecord record;
    record.kind = kind;
    record.id = id;
    record.detail = detail;
    return record;
  };
  run.events = {event("environment", "temperature_c", "23.5"), event("environment", "humidity", "40"),
                event("note", "temperature_c", "9"), event("environment", "temperature_c", "-1e1")};
  CHECK(load_dataset(run).temperatures_c == std::vector<double>{23.5, -10.0});
  for (const char* odd : {"", "warm", "inf", "nan"}) {
    run.events = {event("environment", "temperature_c", odd)};
    CHECK(refusal_of(run) == "TB-ANALYSIS-FRAME");
  }
}

TEST_CASE("elapsed time: counts from the command, and a gap beyond 5 s of settling counts as conditioning") {
  struct Row {
    double time_s, held_s, before_s, worked_s, step_s;
  };
  const Row rows[] = {{9, 2, 7, 0, 2},      {10, 2, 7, 0, 3},  // one second of settling in addition to the command
                      {14, 2, 7, 0, 7},                        // five
                      {14.5, 2, 7, 5.5, 2},                    // more than that was conditioning
                      {9, 30, 7, 0, 2},                        // held for longer than since the sample before
                      {6, 2, 7, 0, 0},                         // the clock went back
                      {1, 2, -1, 0, 1},                        // the first sample of a run: what passed since its start
                      {6, 2, -1, 0, 2},     {30, 2, -1, 28, 2}, {30, 2, 0, 28, 2}, {4, 2, 0, 0, 4}};
  for (const Row& row : rows) {
    CAPTURE(row.time_s, row.held_s, row.before_s);
    const TimePassed found = time_passed({0, 0, row.time_s, row.held_s}, row.before_s);
    CHECK((found.worked_s == row.worked_s && found.step_s == row.step_s));
  }
}

// Branches, local slopes and full sweeps at their limits, by hand.

namespace {

TaxelTable table_along(const std::vector<double>& x, const std::vector<double>& y, double turn = 0.0) {
  return {x, y, branches_along(x, turn)};
}

// Outputs 0, 1, 8 at set-points 0, 2, 4 and these references; moved to the set-points.
std::vector<double> moved_from(const std::vector<double>& references) {
  SequenceData sequence{"s", {{}}};
  for (std::size_t i = 0; i < 3; ++i)
    sequence.repeats[0].steps.push_back({2.0 * static_cast<double>(i), references[i]});
  sequence.repeats[0].volts = {0.0, 1.0, 8.0};
  return average_repeats(sequence, 1).values;
}

std::string id_of_repeats(const SequenceData& sequence, int first, int last) {
  return id_of_refusal([&] { return average_repeats(sequence, 1, {.first_repeat = first, .last_repeat = last}); });
}

double left_out_of(std::size_t outliers, double turn) {
  // A hundred samples: a loop over 0 to 10, and single inputs beyond both ends.
  std::vector<double> x, y;
  for (std::size_t i = 0; i < 100 - 2 * outliers; ++i) {
    const std::size_t half = (100 - 2 * outliers) / 2;
    x.push_back(i < half ? 10.0 * static_cast<double>(i) / static_cast<double>(half - 1)
                         : 10.0 * static_cast<double>(99 - 2 * outliers - i) / static_cast<double>(half - 1));
    y.push_back(x.back());
  }
  TaxelTable table = table_along(x, y, turn);
  for (std::size_t k = 0; k < outliers; ++k)
    for (const double far : {-5.0, 15.0}) {
      table.pressure_psi.push_back(far);
      table.values.push_back(far);
    }
  return external_loop(std::vector{table}, 1, turn).left_out;
}

// Of each branch its ends and U or D.
std::string branches_in(const std::vector<double>& x, double turn = 0.0) {
  std::string found;
  for (const Branch& branch : branches_along(x, turn))
    found += std::to_string(branch.first) + "-" + std::to_string(branch.last) + (branch.ascending ? "U " : "D ");
  return found;
}

}  // namespace

TEST_CASE("branches: share turning points, hold their direction, turn only beyond the tolerance") {
  struct Row {
    std::vector<double> x;
    double turn;
    const char* branches;
  };
  const Row rows[] = {{{0, 2, 4, 2, 0, 2}, 0.0, "0-2U 2-4D 4-5U "},
                      {{0, 0, 2, 4, 4, 4, 2, 2, 0}, 0.0, "0-5U 5-8D "},
                      {{3, 3, 3}, 0.0, ""},
                      {{3}, 0.0, ""},
                      {{0, 1, 0.5, 1.5}, 0.5, "0-3U "},
                      {{0, 1, 0.4375, 1.5}, 0.5, "0-1U 1-2D 2-3U "},
                      {{2, 1, 1.5, 0}, 0.5, "0-3D "},
                      {{2, 1, 1.5625, 0}, 0.5, "0-1D 1-2U 2-3D "},
                      {{0, 0.5, 0, 0.5}, 0.5, ""},
                      {{0, 0.5625}, 0.5, "0-1U "},
                      {{0, -0.5625}, 0.5, "0-1D "},
                      {{}, 0.5, ""},
                      {{1, 1.5, 0.25, 0.75, 1}, 0.5, "0-2D 2-4U "}};
  for (const Row& row : rows) {
    CAPTURE(row.x, row.turn);
    CHECK(branches_in(row.x, row.turn) == row.branches);
  }
}

TEST_CASE("average_repeats: outputs move to the set-point along the slope of their branch") {
  // Up along v = p, down along v = 2 p - 4; the reference is off by 0.1 up and -0.2 down.
  SequenceData sequence{"s", {}};
  Repeat repeat;
  for (const double level : {0.0, 2.0, 4.0}) {
    repeat.steps.push_back({level, level + 0.1});
    repeat.volts.push_back(level + 0.1);
  }
  for (const double level : {2.0, 0.0}) {
    repeat.steps.push_back({level, level - 0.2});
    repeat.volts.push_back(2.0 * (level - 0.2) - 4.0);
  }
  sequence.repeats = {repeat, repeat};
  const TaxelTable moved = average_repeats(sequence, 1);
  CHECK(moved.values[1] == Approx(2.0));
  CHECK(moved.values[2] == Approx(4.0));  // the turning sample belongs to the rise that reached it
  CHECK(moved.values[4] == Approx(-4.0));
  CHECK(moved.pressure_psi == std::vector<double>{0, 2, 4, 2, 0});
  const TaxelTable left = average_repeats(sequence, 1, {.move_to_setpoint = false});
  CHECK(left.values[1] == Approx(2.1));
  CHECK(left.pressure_psi[3] == Approx(1.8));
}

TEST_CASE("local slope: uses the commanded step if the reference moved by less than a tenth of it") {
  // Moved by 4: 2 a psi. By half a psi: 16. By less than 0.4, back, or not at all: 2 of the commanded 4.
  CHECK(moved_from({0.0, 1.5, 4.0})[1] == Approx(1.0 + 2.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 2.25})[1] == Approx(1.0 + 16.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 2.125})[1] == Approx(1.0 + 2.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 1.75})[1] == Approx(1.0 + 2.0 * 0.5));
  CHECK(moved_from({1.75, 1.5, 0.0})[1] == Approx(1.0 + 2.0 * 0.5));
  // At the ends of a branch to one side: 0.5 a psi at the first, 3.5 at the last.
  CHECK(moved_from({-0.5, 1.5, 4.0})[0] == Approx(0.0 + 0.5 * 0.5));
  CHECK(moved_from({0.0, 1.5, 3.5})[2] == Approx(8.0 + 3.5 * 0.5));
  // A pressure that is held has no slope there.
  SequenceData held{"s", {{}}};
  for (const auto& [psi, reference] : {std::pair{0.0, 0.0}, {2.0, 2.0}, {2.0, 2.5}, {2.0, 2.5}})
    held.repeats[0].steps.push_back({psi, reference});
  held.repeats[0].volts = {0.0, 1.0, 2.0, 3.0};
  CHECK(average_repeats(held, 1).values[3] == 3.0);
}

TEST_CASE("average_repeats: averages the requested repeats, and refuses a range with a missing repeat") {
  SequenceData sequence{"s", {}};
  for (const double v : {1.0, 2.0, 6.0, 20.0}) sequence.repeats.push_back({{{0, 0}, {2, 2}, {0, 0}}, {v, v, v}});
  const auto mean = [&](int first, int last) {
    return average_repeats(sequence, 1, {.first_repeat = first, .last_repeat = last}).values[1];
  };
  CHECK(mean(0, 0) == 1.0);
  CHECK(mean(0, 1) == Approx(1.5));
  CHECK(mean(1, 2) == Approx(4.0));
  CHECK(mean(1, -1) == Approx(28.0 / 3.0));
  CHECK(mean(3, 3) == 20.0);
  CHECK(id_of_repeats(sequence, 0, 3).empty());
  for (const auto& [first, last] : {std::pair(0, 4), {2, 1}, {-1, 1}})
    CHECK(id_of_repeats(sequence, first, last) == "TB-ANALYSIS-REPEATS");
  // Measured pressures are averaged as well.
  sequence.repeats[0].steps[1].reference_psi = 1.0;
  sequence.repeats[1].steps[1].reference_psi = 1.5;
  const TaxelTable plain = average_repeats(sequence, 1, {.move_to_setpoint = false, .last_repeat = 1});
  CHECK(plain.pressure_psi[1] == Approx(1.25));
  CHECK(plain.values[1] == Approx(1.5));
  // Repeats that were not asked for may have other set-points.
  sequence.repeats[3].steps[1].setpoint_psi = 3.0;
  CHECK(id_of_repeats(sequence, 0, 2).empty());
  CHECK(id_of_repeats(sequence, 0, 3) == "TB-ANALYSIS-REPEATS");
}

TEST_CASE("external loop: sweeps within 1 % of both ends are full, and are extrapolated to the ends of the grid") {
  // Up to 100 and down; up to 99 and down to 1, which are full; up to 98 and down to 0, which are not.
  const TaxelTable table = table_along({0, 100, 0, 99, 1, 98, 0}, {0, 10, 0, 20, 0, 1000, 0});
  const ExternalLoop loop = external_loop(std::vector{table}, 1);
  CHECK(loop.pressure_psi == std::vector<double>{0, 100});
  CHECK(loop.ascending[0] == Approx(0.0).margin(1e-12));
  CHECK(loop.ascending[1] == Approx(0.5 * (10.0 + 20.0 * 100.0 / 99.0)));
  CHECK(loop.descending[0] == Approx(0.5 * (0.0 - 20.0 / 98.0)));
  CHECK(loop.descending[1] == Approx(0.5 * (10.0 + 20.0 * 99.0 / 98.0)));
  CHECK(loop.left_out == 0.0);
  // The finest rise is the grid, without steps that do not advance; of two taxels each has its own.
  TaxelTable two = {{0, 10, 0, 5, 5, 10, 0}, {0, 1, 10, 11, 0, 1, 4, 5, 4, 5, 12, 13, 2, 3}, {}};
  two.branches = branches_along(two.pressure_psi);
  const ExternalLoop both = external_loop(std::vector{two}, 2);
  CHECK(both.pressure_psi == std::vector<double>{0, 5, 10});
  CHECK(both.ascending == std::vector<double>{0, 1, 4.5, 5.5, 11, 12});
  CHECK(both.descending == std::vector<double>{1, 2, 6, 7, 11, 12});
}

TEST_CASE("external loop: up to 2 % of measured samples may lie beyond either end, but no commanded ones") {
  CHECK(left_out_of(0, 0.01) == 0.0);
  CHECK(left_out_of(1, 0.01) == 0.01);
  CHECK(left_out_of(2, 0.01) == 0.02);
  CHECK_THROWS_AS(left_out_of(3, 0.01), AnalysisError);
  CHECK(left_out_of(0, 0.0) == 0.0);
  CHECK_THROWS_AS(left_out_of(1, 0.0), AnalysisError);
  // With a turn of 5 the ends may be as far away.
  CHECK(left_out_of(1, 5.0) == 0.0);
}

TEST_CASE("external loop: a missing full sweep is an error") {
  const std::vector<double> x{0, 10, 20, 10};
  CHECK(id_of_refusal([&] {
          return external_loop(std::vector{table_along(x, {0, 1, 2, 1})}, 1);
        }) == "TB-ANALYSIS-NO-LOOP");
  CHECK_THROWS_AS(external_loop({}, 1), AnalysisError);
}

// Bounds within a range of inputs, where the range does not begin at 0: by hand.

namespace {

constexpr double kBegin = 1000.0;  // of a range of 100

std::vector<double> moved_there(std::vector<double> x) {
  for (double& at : x) at += kBegin;
  return x;
}

Dataset single_path(const std::vector<double>& psi) {
  Repeat repeat;
  for (const double at : psi) {
    repeat.steps.push_back({at, at, 0.0, 1.0});
    repeat.volts.insert(repeat.volts.end(), {at / 20.0, at / 10.0, 9.0});
  }
  return dataset_of({{"s", {repeat}}});
}

PatternCurve line_there() {
  const std::vector<double> x{kBegin, kBegin + 100.0}, y{0.0, 10.0};
  return {x, y, 0.0, 10.0};
}

}  // namespace

TEST_CASE("range not starting at 0: sweeps are full, and repeats return to the lowest level, within 1 % of the range") {
  SensorModel fit = straight_fit();
  fit.pressure_psi = {10.0, 20.0, 60.0};
  const auto zeros = [&](double first, double last) {
    return sweep_errors(single_path({first, 20, last}), fit, 1).repeats_with_zero;
  };
  CHECK(zeros(10.49, 10.49) == 1);
  CHECK(zeros(10.51, 10) == 0);
  CHECK(zeros(10, 10.51) == 0);
  const auto sweeps = [&](double first, double last) {
    try {
      return sweep_estimates(single_path({first, 20, last}), fit, 1).sweeps;
    } catch (const AnalysisError&) {
      return 0;
    }
  };
  CHECK(sweeps(10.49, 59.51) == 1);
  CHECK(sweeps(10.51, 60) == 0);
  CHECK(sweeps(10, 59.49) == 0);
}

TEST_CASE(
    "range not starting at 0: sweeps of the external loop, and outputs at its ends, count within 1 % of the range") {
  const auto counts = [](double bottom, double top) {
    std::vector<TaxelTable> tables;
    for (const auto& [x, y] : {std::pair{std::vector<double>{0, 50, 100, 50, 0}, 0.0},
                               std::pair{std::vector<double>{bottom, 50, top, 50, bottom}, 100.0}}) {
      TaxelTable table{moved_there(x), {0, y, 0, y, 0}, branches_along(x)};
      tables.push_back(table);
    }
    return external_loop(tables, 1).ascending[1] > 1.0;
  };
  CHECK(counts(0.99, 99.01));
  CHECK_FALSE(counts(1.01, 100));
  CHECK_FALSE(counts(0, 98.99));
  TaxelHistories taxel;
  taxel.fit = {History{
      "h", moved_there({0, 0.9, 1.1, 50, 98.9, 99.1, 100}), {1, 3, 50, 60, 70, 20, 24}, {{0, 6, true}}, {}, {}}};
  const FitData ends = fit_data_of(taxel, {});
  CHECK((ends.ascending(kBegin) == 2.0 && ends.ascending(kBegin + 100.0) == 22.0));
}

TEST_CASE("range not starting at 0: turning points, folds and congruency pairs use bounds of 1 % of the range") {
  const ElamModel model{line_there(), line_there(), {}, {}};
  CHECK(turning_point(model, {true, {kBegin + 0.99, 0}, {7, 0}}).x == kBegin);
  CHECK(turning_point(model, {true, {kBegin + 1.01, 0}, {7, 0}}).x == kBegin + 1.01);
  CHECK(turning_point(model, {false, {kBegin + 99.01, 0}, {7, 0}}).x == kBegin + 100.0);
  CHECK(turning_point(model, {false, {kBegin + 98.99, 0}, {7, 0}}).x == kBegin + 98.99);
  FitData data;
  data.ascending = data.descending = line_there();
  const auto folds_from = [&](double first, double second) {
    data.histories = {History{"h", moved_there({first, 100, second, 50}), {}, {{0, 1, true}, {2, 3, false}}, {}, {}},
                      History{"i", moved_there({50, 0}), {}, {{0, 1, false}}, {}, {}}};
    return folds_of(data, 9).size();
  };
  CHECK(folds_from(0.99, 98.99) == 2);
  CHECK(folds_from(0.99, 99.01) == 0);
  CHECK(folds_from(1.01, 99.01) == 2);
  CHECK(folds_from(1.01, 98.99) == 3);
  const auto pairs_from = [&](double first, double last) {
    std::vector<double> x{first};
    for (const double turn : {30.0, 40.0, 50.0}) x.insert(x.end(), {turn, 20, first});
    x.insert(x.end(), {last, 20, 30, 40, 50, 100});
    data.histories = {History{"h", moved_there(x), x, branches_along(x), {}, {}}};
    return find_divider(data).pairs;
  };
  CHECK(pairs_from(0.99, 99.01) == 3);
  CHECK(pairs_from(1.01, 99.01) == 0);
  CHECK(pairs_from(0.99, 98.99) == 0);
}

TEST_CASE("range not starting at 0: residual levels, random paths, inner shares and mid-range starts use the range") {
  ModelTaxel taxel = by_hand::elam_taxel(line_there(), line_there());
  taxel.residual_psi = 1.0;
  const std::vector<double> half{kBegin, kBegin + 50.0, kBegin + 100.0}, y{0.0, 2.0, 10.0};
  taxel.descending = PatternCurve(half, y, 0.0, 10.0);
  const std::vector<double> psi = residual_by_level(taxel.ascending, taxel.descending, taxel.residual_psi);
  CHECK(psi[0] == Approx(1.0));
  CHECK(psi[19] == Approx(1.0));
  CHECK(psi[20] == Approx(2.5));  // a fifth of the rise over half of the range
  CHECK(psi[39] == Approx(0.625));
  const auto random_way = [](double third_top) {
    return judged_trajectory(single_path(moved_there({0, 60, 20, 60, 20, third_top, 20, 40, 20, 40, 0})),
                             single_path({0, 60}))
        .trajectory;
  };
  CHECK(random_way(59.41) == Trajectory::kOther);
  CHECK(random_way(59.39) == Trajectory::kRandomReversals);
  const auto inner = [](double from, double to) {
    Dataset data = single_path(moved_there({0, 60}));
    data.sequences.push_back(single_path(moved_there({from, to})).sequences.front());
    return judged_trajectory(data, data).inner_share;
  };
  CHECK(inner(0.6, 59.41) == 0.0);
  CHECK(inner(0.6, 59.39) == 0.5);
  const auto doubtful = [](double first) {
    std::vector<double> way{first, 0, 100, 20, 80, 30, 70, 40, 60, 50, 100, 0};
    TableSeries series{"a", 0, moved_there(way), way};
    return !histories_of({series}, "t", synthetic::table_options(0.0, 0.0)).warnings.empty();
  };
  CHECK_FALSE(doubtful(0.99));
  CHECK(doubtful(1.01));
  CHECK_FALSE(doubtful(99.01));
  CHECK(doubtful(98.99));
}
