// Runs that make no dynamic model, and data that no model can be fitted to: each refused by its id.
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/models/linearised.h"
#include "tests/analysis/identify/refusals.h"
#include "tests/analysis/support/dynamic_plant.h"
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

TEST_CASE("fit_dynamic: rate and creep runs of another sensor or origin are refused", "[dynamic]") {
  CHECK(refused_run([](ThreeRuns&) {}).empty());
  const auto other_rate = [&](auto change) { return refused_run([&](ThreeRuns& runs) { change(runs.rate); }); };
  CHECK(other_rate([](Dataset& run) { run.rows = 2; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(other_rate([](Dataset& run) { run.columns = 1; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(other_rate([](Dataset& run) { run.sensor_serial = "T"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(other_rate([](Dataset& run) { run.scanner_serial = "D"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.sensor_serial = "T"; }) == "TB-ANALYSIS-OTHER-SENSOR");
  CHECK(refused_run([](ThreeRuns& runs) { runs.creep.origin = "hardware"; }) == "TB-ANALYSIS-ORIGIN");
}

TEST_CASE("fit_dynamic: runs that contain no information on lag or creep are refused", "[dynamic]") {
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

TEST_CASE("fit_models: data with one direction, without a rise or without a named sequence are refused") {
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

// What of lag and creep a sensor's model undoes.

using namespace tactbench::analysis;

TEST_CASE("SensorDynamics: reports whether creep, lag or both are removed", "[dynamic]") {
  const auto with = [](std::array<double, 3> creep, double lag) {
    SensorDynamics dynamics;
    dynamics.shared.creep_share = creep;
    dynamics.shared.lag_share = lag;
    return std::string(compensates_creep(dynamics) ? "c" : "-") + (compensates_lag(dynamics) ? "l" : "-") +
           (in_time(dynamics) ? "t" : "-");
  };
  CHECK(with({0, 0, 0}, 0) == "---");
  CHECK(with({0, 0, 0}, 0.1) == "-lt");
  CHECK(with({0, 0, 0.1}, 0) == "c-t");
  CHECK(with({0.1, 0.1, 0.2}, 0.1) == "clt");
}

// Streams of a dynamic Preisach model on films of known truth, simulated by other means.

namespace {

std::unique_ptr<Compensator> stream_of(const HysteresisModel& model, const Dynamics& dynamics,
                                       const DynamicTaxel& taxel) {
  CompensatorSetup setup;
  setup.time = std::make_shared<PassedTime>();
  setup.time->dynamics = dynamics;
  setup.creep_scale = taxel.creep_scale;
  setup.lag_share = taxel.lag_share;
  return make_compensator(model, setup);
}

}  // namespace

TEST_CASE("dynamic Preisach: the compensator recovers the pressures of a creeping film behind a divider", "[dynamic]") {
  const DynamicArray array = dynamic_array(4);
  for (std::size_t t = 0; t < array.films.size(); ++t) {
    const LinearisedModel model(array.taxels[t].divider, std::make_shared<PreisachModel>(array.films[t]));
    DynamicPlant plant(array.films[t], array.dynamics, array.taxels[t]);
    const auto stream = stream_of(model, array.dynamics, array.taxels[t]);
    const auto deaf = stream_of(model, {}, {});
    double sum = 0.0, most = 0.0, deaf_sum = 0.0;
    const std::vector<double> way = random_way(600, 2.0, static_cast<unsigned>(t) + 9);
    for (const double psi : way) {
      const double seconds = psi == 0.0 ? 30.0 : 2.5, volts = plant.step(psi, seconds);
      const double error = std::abs(stream->step(volts, seconds).pressure_psi - psi);
      deaf_sum += std::abs(deaf->step(volts, 0.0).pressure_psi - psi);
      sum += error;
      most = std::max(most, error);
    }
    const auto count = static_cast<double>(way.size());
    INFO("taxel " << t << ": " << sum / count << " psi, most " << most << ", without time " << deaf_sum / count);
    CHECK(sum / count < 0.03);
    CHECK(most < 0.6);
    CHECK(deaf_sum > 5.0 * sum);
  }
}

TEST_CASE("dynamic Preisach: the error stays below 1 psi beyond a nearly flat piece of a branch", "[dynamic]") {
  const PreisachModel film(0.0, 60.0, 0.0, {2.0, 0.0, 0.01, 0.0, 0.0, 2.0});  // 10 mV from 20 to 40 psi
  DynamicArray array = dynamic_array(1);
  array.dynamics.creep_share = {0.3, 0.0, 0.0};
  DynamicPlant plant(film, array.dynamics, array.taxels[0]);
  const LinearisedModel model(array.taxels[0].divider, std::make_shared<PreisachModel>(film));
  const auto stream = stream_of(model, array.dynamics, array.taxels[0]);
  double most = 0.0;
  for (int i = 0; i <= 60; ++i) {
    const double psi = i <= 30 ? 2.0 * i : 120.0 - 2.0 * i;
    const double off = std::abs(stream->step(plant.step(psi, 2.5), 2.5).pressure_psi - psi);
    if (psi < 20.0 || psi > 40.0) most = std::max(most, off);
  }
  CHECK(most < 1.0);
}
