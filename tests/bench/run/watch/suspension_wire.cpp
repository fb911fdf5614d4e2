// A run waits, vented, while the compressed air is missing, and continues once it has been back for a while.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "analysis/dataset.h"
#include "bench/run/time_estimate.h"
#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

bench::RunRequest request_with(double lost_at_s, double lasts_s, double timeout_s) {
  bench::RunRequest request =
      small_request({{"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}});
  request.recipes = {
      small_recipe(fmt::format("[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\n"
                               "hold_s = 2\ntimeout_s = {}\n",
                               timeout_s))};
  request.bench.simulation->plant.faults = {planned_fault(bench::FaultKind::kSupplyLost, lost_at_s, lasts_s, 0.001)};
  return request;
}

}  // namespace

TEST_CASE("suspension: a supply that does not return ends the run, which can be resumed") {
  QuickStore store;
  const bench::RunResult ended = run_small(request_with(45.0, 1e6, 10.0), store);
  REQUIRE(ended.error);
  CHECK(ended.error->id() == "TB-RUN-SUSPENDED");
  CHECK(ended.safe == db::SafeState::kVerified);
  bench::RunRequest again = request_with(1e6, 1.0, 10.0);
  again.resume = ended.run;
  const bench::RunResult result = run_small(again, store);
  if (result.error) FAIL(result.error->what());
  CHECK(analysis::load_dataset(store, result.run).sequences.at(0).repeats.size() == 2);
}

TEST_CASE("suspension: the wait is not learned as time of the recipe") {
  std::vector<double> learned;
  for (const double lasts_s : {0.0, 30.0}) {
    QuickStore store;
    const bench::RunRequest request = request_with(lasts_s > 0.0 ? 45.0 : 1e6, lasts_s, 600.0);
    const bench::RunResult result = run_small(request, store);
    if (result.error) FAIL(result.error->what());
    CHECK(result.waiting_seconds == Approx(lasts_s).margin(8.0));
    bench::TimeEstimate estimate(request.recipes, sequences::compile(request.recipes), sequences::TimeModel());
    estimate.learn(store, request.bench.id, request.overrides, false);
    CHECK(estimate.total().runs == 1);
    learned.push_back(estimate.total().p50_s);
  }
  CHECK(learned[1] == Approx(learned[0]).epsilon(0.05));
}
