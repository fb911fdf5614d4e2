// The dynamic Preisach model: its table against the model it is made of, the divider and dynamics against plants of
// known truth, the streaming compensator against those plants.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/identify/congruency.h"
#include "analysis/models/linearised.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

TEST_CASE("Everett's table and staircase give the inputs that the Preisach model gives", "[dynamic]") {
  for (const std::size_t n : {7U, 20U, 30U}) {
    const PreisachModel model = random_preisach(static_cast<unsigned>(n), n);
    std::vector<double> table;
    for (std::size_t i = 0; i <= n; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        const double step = 60.0 / static_cast<double>(n);
        table.push_back(model.everett(step * static_cast<double>(i), step * static_cast<double>(j)));
      }
    const Everett<double> everett{table.data(), n};
    Staircase<double> memory;
    memory.start_low(0.1);
    const auto state = model.state();
    const double per_interval = 60.0 / static_cast<double>(n);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> level(0.0, 60.0);
    bool rises = true;
    double last = 0.0;
    for (int turn = 0; turn < 4000; ++turn) {
      const double x = level(random);
      if (x == last) continue;
      const double y = state->output_at(x);
      if (std::abs(y - state->output_at(last)) < 1e-9) continue;  // flat: any input in between is right
      if ((x > last) != rises) memory.turn(everett, state->output_at(last));
      rises = x > last;
      memory.go(y);
      const double back = memory.piece(everett, y).along(y) * per_interval;
      state->go(x);
      REQUIRE(std::abs(state->output_at(back) - y) < 1e-9);
      last = x;
    }
  }
}

TEST_CASE("the plain dynamic compensator gives a plant's pressures back", "[dynamic]") {
  const DynamicArray array = dynamic_array(4, 0.0);
  for (std::size_t t = 0; t < array.films.size(); ++t) {
    DynamicPlant plant(array.films[t], array.setup.dynamics, array.setup.taxels[t]);
    DynamicSetup setup = array.setup;
    setup.observer.share = 0.0;
    DynamicTaxelCompensator compensator(setup, t), deaf(setup, t);
    double sum = 0.0, most = 0.0, deaf_sum = 0.0;
    const std::vector<double> way = random_way(600, 2.0, static_cast<unsigned>(t) + 9);
    for (const double psi : way) {
      const double seconds = psi == 0.0 ? 30.0 : 2.5, volts = plant.step(psi, seconds);
      const double error = std::abs(compensator.step(volts, seconds).pressure_psi - psi);
      deaf_sum += std::abs(deaf.step(volts, 0.0).pressure_psi - psi);  // is not told the time
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

TEST_CASE("beyond a nearly level piece of a branch the creep's target is not guessed along its slope", "[dynamic]") {
  const PreisachModel film(0.0, 60.0, 0.0, {2.0, 0.0, 0.01, 0.0, 0.0, 2.0});  // 10 mV from 20 to 40 psi
  DynamicSetup setup = dynamic_array(1, 0.0).setup;
  setup.intervals = 3;
  setup.dynamics.creep_share = {0.3, 0.0, 0.0};
  setup.taxels[0].everett = everett_table(film, 3);
  DynamicPlant plant(film, setup.dynamics, setup.taxels[0]);
  DynamicTaxelCompensator compensator(setup, 0);
  double most = 0.0;
  for (int i = 0; i <= 60; ++i) {
    const double psi = i <= 30 ? 2.0 * i : 120.0 - 2.0 * i;
    const double off = std::abs(compensator.step(plant.step(psi, 2.5), 2.5).pressure_psi - psi);
    if (psi < 20.0 || psi > 40.0) most = std::max(most, off);
  }
  CHECK(most < 1.0);
}

TEST_CASE("after an unknown start the pressures converge to those of a known start", "[dynamic]") {
  const DynamicArray array = dynamic_array(1, 0.001);
  DynamicPlant plant(array.films[0], array.setup.dynamics, array.setup.taxels[0]);
  DynamicTaxelCompensator knows(array.setup, 0), late(array.setup, 0);
  late.reset_unknown();
  const std::vector<double> way = random_way(800, 2.0, 3);
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, 0.001);
  bool was_unknown = false, is_unknown = true;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const double volts = plant.step(way[i], 2.5) + normal(random);
    const double known = knows.step(volts, 2.5).pressure_psi;
    if (i < 100) continue;
    const Compensated now = late.step(volts, 2.5);
    was_unknown = was_unknown || now.unknown;
    is_unknown = now.unknown;
    if (!now.unknown && i > 700) CHECK(std::abs(now.pressure_psi - known) < 2.0);  // its creep began elsewhere
  }
  CHECK(was_unknown);
  CHECK_FALSE(is_unknown);
}
