// The score of a dynamic model: in runs time goes on from sequence to sequence, and what passed beside a hold was work;
// each sequence of a table is a recording of its own.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/compensators.h"
#include "analysis/statistics/scoring/model_score.h"
#include "tests/analysis/support/creeping_film.h"

using namespace tactbench::analysis;

namespace {

// Held 2 s at 20 psi after 100 s, 3 s at 30; then, 7 s later and for 7 s, at 15 psi, and for 4 s at 40.
Histories two_ways_up(std::int64_t run) {
  Histories histories;
  histories.run = run;
  histories.source = "data";
  TaxelHistories& taxel = histories.taxels.emplace_back();
  taxel.taxel = 0;
  taxel.fit = taxel.score = {
      {"first", {10, 20, 30}, {0.5, 1.0, 1.6}, {{0, 2, true}}, {0, 100, 103}, {0, 2, 3}},
      {"second", {15, 40}, {0.8, 2.5}, {{0, 1, true}}, {110, 114}, {7, 4}},
  };
  return histories;
}

}  // namespace

TEST_CASE("a dynamic model's score by hand: a run's time goes on, a table's sequences begin anew", "[dynamic]") {
  SensorModel document = tactbench::creeping::creeping_film();
  document.input_unit = "psi";
  document.output_unit = "V";
  const auto scored = [&](std::int64_t run) {
    return score_model(document, two_ways_up(run), {}, 1).taxels.compensated;
  };
  const auto off = [](const Compensated& there, double psi) { return std::abs(there.pressure_psi - psi); };

  const auto run = compensator_of(document, document.taxels[0]);
  (void)run->step(0.5, 0.0);
  run->work(98.0);  // of 100 s the first level was held for 2
  double sum = off(run->step(1.0, 2.0), 20.0);
  sum += off(run->step(1.6, 3.0), 30.0);
  (void)run->step(0.8, 7.0);
  sum += off(run->step(2.5, 4.0), 40.0);
  CHECK(scored(5).samples == 3);
  CHECK(scored(5).sum == Approx(sum).epsilon(1e-12));

  const auto table = compensator_of(document, document.taxels[0]);
  (void)table->step(0.5, 0.0);
  double table_sum = off(table->step(1.0, 100.0), 20.0);
  table_sum += off(table->step(1.6, 3.0), 30.0);
  table->start(Start::kUnknown);  // 0.8 V is not the unloaded output
  (void)table->step(0.8, 0.0);
  table_sum += off(table->step(2.5, 4.0), 40.0);
  CHECK(scored(0).samples == 3);
  CHECK(scored(0).sum == Approx(table_sum).epsilon(1e-12));
  CHECK(std::abs(table_sum - sum) > 0.01);
}
