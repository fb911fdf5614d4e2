// The lag of an array from repeats at two rates, on films that are straight lines: its time and the taxels' shares come
// out as they were put in, and doubt draws a taxel toward the array by what it is worth. Which data a dynamic fit
// refuses, and streams of its models.

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/models/linearised.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// 0, 10, 20, 30, 20, 10, 0: a slope at the second, third, fifth and sixth.
const std::vector<double> kUpAndDown{0, 10, 20, 30, 20, 10, 0};

// One of the times that are tried, from 0.1 s on by tenths more.
double lag_time(int k) {
  double lag_s = 0.1;
  for (int i = 0; i < k; ++i) lag_s *= 1.1;
  return lag_s;
}

std::vector<double> zeros_of_taxels(const std::vector<WalkedTaxel>& taxels) {
  std::vector<double> zeros;
  for (const WalkedTaxel& taxel : taxels) zeros.push_back(taxel.zero);
  return zeros;
}

ArrayDynamics lag_of(const Dynamics& d, const std::vector<WalkedTaxel>& taxels,
                     const std::vector<WalkedSequence>& sequences) {
  ArrayDynamics found = nothing_known(taxels.size());
  find_lag(walked_run(d, taxels, sequences, 30.0), zeros_of_taxels(taxels), std::vector<bool>(taxels.size(), true),
           found);
  return found;
}

}  // namespace

TEST_CASE("lag search: recovers the time constant and each taxel's share, for any slopes and zeros", "[dynamic]") {
  for (const int k : {0, 12, 24, 45}) {
    Dynamics d;
    d.lag_s = lag_time(k);
    const double fast = d.lag_s, slow = 40.0 * d.lag_s;
    const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.04}, {0.2, 0.1, 1.0, 0.08}};
    const ArrayDynamics found = lag_of(d, taxels, {{"rate", {{kUpAndDown, fast}, {kUpAndDown, slow}}}});
    CAPTURE(k);
    CHECK(found.rate_samples == 4);
    CHECK(found.shared.lag_s == d.lag_s);
    CHECK(found.shared.lag_share == Approx(0.06).epsilon(1e-6));
    CHECK(found.lag_share[0] == Approx(0.04).epsilon(1e-6));
    CHECK(found.lag_share[1] == Approx(0.08).epsilon(1e-6));
  }
}

TEST_CASE("lag search: accounts for unequal pressures at the two rates, conditioning and creep", "[dynamic]") {
  Dynamics d;
  d.creep_share = {0.05, 0.03, 0.02};
  d.creep_half = 6.0;
  d.lag_s = lag_time(24);
  // Twice the creep of the array, and half of it. A sequence without a second rate comes before.
  const std::vector<WalkedTaxel> taxels = {{0.1, 0.05, 2.0, 0.05}, {0.3, 0.05, 0.5, 0.09}};
  const Dataset data = walked_run(d, taxels,
                                  {{"other", {{{0, 15, 30, 15, 0}, 2.0, 0.0, 0.0}}},
                                   {"rate", {{kUpAndDown, 0.8, 50.0, 0.4}, {kUpAndDown, 60.0, 70.0, 0.0}}}},
                                  30.0);
  ArrayDynamics found = nothing_known(2);
  found.shared.creep_share = d.creep_share;
  found.shared.creep_half = d.creep_half;
  found.creep_scale = {2.0, 0.5};
  find_lag(data, {0.1, 0.3}, {true, true}, found);
  CHECK(found.rate_samples == 4);
  CHECK(found.shared.lag_s == d.lag_s);
  CHECK(found.shared.lag_share == Approx(0.07).epsilon(1e-6));
  CHECK(found.lag_share[0] == Approx(0.05).epsilon(1e-6));
  CHECK(found.lag_share[1] == Approx(0.09).epsilon(1e-6));
}

