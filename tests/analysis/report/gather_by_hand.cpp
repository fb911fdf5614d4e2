// What a report gathers of a run and of further runs: taxels that count, swaps that can be told, runs that are refused.
#include "analysis/report/gather.h"

#include <catch2/catch.hpp>

#include "tests/db/new_store.h"

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

TEST_CASE("gathered by hand: further runs of another origin or sensor are refused") {
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

TEST_CASE("gathered by hand: run, sensor, approvals, frames of both kinds, and the behaviour where nothing presses") {
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

TEST_CASE("gathered by hand: swapped lines are told from two seatings of as many taxels as the run has") {
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

TEST_CASE("gathered by hand: taxels that count are those with a model, and without models those that are sound") {
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
