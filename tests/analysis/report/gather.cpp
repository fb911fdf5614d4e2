// Input of a report from a run and from further runs: counted taxels, detectable swaps, refused runs; a run's way from
// its records; which quantities are traceable; how wrong a reading is.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <string>

#include "analysis/report/data/reading_figures.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/gather.h"
#include "analysis/report/run_log.h"
#include "tests/db/store_example.h"

using namespace tactbench::analysis;
using namespace tactbench;

namespace tactbench::tests::gather {

using namespace analysis;

namespace {

// Four frames at 0, 2, 4 and 6 psi of a sequence under pressure alone; each taxel gives 200 V more at each.
std::int64_t store_pressure_run(db::RunStore& store, const db::RunRecord& record,
                                const std::vector<double>& seating = {}, const std::string& verdict = "pass") {
  db::SensorRecord sensor = example_sensor();
  sensor.serial = record.sensor_serial;
  store.add_sensor(sensor);
  const std::int64_t run = store.begin_run(record);
  db::BranchRecord branch = example_branch();
  branch.from_n.reset();
  branch.to_n.reset();
  const std::int64_t number = store.begin_branch(run, branch);
  for (int i = 0; i < 4; ++i) {
    db::FrameRecord frame = example_frame(number, i);
    frame.wrench.reset();
    frame.flags.clear();
    for (std::size_t k = 0; k < frame.counts.size(); ++k)
      frame.counts[k] = static_cast<std::uint16_t>(1000 + 2000 * i + 10 * static_cast<int>(k % 6));
    store.append_frame(run, frame);
  }
  if (!seating.empty()) store.append_check(run, {run, 4, "seating", verdict, R"({"volts_per_count":0.5})", seating});
  return run;
}

// Of six taxels: without load, then under load.
const std::vector<double> kSeating{0, 0, 0, 0, 0, 0, 10, 20, 30, 40, 50, 60};

struct Gathered {
  NewStore store;
  [[nodiscard]] ReportInput of(std::int64_t run, const std::vector<std::int64_t>& further = {}) const {
    Runs runs(store);
    ReportInput input;
    gather_run(input, runs, run, further);
    return input;
  }
  [[nodiscard]] std::string refusal(std::int64_t run, const std::vector<std::int64_t>& further) const {
    try {
      (void)of(run, further);
    } catch (const AnalysisError& error) {
      return error.id();
    }
    return {};
  }
};

}  // namespace

TEST_CASE("gathered run: further runs of another origin or sensor are refused") {
  Gathered gathered;
  db::RunRecord record = example_run();
  const std::int64_t own = store_pressure_run(gathered.store, record),
                     same = store_pressure_run(gathered.store, record);
  record.sensor_serial = "S-2";
  const std::int64_t other = store_pressure_run(gathered.store, record);
  record = example_run();
  record.origin = "hardware";
  const std::int64_t real = store_pressure_run(gathered.store, record);
  CHECK(gathered.refusal(own, {same}).empty());
  CHECK(gathered.of(own, {same}).further.size() == 1);
  CHECK(gathered.of(own, {same}).further[0].run == same);
  CHECK(gathered.refusal(own, {same, other}) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(gathered.refusal(other, {own}) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(gathered.refusal(own, {real}) == "TB-ANALYSIS-ORIGIN");
}

TEST_CASE("gathered run: has run, sensor, approvals and all frames, and raw behaviour if nothing presses") {
  Gathered gathered;
  const std::int64_t run = store_pressure_run(gathered.store, example_run());
  gathered.store.add_report({run, "1-a", "h", "K. Lee", kUtc, "", ""});
  const ReportInput input = gathered.of(run);
  CHECK((input.run.run == run && input.run.operator_name == "N. Nobody"));
  REQUIRE(input.sensor);
  CHECK(input.sensor->type == "array-3x2");
  REQUIRE(input.approvals.size() == 1);
  CHECK(input.approvals[0].number == "1-a");
  CHECK((input.frame_count == 4 && input.history.frames == 4 && !input.history.presses));
  CHECK((input.health.loaded && !input.health.swaps_assessed));
  CHECK(input.behaviour.taxels == std::vector<int>{0, 1, 2, 3, 4, 5});

  // Under an indenter nothing is said of loops, and silent taxels need not be dead.
  const Begun begun = begin_example(gathered.store);
  for (int i = 0; i < 4; ++i) gathered.store.append_frame(begun.run, example_frame(begun.branch, i));
  const ReportInput pressed = gathered.of(begun.run);
  CHECK((pressed.history.presses && !pressed.health.loaded && pressed.behaviour.taxels.empty()));

  // A voided branch's frames are frames, too.
  const std::int64_t again = store_pressure_run(gathered.store, example_run());
  db::BranchRecord second = example_branch();
  second.attempt = 1;
  const std::int64_t broken = gathered.store.begin_branch(again, second);
  db::FrameRecord frame = example_frame(broken, 0);
  frame.wrench.reset();
  gathered.store.append_frame(again, frame);
  gathered.store.void_branch(broken, "the scanner was lost");
  CHECK(gathered.of(again).frame_count == 5);
}

TEST_CASE("gathered run: swapped lines need an earlier seating that did not fail, of the run's number of taxels") {
  const auto assessed = [](const std::vector<double>& earlier, const std::vector<double>& own, const char* verdict) {
    Gathered gathered;
    (void)store_pressure_run(gathered.store, example_run(), earlier, verdict);
    return gathered.of(store_pressure_run(gathered.store, example_run(), own, "fail")).health.swaps_assessed;
  };
  CHECK(assessed(kSeating, kSeating, "pass"));
  CHECK(assessed(kSeating, kSeating, "warning"));
  CHECK_FALSE(assessed(kSeating, kSeating, "fail"));
  CHECK_FALSE(assessed({}, kSeating, "pass"));
  CHECK_FALSE(assessed(kSeating, {}, "pass"));
  CHECK_FALSE(assessed({1, 2, 3, 4}, {1, 2, 3, 4}, "pass"));
  Gathered gathered;
  (void)store_pressure_run(gathered.store, example_run(), kSeating);
  (void)store_pressure_run(gathered.store, example_run(), kSeating, "fail");  // an ill one in between
  const ReportInput input = gathered.of(store_pressure_run(gathered.store, example_run(), kSeating));
  CHECK(input.history.seating_v == std::vector<double>{5, 10, 15, 20, 25, 30});
  CHECK(input.history.earlier_seating_v == input.history.seating_v);
  CHECK(input.history.earlier_seating_run == 1);
}

TEST_CASE("counted taxels: those with a model or, without models, those that no finding excludes") {
  Health health;
  health.rows = 2;
  health.columns = 2;
  health.findings = {{1, "noisy", "", false}, {2, "dead", "", true}, {2, "noisy", "", false}, {0, "stuck", "", true}};
  CHECK(counted_taxels({}, health) == std::vector<int>{1, 3});
  SensorModel fit;
  fit.taxels.resize(4);
  for (ModelTaxel& taxel : fit.taxels) taxel.status = TaxelStatus::kFitted;
  fit.taxels[3].status = TaxelStatus::kUnfit;
  CHECK(counted_taxels(fit, health) == std::vector<int>{0, 1, 2});
  health.findings.clear();
  CHECK(counted_taxels({}, health) == std::vector<int>{0, 1, 2, 3});
}

}  // namespace tactbench::tests::gather

// Runs: a value read once is kept, and a part of a run that cannot be read does not affect the others.

using namespace tactbench::tests;

namespace {

// One complete repeat of the sequence "down" under an indenter, at 23 °C.
Begun begin_pressed(db::RunStore& store, const db::RunRecord& record = example_run()) {
  const Begun begun = begin_example(store, record);
  for (int i = 0; i < 4; ++i) store.append_frame(begun.run, example_frame(begun.branch, i));
  store.append_event(begun.run, {5, "environment", "temperature_c", "23.0"});
  return begun;
}

template <class Action>
std::string analysis_error(Action action) {
  try {
    action();
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("Runs: a run is read on first use and does not change afterwards") {
  NewStore store;
  const Begun begun = begin_pressed(store);
  analysis::Runs runs(store);
  const db::RunRecord& record = runs.record(begun.run);
  const Dataset& dataset = runs.dataset(begun.run);
  const Dataset loaded = load_dataset(store, begun.run);
  REQUIRE(dataset.sequences.size() == 1);
  CHECK(dataset.sequences[0].repeats.at(0).volts == loaded.sequences.at(0).repeats.at(0).volts);
  CHECK(dataset.noise_v == loaded.noise_v);

  store.void_branch(begun.branch, "the scanner was lost");
  store.append_event(begun.run, {6, "environment", "temperature_c", "28.0"});
  store.add_note(begun.run, "later");
  CHECK(&runs.dataset(begun.run) == &dataset);
  CHECK((&runs.record(begun.run) == &record && record.notes.empty()));
  CHECK((runs.history(begun.run).frames == 4 && runs.history(begun.run).void_frames == 0));
  CHECK(runs.press_runs(begun.run).at(0).frames.size() == 4);
  CHECK(runs.temperatures_c(begun.run) == std::vector{23.0});
  CHECK(&runs.store() == &store);

  analysis::Runs later(store);
  CHECK((later.history(begun.run).frames == 0 && later.history(begun.run).void_frames == 4));
  CHECK(later.press_runs(begun.run).empty());
  CHECK(later.temperatures_c(begun.run) == std::vector{23.0, 28.0});
  CHECK(analysis_error([&] { later.dataset(begun.run); }) == "TB-ANALYSIS-EMPTY");
}

TEST_CASE("Runs: a run without a dataset throws its reason each time, and still has its record and history") {
  NewStore store;
  db::RunRecord record = example_run();
  record.devices.pop_back();  // the scanner, whose calibration scales the counts
  const Begun begun = begin_pressed(store, record);
  analysis::Runs runs(store);
  for (int i = 0; i < 2; ++i) {
    CHECK(analysis_error([&] { runs.dataset(begun.run); }) == "TB-ANALYSIS-NO-CALIBRATION");
    CHECK(analysis_error([&] { runs.press_runs(begun.run); }) == "TB-ANALYSIS-NO-CALIBRATION");
  }
  CHECK(runs.record(begun.run).sensor_serial == "S-1");
  CHECK(runs.history(begun.run).frames == 4);
  CHECK(runs.temperatures_c(begun.run).size() == 1);

  for (int i = 0; i < 2; ++i) {
    CHECK(store_error([&] { runs.record(7); }) == "TB-STORE-NOT-FOUND");
    CHECK(store_error([&] { runs.history(7); }) == "TB-STORE-NOT-FOUND");
  }
}

// A run's way from its records by hand: which events are told and by what name, surroundings, void branches, seatings.

namespace {

RunLog history_of_events(std::vector<db::EventRecord> events) {
  StoredRun run;
  run.events = std::move(events);
  return load_run_log(run);
}

// The kind that one event is told as; empty: it is not.
std::string reported_as(const char* kind, const char* detail) {
  const RunLog history = history_of_events({{7, kind, "", detail}});
  return history.events.empty() ? std::string() : history.events.front().kind;
}

RunLog seating_check(const char* detail, std::vector<double> data) {
  StoredRun run;
  run.checks = {{1, 0, "seating", "pass", detail, std::move(data)}};
  return load_run_log(run);
}

}  // namespace

TEST_CASE("run events: those to be reported are listed with kind, time and text") {
  for (const char* kind : {"attempt", "branch-broken", "warning", "fault", "prompt", "word"}) {
    INFO(kind);
    CHECK(reported_as(kind, "x") == kind);
  }
  CHECK(reported_as("state", "running -> paused: asked") == "pause");
  CHECK(reported_as("state", "running -> suspended: air") == "suspension");
  CHECK(reported_as("state", "paused -> running") == "");
  CHECK(reported_as("seating", "left out") == "note");
  for (const char* kind : {"note", "safe", "conditioning"}) CHECK(reported_as(kind, "x") == "");
  const RunLog history = history_of_events({{2'500'000'000, "fault", "TB-X", "no air"},
                                            {1, "time", "", "settling 40 %"},
                                            {3'000'000'000, "prompt", "", "ready?"}});
  REQUIRE(history.events.size() == 2);
  CHECK((history.events[0].time_s == Approx(2.5) && history.events[0].text == "no air"));
  CHECK(history.events[1].time_s == Approx(3.0));
  CHECK(history.time_spent == "settling 40 %");
  CHECK((history.loaded && !history.presses));
}

TEST_CASE("run environment: lowest, highest and number of readings are given per quantity") {
  const RunLog history = history_of_events({{1, "environment", "temperature_c", "23.0"},
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

TEST_CASE("run branches: void ones are listed with repeat, branch and attempt, those with forces mark a press run") {
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
  RunLog history = load_run_log(run);
  REQUIRE(history.voids.size() == 2);
  CHECK((history.voids[0].sequence == "down" && history.voids[0].repeat == 2 && history.voids[0].branch == 3));
  CHECK((history.voids[0].attempt == 4 && history.voids[0].reason == "went back" && history.voids[1].sequence.empty()));
  CHECK((history.frames == 2 && history.void_frames == 3 && history.flagged == 1));
  CHECK(history.flags == std::map<std::string, int>{{"dwell", 1}, {"retried", 1}});
  CHECK_FALSE(history.presses);
  run.branches[0].from_n = 0.0;
  CHECK(load_run_log(run).presses);
  run.branches[0].from_n.reset();
  run.branches[2].to_n = 0.0;
  CHECK(load_run_log(run).presses);
  run.branches[2].to_n.reset();
  run.frames[4].wrench.emplace();
  CHECK(load_run_log(run).presses);
}

TEST_CASE("run seating: is loaded minus unloaded in volts, of the newest valid check") {
  CHECK(seating_check(R"({"volts_per_count":0.5})", {1, 2, 4, 8}).seating_v == std::vector<double>{1.5, 3.0});
  for (const char* other : {"", "[]", "{}", R"({"volts_per_count":"0.5"})"})
    CHECK(seating_check(other, {1, 2, 4, 8}).seating_v.empty());
  StoredRun run;
  run.checks = {{1, 0, "seating", "pass", R"({"volts_per_count":1})", {1, 2}},
                {1, 1, "seating", "fail", R"({"volts_per_count":1})", {1, 7}},
                {1, 2, "tare", "pass", R"({"volts_per_count":1})", {1, 9}}};
  CHECK(load_run_log(run).seating_v == std::vector<double>{6.0});
  CHECK(load_run_log(run).checks.size() == 3);
  run.checks.erase(run.checks.begin(), run.checks.begin() + 2);
  CHECK(load_run_log(run).seating_v.empty());
}

// Which quantities of a report are traceable, and which instruments page 1 warns about.

namespace {

db::DeviceRecord instrument(const char* role, const char* model, const char* serial, const char* calibration) {
  return {role, model, serial, "", "hardware", calibration};
}

ReportInput run_of_may() {
  ReportInput input;
  input.run.started_utc = "2024-05-06T07:08:09Z";
  input.evaluation.levels.resize(1);
  return input;
}

}  // namespace

TEST_CASE("traceability: pressure needs a separate reference with a certificate that is not overdue") {
  ReportInput input = run_of_may();
  const auto traceable = [&](const char* calibration) {
    input.run.devices = {instrument("regulator", "VPPM", "R-1", "{}"),
                         instrument("pressure reference", "PT", "P-1", calibration)};
    const std::vector<Traceability> all = traceability_of(input, {});
    REQUIRE(all.size() == 1);
    return all[0].traceable;
  };
  CHECK(traceable(R"({"certificate":"C-1","due":"2024-05-06"})"));
  CHECK_FALSE(traceable(R"({"certificate":"C-1","due":"2024-05-05"})"));
  CHECK(instrument_warnings(input).size() == 1);  // overdue
  CHECK_FALSE(traceable("{}"));
  CHECK(traceable(R"({"certificate":"C-1"})"));
  CHECK(instrument_warnings(input).empty());
  // Neither is it by the regulator entered twice, or alone.
  input.run.devices[0] = instrument("regulator", "PT", "P-1", "{}");
  CHECK_FALSE(traceability_of(input, {})[0].traceable);
  input.run.devices.pop_back();
  CHECK_FALSE(traceability_of(input, {})[0].traceable);
}

TEST_CASE("traceability: a press run states force and place, and pressure if it was evaluated") {
  ReportInput input = run_of_may();
  const auto quantities = [&] {
    std::string words;
    for (const auto& one : nlohmann::json::parse(traceability_json(input)))
      words += one["quantity"].get<std::string>() + (one["traceable"] == true ? "+ " : "- ");
    return words;
  };
  input.history.presses = true;
  CHECK(quantities() == "pressure- force- position- ");
  input.evaluation.levels.clear();
  input.run.devices = {instrument("stage x", "", "", R"({"certificate":"S-1"})"),
                       instrument("force sensor", "ATI", "FT-1", R"({"certificate":""})")};
  CHECK(quantities() == "force- position+ ");
  input.laboratory.instruments = {{"FT-1", "F-7", "ATI", "2024-01-31", "2025-01-31", ""}};
  CHECK(quantities() == "force+ position+ ");
}

// How wrong a reading is, by hand: 40 taxels whose |error| + U is 1, 2, ... of a unit.

namespace {

constexpr int kSome = 40;

void add_level(ConditionUncertainty& kind, double psi, bool up, double unit) {
  kind.pressure_psi.push_back(psi);
  kind.up.push_back(up);
  for (int i = 1; i <= kSome; ++i) {
    kind.error_psi.push_back(i % 2 == 0 ? 0.5 * unit * i : -0.5 * unit * i);
    kind.expanded_psi.push_back(0.5 * unit * i);
  }
}

ConditionUncertainty kind_of(UseCondition condition, double median_psi) {
  ConditionUncertainty kind;
  kind.condition = condition;
  kind.name = name_of(condition);
  kind.median_psi = median_psi;
  return kind;
}

// Within 2 % of 60 psi, 1.2 psi, 95 % of the taxels (|error| + U of 39 units) are where the unit is at most 0.0307 psi.
ReportInput read_at_levels() {
  ReportInput input;
  input.evaluation.full_scale_psi = 60.0;
  input.fit.taxels.resize(kSome);
  for (ModelTaxel& taxel : input.fit.taxels) taxel.status = TaxelStatus::kFitted;
  ConditionUncertainty worse = kind_of(UseCondition::kHeld, 1.0), better = kind_of(UseCondition::kFullSweeps, 0.5);
  for (const double psi : {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
    add_level(worse, psi, true, psi == 20.0 ? 0.04 : 0.03);
    if (psi < 60.0) add_level(worse, psi, false, psi < 30.0 ? 0.03 : 0.05);
    add_level(better, psi, true, psi == 50.0 ? 0.2 : 0.001);
  }
  input.uncertainty.emplace();
  input.uncertainty->conditions = {better, worse};
  input.uncertainty->levels.resize(1);
  return input;
}

}  // namespace

TEST_CASE("reading errors: the worst kind of history is quoted, the worst taxel is over all kinds") {
  const ReadingFigures found = reading_figures(read_at_levels()).value();
  CHECK(found.kind == name_of(UseCondition::kHeld));
  REQUIRE(found.levels.size() == 13);
  const ReadingLevel& level = *found.level(20.0, true);
  CHECK(level.within_psi == Approx(0.04 * 39));  // place 38 of 0 to 39
  CHECK(level.median_expanded_psi == Approx(0.02 * 21));
  CHECK((level.worst == 39 && level.worst_psi == Approx(1.6)));
  CHECK(level.high_psi == Approx(0.04 * 40));  // of the even ones: error + U; place 39
  CHECK(level.low_psi == Approx(-0.04 * 37));  // of the odd ones: error - U; 39 is at place 0, 37 at place 1
  CHECK((found.worst.taxel == 39 && found.worst.pressure_psi == 50.0));
  CHECK(found.worst.kind == name_of(UseCondition::kFullSweeps));
}

TEST_CASE(
    "reading errors: the measuring interval is the longest unbroken sequence of levels, per direction and for both") {
  ReportInput input = read_at_levels();
  ReadingFigures found = reading_figures(input).value();
  CHECK((found.tolerance_psi == Approx(1.2) && !found.by_mpe));
  CHECK((found.span_up.any && found.span_up.low_psi == 30.0 && found.span_up.high_psi == 60.0));
  CHECK((found.span_down.any && found.span_down.low_psi == 0.0 && found.span_down.high_psi == 20.0));
  CHECK(found.headline_psi == Approx(3.0));  // 5 %: within 2 % both are from 0 to 10 psi alone
  CHECK((found.headline.low_psi == 0.0 && found.headline.high_psi == 60.0));
  JudgedFigure mpe;
  mpe.criterion = Criterion::kMpe;
  mpe.limit = 0.5;
  input.judgement.figures = {mpe};
  found = reading_figures(input).value();
  CHECK((found.by_mpe && found.tolerance_psi == 0.5 && !found.span_up.any && !found.headline.any));
}

TEST_CASE("reading errors: without a valid kind of history there is no U, without an assessment no result") {
  ReportInput input = read_at_levels();
  for (ConditionUncertainty& kind : input.uncertainty->conditions) kind.not_valid = "too few";
  input.uncertainty->levels[0].error_psi = {0.25, -0.5, std::nan("")};
  const ReadingFigures found = reading_figures(input).value();
  CHECK_FALSE(found.known());
  CHECK((found.levels.size() == 1 && found.levels[0].within_psi == 0.5 && found.levels[0].worst == 1));
  CHECK(std::isnan(found.levels[0].median_expanded_psi));
  CHECK_FALSE(found.headline.any);
  input.uncertainty.reset();
  CHECK_FALSE(reading_figures(input).has_value());
}
