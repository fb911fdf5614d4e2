// The runs of simulated sensors that the benchmarks with a known truth are made of.
#include "bench/benchmarks/simulated_run.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

// 2 x 2 taxels; a loop to 60 psi and back, a random one, half a second each.
SimulatedRun short_reversals() {
  return {{"random-reversal"},
          {"scanner.kind=frame-source", "scanner.rows=2", "scanner.columns=2", "recipe.reversals=1",
           "recipe.dwell_s=0.5", "recipe.seed=3"}};
}

}  // namespace

TEST_CASE("simulated runs of benchmarks: the plant's pressure at the end of each frame, in the order of the frames") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("a.db"), db::Durability::kNormal);
  const KnownRun paper = simulate_run(short_reversals(), {false, 5}, 7, store);
  REQUIRE(paper.data.sequences.size() == 1);
  REQUIRE(paper.data.sequences[0].repeats.size() == 1);
  const analysis::Repeat& repeat = paper.data.sequences[0].repeats[0];
  REQUIRE(repeat.steps.size() > 61);
  REQUIRE(paper.chamber_psi.size() == repeat.steps.size());
  double farthest = 0.0, mean = 0.0;
  for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
    const double level = i <= 30 ? 2.0 * static_cast<double>(i) : i <= 60 ? 120.0 - 2.0 * static_cast<double>(i) : -1.0;
    if (level >= 0.0) CHECK(repeat.steps[i].setpoint_psi == level);
    CHECK(std::abs(paper.chamber_psi[i] - repeat.steps[i].setpoint_psi) < 0.3);  // within the band
    const double off = paper.chamber_psi[i] - repeat.steps[i].reference_psi;
    farthest = std::max(farthest, std::abs(off));
    mean += off / static_cast<double>(repeat.steps.size());
  }
  CHECK(farthest > 0.0);  // the truth, not the transducer's reading
  CHECK(farthest < 0.25);
  CHECK(std::abs(mean) < 0.05);
  CHECK((paper.data.rows == 2 && paper.data.columns == 2));
  CHECK(paper.data.run == 1);

  const db::RunRecord run = store.run(1);
  CHECK(run.outcome == db::Outcome::kCompleted);
  CHECK(run.operator_name == "benchmark");
  CHECK(run.sensor_serial == "SIM-0005");
  CHECK((run.seed == 7 && run.sensor_seed == 5));
  CHECK(run.overrides_json.find("recipe.reversals") != std::string::npos);
  CHECK(run.overrides_json.find("harsh") == std::string::npos);

  // The harsh specimen of the same number in the same store, another seed of the noise.
  const KnownRun harsh = simulate_run(short_reversals(), {true, 5}, 8, store);
  CHECK(store.run(2).seed == 8);
  CHECK(store.run(2).sensor_serial == "SIM-0005");
  CHECK(store.run(2).overrides_json.find("harsh") != std::string::npos);
  CHECK(harsh.data.run == 2);
  REQUIRE(harsh.data.sequences[0].repeats[0].volts.size() == repeat.volts.size());
  double most = 0.0;
  for (std::size_t i = 0; i < repeat.volts.size(); ++i)
    most = std::max(most, std::abs(harsh.data.sequences[0].repeats[0].volts[i] - repeat.volts[i]));
  CHECK(most > 0.05);
}

TEST_CASE("simulated runs of benchmarks: a recipe that is not there is an error, and nothing is stored") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("a.db"), db::Durability::kNormal);
  CHECK_THROWS(simulate_run({{"no-such-recipe"}, {}}, {}, 1, store));
  CHECK(store.runs().empty());
}

TEST_CASE("simulated runs of benchmarks: what is asked for in a request") {
  const RunRequest request = descending_request(3, 9);
  REQUIRE(request.recipes.size() == 1);
  CHECK(request.recipes[0].name == "descending");
  CHECK(request.recipes[0].repeats == 3);
  CHECK_FALSE(request.check_seating);
  CHECK(request.sensor.serial == "SIM-0001");
  CHECK((request.sensor_type.rows == 16 && request.sensor_type.columns == 16));
  const std::vector<sequences::Step> steps = sequences::compile(request.recipes);
  CHECK(steps.size() == 3 * 211);
  for (const sequences::Step& step : steps) CHECK(takes_frame(step));
}