TEST_CASE("lag search: compares the fastest with the slowest repeat, the first of equal ones", "[dynamic]") {
  Dynamics d;
  d.lag_s = lag_time(24);
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.06}};
  Dataset data = walked_run(d, taxels,
                            {{"rate",
                              {{kUpAndDown, 2.0},
                               {kUpAndDown, 0.75},
                               {kUpAndDown, 0.75},
                               {kUpAndDown, 40.0},
                               {kUpAndDown, 40.0},
                               {kUpAndDown, 3.0}}}},
                            30.0);
  for (const std::size_t other : {0U, 2U, 4U, 5U})
    for (std::size_t i = 0; i < kUpAndDown.size(); ++i)
      data.sequences[0].repeats[other].volts[i] += 0.1 * static_cast<double>(i % 2);
  ArrayDynamics found = nothing_known(1);
  find_lag(data, {0.0}, {true}, found);
  CHECK(found.shared.lag_s == d.lag_s);
  CHECK(found.lag_share[0] == Approx(0.06).epsilon(1e-6));
}

TEST_CASE("lag search: two rates must differ by more than a factor of two", "[dynamic]") {
  Dynamics d;
  d.lag_s = 0.5;
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.06}};
  const auto samples = [&](double slow) {
    return lag_of(d, taxels, {{"rate", {{kUpAndDown, 1.0}, {kUpAndDown, slow}}}}).rate_samples;
  };
  CHECK(samples(2.0) == 0);
  CHECK(samples(2.0625) == 4);
  CHECK(samples(0.5) == 0);
  CHECK(samples(0.4375) == 4);
  CHECK(lag_of(d, taxels, {{"rate", {{{0, 10}, 1.0}, {{0, 10}, 4.0}}}}).rate_samples == 0);
  CHECK(lag_of(d, taxels, {{"rate", {{{0, 10, 20}, 1.0}, {{0, 10, 20}, 4.0}}}}).rate_samples == 1);
  CHECK(lag_of(d, taxels, {{"rate", {}}}).rate_samples == 0);
  // Of the two sequences one has two rates; its rows are its own.
  CHECK(lag_of(d, taxels, {{"one", {{kUpAndDown, 1.0}}}, {"rate", {{{0, 10, 20}, 1.0}, {{0, 10, 20}, 4.0}}}})
            .rate_samples == 1);
}

TEST_CASE("lag search: samples at a turning point or on a held level are not used", "[dynamic]") {
  Dynamics d;
  d.lag_s = 0.5;
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.06}};
  const std::vector<double> held{0, 10, 10, 20, 30, 20, 30};
  CHECK(lag_of(d, taxels, {{"rate", {{held, 1.0}, {held, 4.0}}}}).rate_samples == 1);  // that at 20 on the way up
}

TEST_CASE("lag search: shares are limited to 0.5, and the time constant to between 0.1 and 12 s", "[dynamic]") {
  Dynamics d;
  d.lag_s = lag_time(24);
  const auto found_of = [&](double one, double other, double fast, double slow) {
    return lag_of(d, {{0.0, 0.1, 1.0, one}, {0.0, 0.1, 1.0, other}},
                  {{"rate", {{kUpAndDown, fast}, {kUpAndDown, slow}}}});
  };
  const ArrayDynamics most = found_of(0.7, 0.8, 0.8, 40.0);
  CHECK(most.shared.lag_share == 0.5);
  CHECK(most.lag_share == std::vector<double>{0.5, 0.5});
  const ArrayDynamics some = found_of(0.52, 0.4, 0.8, 40.0);
  CHECK(some.shared.lag_share == Approx(0.46).epsilon(1e-6));
  CHECK(some.lag_share[0] == 0.5);
  CHECK(some.lag_share[1] == Approx(0.4).epsilon(1e-6));
  // A taxel that runs ahead of its pressure has no lag; an array that does has none, and keeps its time.
  const ArrayDynamics ahead = found_of(-0.02, 0.1, 0.8, 40.0);
  CHECK(ahead.shared.lag_share == Approx(0.04).epsilon(1e-6));
  CHECK(ahead.lag_share[0] == 0.0);
  const ArrayDynamics none = found_of(-0.1, -0.05, 0.8, 40.0);
  CHECK(none.shared.lag_share == 0.0);
  CHECK(none.shared.lag_s == 1.0);
  CHECK(none.lag_share == std::vector<double>{0.0, 0.0});
  // Longer than the longest that is tried, 0.1 x 1.1^50 s, and shorter than the shortest.
  d.lag_s = 60.0;
  CHECK(found_of(0.1, 0.1, 3.0, 600.0).shared.lag_s == lag_time(50));
  d.lag_s = 0.02;
  CHECK(found_of(0.1, 0.1, 0.05, 5.0).shared.lag_s == lag_time(0));
}

