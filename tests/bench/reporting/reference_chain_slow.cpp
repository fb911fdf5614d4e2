// An error of the input that reads the reference, seen in corrected readings: U of a calibration holds the plant's
// pressure with the input's row, and not without it. On benches and a sensor that nothing was chosen on.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/statistics/figures/step_kinds.h"
#include "analysis/statistics/figures/streams.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/benchmarks/study/simulated_run.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::tests;
using bench::KnownRun;

namespace {

// Share of the readings of full sweeps within U of the chamber's pressure.
double share_held(const KnownRun& run, const SensorModel& fit, const ConditionUncertainty& stated) {
  std::vector<std::vector<StepKind>> kinds;
  std::vector<std::vector<std::size_t>> first;
  std::size_t frames = 0;
  for (const SequenceData& sequence : run.data.sequences) {
    kinds.push_back(step_kinds(sequence, fit.pressure_psi.front(), fit.pressure_psi.back()));
    first.emplace_back();
    for (const Repeat& repeat : sequence.repeats) {
      first.back().push_back(frames);
      frames += repeat.steps.size();
    }
  }
  double within = 0.0, all = 0.0;
  compensate_in_order(run.data, fit, 1, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      if (!kinds[s][i].full) return;
      const auto [known, expanded] = reading_uncertainty(stated, taxel, now.pressure_psi, kinds[s][i].up);
      within += std::abs(now.pressure_psi - known - run.chamber_psi[first[s][r] + i]) <= expanded ? 1.0 : 0.0;
      all += 1.0;
    };
  });
  return within / all;
}

}  // namespace

TEST_CASE("reference chain: an error of the voltage input is within U by its row, and not without it") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  double with = 0.0, without = 0.0;
  constexpr int kRigs = 4;
  for (int rig = 1; rig <= kRigs; ++rig) {
    const bench::SimulatedRun made = {
        {"descending"},
        {"recipe.repeats=2", "reference.certificate_covers=transducer", "reference.input_limit_v=0.06",
         fmt::format("simulation.instrument_seed={}", 2400 + rig)}};
    const bench::SimulatedSensor sensor{.seed = 2401};
    const auto run = [&](int seed) {
      return simulate_run(made, sensor, static_cast<unsigned>(10 * rig + seed), store);
    };
    const KnownRun calibration = run(1), held_out = run(2), again = run(3);
    const SensorModel fit = fit_array(calibration.data);
    UncertaintyInputs inputs;
    inputs.history.same = {&held_out.data};
    db::RunRecord record = store.run(calibration.data.run);
    const Uncertainty whole = assess_uncertainty(calibration.data, fit, record, inputs);
    const Budget& budget = whole.levels[whole.chosen].median;
    const auto row = std::ranges::find(budget.contributions, UncertaintySource::kReferenceInput, &Contribution::source);
    REQUIRE(row != budget.contributions.end());
    CHECK(row->width == Approx(0.6));
    for (db::DeviceRecord& device : record.devices) {
      auto document = nlohmann::json::parse(device.calibration_json);
      if (document.erase("input_limit_v") == 1) device.calibration_json = document.dump();
    }
    const Uncertainty lacking = assess_uncertainty(calibration.data, fit, record, inputs);
    with += share_held(again, fit, whole.condition(UseCondition::kFullSweeps)) / kRigs;
    without += share_held(again, fit, lacking.condition(UseCondition::kFullSweeps)) / kRigs;
  }
  CAPTURE(with, without);
  CHECK(with >= 0.93);
  CHECK(without < 0.85);
}
