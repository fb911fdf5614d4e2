// Runs that make no dynamic model, and data that no model can be fitted to: each refused by its id.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/identify/dynamic/dynamic_alone.h"
#include "tests/analysis/identify/refusals.h"
#include "tests/analysis/support/dynamic_walk.h"

using namespace synthetic;

namespace {

struct ThreeRuns {
  Dataset fitted, rate, creep;
  ThreeRuns() {
    const std::vector<WalkedTaxel> taxels = {{0.0, 0.05, 1.0, 0.05}, {0.1, 0.06, 1.0, 0.05}};
    const std::vector<double> way{0, 20, 40, 60, 40, 20, 40, 60, 40, 20, 0};
    std::vector<double> held;
    for (const double level : {0.0, 30.0, 60.0})
      for (int i = 0; i < 30; ++i) held.push_back(level);
    fitted = walked_run({}, taxels, {{"loop", {{way, 3.0}}}}, 60.0);
    rate = walked_run({}, taxels, {{"rate", {{way, 0.8}, {way, 8.0}}}}, 60.0);
    creep = walked_run({}, taxels, {{"held", {{held, 3.0}}}}, 60.0);
    std::int64_t number = 0;
    for (Dataset* const run : {&fitted, &rate, &creep}) {
      run->run = ++number;
      run->sensor_serial = "S";
      run->scanner_serial = "C";
    }
  }
};

template <class Change>
std::string refused_run(const Change& change) {
  ThreeRuns runs;
  change(runs);
  return id_of_refusal([&] { return fit_dynamic(runs.fitted, runs.rate, runs.creep, {.cells = 3, .threads = 1}); });
}

std::string refused_fit(const std::string& model, const Histories& histories,
                        const std::vector<std::string>& sequences = {}) {
  return id_of_refusal([&] { return fit_models(model, histories, sequences, {.starts = 1, .cells = 3}, 1); });
}

Histories of_table(const std::vector<TableSeries>& series) {
  HistoriesOptions options;
  options.turn = 0.0;
  options.noise = 0.0;
  return histories_of(series, "t", options);
}

}  // namespace

TEST_CASE("runs of lag and creep that are of another sensor or origin are refused, each by what differs", "[dynamic]") {
  CHECK(refused_run([](ThreeRuns&) {}).empty());
  const auto other_rate = [&](auto change) { return refused_run([&](ThreeRuns& runs) { change(runs.rate); }); };
  CHECK(other_rate([](Dataset& run) { run.rows = 2; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(other_rate([](Dataset& run) { run.columns = 1; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(other_rate([](Dataset& run) { run.sensor_serial = "T"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(other_rate([](Dataset& run) { run.scanner_serial = "D"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.sensor_serial = "T"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.origin = "hardware"; }) == "TB-ANALYSIS-ORIGIN");
}

TEST_CASE("runs that tell nothing of lag or creep are refused", "[dynamic]") {
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.sequences = runs.fitted.sequences; }) == "TB-ANALYSIS-DYNAMICS");
  CHECK(refused_run([](ThreeRuns& runs) { runs.rate.sequences = runs.fitted.sequences; }) == "TB-ANALYSIS-DYNAMICS");
  CHECK(refused_run([](ThreeRuns& runs) {
          for (Sample& sample : runs.fitted.sequences[0].repeats[0].steps) sample.setpoint_psi += 10.0;
        }) == "TB-ANALYSIS-DYNAMICS");
  CHECK(refused_run([](ThreeRuns& runs) {
          runs.fitted.at_limit[0] = true;
          runs.rate.at_limit[1] = true;
        }) == "TB-ANALYSIS-NO-TAXEL");
  CHECK(refused_run([](ThreeRuns& runs) { runs.fitted.at_limit = {true, true}; }) == "TB-ANALYSIS-NO-TAXEL");
  // One that is lost in a later run has the array's lag and creep.
  ThreeRuns runs;
  runs.rate.at_limit[1] = true;
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep, {.cells = 3, .threads = 1});
  CHECK(model.taxels[1].lag_share == model.dynamics->shared.lag_share);
  CHECK(model.taxels[1].creep_scale == 1.0);
  CHECK(model.fitted().size() == 2);
}

TEST_CASE("data that carry no model are refused: one direction, no rise, sequences that are not there") {
  const Histories up = of_table({{"a", 0, {0, 1, 2, 3}, {0, 1, 2, 4}}});
  CHECK(refused_fit("preisach", up) == "TB-ANALYSIS-MODEL");
  CHECK(refused_fit("elam", up) == "TB-ANALYSIS-NO-LOOP");
  CHECK(refused_fit("none", up) == "TB-ANALYSIS-MODEL");
  CHECK(refused_fit("preisach", up, {"b"}) == "TB-MODEL-SEQUENCE");
  CHECK(refused_fit("monotone", up).empty());
  // The same output at both ends, more between.
  const Histories bump = of_table({{"a", 0, {0, 1, 2, 1, 0}, {1, 2, 1, 1.5, 1}}});
  CHECK(refused_fit("poly", bump) == "TB-ANALYSIS-FALLING");
  // Of two taxels the second rises: the first is unfit, without a reason of its own.
  const Histories one =
      of_table({{"a", 0, {0, 1, 2, 1, 0}, {1, 2, 1, 1.5, 1}}, {"a", 1, {0, 1, 2, 1, 0}, {0, 1, 2, 1, 0}}});
  const SensorModel fit = fit_models("poly", one, {}, {}, 1);
  CHECK((fit.taxels[0].status == TaxelStatus::kUnfit && fit.taxels[0].reason.empty()));
  CHECK(fit.taxels[1].fitted());
  CHECK(id_of_refusal([] { return of_table({{"a", 0, {0, 1, 2, 1, 0}, {3, 3, 3, 3, 3}}}); }) == "TB-ANALYSIS-NO-TAXEL");
}
