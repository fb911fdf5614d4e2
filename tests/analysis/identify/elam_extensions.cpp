// What ELAM's extensions bring on trajectories that were not fitted: a plant of play operators, which no ELAM is and
// whose inner loops close as those of most materials do.
#include <catch2/catch.hpp>
#include <random>

#include "analysis/identify/fit_data.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

class PlayPlant {
 public:
  double operator()(double x) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kOperators; ++i) {
      const double r = 3.0 * static_cast<double>(i);
      y_[i] = std::clamp(y_[i], x - r, x);  // lags behind going up
      sum += y_[i] * (i == 0 ? 1.0 : 0.35 / static_cast<double>(i));
    }
    return 3.5 * (1.0 - std::exp(-sum / 45.0));
  }

 private:
  static constexpr std::size_t kOperators = 8;
  std::array<double, kOperators> y_{};
};

History history_of(const std::vector<double>& turns, unsigned seed) {
  History history;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.004);
  PlayPlant plant;
  for (const double x : levels_of(turns, 1.0)) {
    history.x.push_back(x);
    history.y.push_back(plant(x) + noise(random));
  }
  history.branches = branches_along(history.x);
  return history;
}

}  // namespace

TEST_CASE("memory reduces ELAM's error on random reversals that were not fitted") {
  FitData data;
  data.histories = {history_of(kDescendingTurns, 1), history_of(kAscendingTurns, 2)};
  std::vector<double> grid, up, down;
  PlayPlant sweep;
  for (int x = 0; x <= 60; x += 2) {
    grid.push_back(x);
    up.push_back(sweep(x));
  }
  for (int x = 60; x >= 0; x -= 2) down.insert(down.begin(), sweep(x));
  data.ascending = PatternCurve(grid, up, up.front(), up.back());
  data.descending = PatternCurve(grid, down, up.front(), up.back());

  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(0.0, 60.0);
  std::vector<History> held_out;
  for (unsigned trial = 0; trial < 20; ++trial) {
    std::vector<double> turns{0.0};
    while (turns.size() < 30) {
      const double turn = std::round(any(random));
      if (std::abs(turn - turns.back()) >= 4.0) turns.push_back(turn);
    }
    held_out.push_back(history_of(turns, 100 + trial));
  }
  const auto mean_error = [&](const IdentifyOptions& options) {
    const ModelFit fit = identify_elam(data, options);
    double sum = 0.0, count = 0.0;
    for (const History& history : held_out) {
      const auto state = fit.model->state();
      for (std::size_t i = 0; i < history.x.size(); ++i) {
        state->go(history.x[i]);
        sum += std::abs(state->output_at(history.x[i]) - history.y[i]);
        count += 1.0;
      }
    }
    return sum / count / fit.full_scale;
  };
  const double as_paper = mean_error({});
  CHECK(mean_error({.memory = true}) < as_paper);
  CHECK(mean_error({.free_run = true, .exact_outer = true, .memory = true}) < as_paper);
}
