// Runs that make no dynamic model, and data that no model can be fitted to: each refused in all its words.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
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
std::string refused_run(const Change& change, const std::string& remedy) {
  ThreeRuns runs;
  change(runs);
  try {
    (void)fit_dynamic(runs.fitted, runs.rate, runs.creep, {.cells = 3, .threads = 1});
  } catch (const AnalysisError& error) {
    CHECK(error.remedy() == remedy);
    return error.id() + " " + error.what();
  }
  return {};
}

std::string refused_fit(const std::string& model, const Histories& histories,
                        const std::vector<std::string>& sequences = {}) {
  try {
    (void)fit_models(model, histories, sequences, {.starts = 1, .cells = 3}, 1);
  } catch (const AnalysisError& error) {
    return error.id() + " " + error.what();
  }
  return {};
}

Histories of_table(const std::vector<TableSeries>& series) {
  HistoriesOptions options;
  options.turn = 0.0;
  options.noise = 0.0;
  return histories_of(series, "t", options);
}

}  // namespace

TEST_CASE("runs of lag and creep that are of another sensor or origin are refused, each by what differs", "[dynamic]") {
  CHECK(refused_run([](ThreeRuns&) {}, "").empty());
  const std::string others = "lag and creep belong to a sensor: name runs of the one that is fitted";
  const auto other_rate = [&](auto change) { return refused_run([&](ThreeRuns& runs) { change(runs.rate); }, others); };
  const std::string same = "TB-ANALYSIS-OTHER-SENSOR run 2 is of sensor S on scanner C, run 1 of S on C";
  CHECK(other_rate([](Dataset& run) { run.rows = 2; }) == same);
  CHECK(other_rate([](Dataset& run) { run.columns = 1; }) == same);
  CHECK(other_rate([](Dataset& run) { run.sensor_serial = "T"; }) ==
        "TB-ANALYSIS-OTHER-SENSOR run 2 is of sensor T on scanner C, run 1 of S on C");
  CHECK(other_rate([](Dataset& run) { run.scanner_serial = "D"; }) ==
        "TB-ANALYSIS-OTHER-SENSOR run 2 is of sensor S on scanner D, run 1 of S on C");
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.sensor_serial = "T"; }, others) ==
        "TB-ANALYSIS-OTHER-SENSOR run 3 is of sensor T on scanner C, run 1 of S on C");
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.origin = "hardware"; },
                    "origins never mix: name runs of the same origin") ==
        "TB-ANALYSIS-ORIGIN run 3 is hardware, run 1 is simulated");
}

TEST_CASE("runs that tell nothing of lag or creep are refused with what would", "[dynamic]") {
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.sequences = runs.fitted.sequences; },
                    "measure one that does: tactbench run creep-levels") ==
        "TB-ANALYSIS-DYNAMICS run 3 shows no creep: it holds no level for ten frames");
  CHECK(refused_run([](ThreeRuns& runs) { runs.rate.sequences = runs.fitted.sequences; },
                    "measure one at several dwell times: tactbench run rate") ==
        "TB-ANALYSIS-DYNAMICS run 2 shows no lag: no repeat of it takes twice as long as another");
  CHECK(refused_run(
            [](ThreeRuns& runs) {
              for (Sample& sample : runs.fitted.sequences[0].repeats[0].steps) sample.setpoint_psi += 10.0;
            },
            "the dynamic model counts from the unloaded film: fit a run whose levels begin at 0 psi") ==
        "TB-ANALYSIS-DYNAMICS run 1 never returns to 0 psi: its lowest level is 10 psi");
  const std::string left_out = "check the frames: dead, stuck and saturated taxels are left out";
  CHECK(refused_run(
            [](ThreeRuns& runs) {
              runs.fitted.at_limit[0] = true;
              runs.rate.at_limit[1] = true;
            },
            left_out) == "TB-ANALYSIS-NO-TAXEL no taxel of run 1 is usable in it and in all runs of lag and creep");
  CHECK(refused_run(
            [](ThreeRuns& runs) {
              runs.fitted.at_limit = {true, true};
            },
            "check the samples: dead, stuck, saturated and constant outputs are left out") ==
        "TB-ANALYSIS-NO-TAXEL run 1: no taxel can be fitted");
  // One that is lost in a later run has the array's lag and creep.
  ThreeRuns runs;
  runs.rate.at_limit[1] = true;
  const SensorModel model = fit_dynamic(runs.fitted, runs.rate, runs.creep, {.cells = 3, .threads = 1});
  CHECK(model.taxels[1].lag_share == model.dynamics->shared.lag_share);
  CHECK(model.taxels[1].creep_scale == 1.0);
  CHECK(model.fitted().size() == 2);
}

TEST_CASE("data that carry no model are refused in all words: one direction, no rise, sequences that are not there") {
  const Histories up = of_table({{"a", 0, {0, 1, 2, 3}, {0, 1, 2, 4}}});
  CHECK(refused_fit("preisach", up) ==
        "TB-ANALYSIS-MODEL t: preisach cannot be fitted: branches of both directions are needed");
  CHECK_THAT(refused_fit("elam", up), Catch::StartsWith("TB-ANALYSIS-NO-LOOP elam is made of the external loop: "));
  CHECK(refused_fit("none", up) == "TB-ANALYSIS-MODEL t: none cannot be fitted: there is no model named \"none\"");
  CHECK_THAT(refused_fit("preisach", up, {"b"}), Catch::StartsWith("TB-MODEL-SEQUENCE no sequence \"b\""));
  CHECK(refused_fit("monotone", up).empty());
  // The same output at both ends, more between.
  const Histories bump = of_table({{"a", 0, {0, 1, 2, 1, 0}, {1, 2, 1, 1.5, 1}}});
  CHECK_THAT(refused_fit("poly", bump),
             Catch::StartsWith("TB-ANALYSIS-FALLING the output goes from 1 to 1 where the input rises"));
  // Of two taxels the second rises: the first is unfit, without a reason of its own.
  const Histories one =
      of_table({{"a", 0, {0, 1, 2, 1, 0}, {1, 2, 1, 1.5, 1}}, {"a", 1, {0, 1, 2, 1, 0}, {0, 1, 2, 1, 0}}});
  const SensorModel fit = fit_models("poly", one, {}, {}, 1);
  CHECK((fit.taxels[0].status == TaxelStatus::kUnfit && fit.taxels[0].reason.empty()));
  CHECK(fit.taxels[1].fitted());
  CHECK_THROWS_WITH(of_table({{"a", 0, {0, 1, 2, 1, 0}, {3, 3, 3, 3, 3}}}), "t: no taxel can be fitted");
}