TEST_CASE("lag search: equal outputs at both rates give no lag", "[dynamic]") {
  const ArrayDynamics found =
      lag_of({}, {{0.0, 0.1, 1.0, 0.0}, {0.0, 0.2, 1.0, 0.0}}, {{"rate", {{kUpAndDown, 1.0}, {kUpAndDown, 20.0}}}});
  CHECK(found.rate_samples == 4);
  CHECK(found.shared.lag_share == Approx(0.0).margin(1e-9));
  for (const double share : found.lag_share) CHECK(share == Approx(0.0).margin(1e-9));
  const ArrayDynamics none = find_dynamics(nullptr, nullptr, {0.0, 0.0}, {true, true});
  CHECK(none.shared.creep_share == std::array<double, kCreepElements>{});
  CHECK(none.lag_share == std::vector<double>{0.0, 0.0});
}

TEST_CASE("lag search: an uncertain taxel's share is pulled toward the array's, an unusable taxel gets the array's",
          "[dynamic]") {
  Dynamics d;
  d.lag_s = lag_time(24);
  const std::vector<WalkedTaxel> taxels = {{0.0, 0.1, 1.0, 0.04}, {0.0, 0.1, 1.0, 0.08}, {0.0, 0.1, 1.0, 0.2}};
  Dataset data = walked_run(d, taxels, {{"rate", {{kUpAndDown, 0.8}, {kUpAndDown, 60.0}}}}, 30.0);
  // What is still to come in the fast repeat, times the slope of 0.1 V/psi, is what the shares are counted in. The slow
  // one waits for 60 s, more than 60 lags: nothing is left.
  std::vector<double> x;
  double late = 0.0;
  for (const double psi : kUpAndDown) {
    late = psi + (late - psi) * std::exp(-0.8 / d.lag_s);
    x.push_back(0.1 * (late - psi));
  }
  // Errors of the first two taxels that the regression does not see, since they are at right angles to x, and the mean
  // neither, since their signs differ.
  constexpr double kError = 0.2;
  std::vector<double>& volts = data.sequences[0].repeats[0].volts;
  volts[1 * 3 + 0] += kError * x[2];
  volts[2 * 3 + 0] -= kError * x[1];
  volts[1 * 3 + 1] -= kError * x[2];
  volts[2 * 3 + 1] += kError * x[1];
  ArrayDynamics found = nothing_known(3);
  find_lag(data, {0.0, 0.0, 0.0}, {true, true, false}, found);
  CHECK(found.shared.lag_s == d.lag_s);
  CHECK(found.shared.lag_share == Approx(0.06).epsilon(1e-6));
  // Of four samples: the errors' mean square over the sum of x^2, against 0.3 of the share, 0.018, squared.
  const double xx = x[1] * x[1] + x[2] * x[2] + x[4] * x[4] + x[5] * x[5];
  const double rest = kError * kError * (x[1] * x[1] + x[2] * x[2]), doubt2 = rest / 4.0 / xx;
  const double kept = 0.018 * 0.018 / (0.018 * 0.018 + doubt2);
  REQUIRE((kept > 0.01 && kept < 0.9));
  CHECK(found.lag_share[0] == Approx(0.06 - 0.02 * kept).epsilon(1e-6));
  CHECK(found.lag_share[1] == Approx(0.06 + 0.02 * kept).epsilon(1e-6));
  CHECK(found.lag_share[2] == found.shared.lag_share);
}

// Runs that make no dynamic model, and data that no model can be fitted to: each refused by its id.

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
  return histories_of(series, "t", table_options(0.0, 0.0));
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
