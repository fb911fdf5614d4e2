// What ELAM's extensions bring on trajectories that were not fitted: a plant of play operators, which no ELAM is and
// whose inner loops close as those of most materials do.
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/fit_models.h"
#include "tests/analysis/support/fit_samples.h"
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
  return drive("play", levels_of(turns, 1.0), PlayPlant(), 0.004, seed);
}

}  // namespace

TEST_CASE("ELAM: memory reduces the error on random reversals that were not fitted") {
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
    const ModelFit fit = identify("elam", data, options);
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

// Which branches tell ELAM's parameters: those whose turn was measured, at most a hundredth of the range inside. What
// is counted of a fit, by hand.

namespace {

// A recording that begins with the way from `from` to `to`, and one of the whole loop.
int elam_samples(double from, double to, const IdentifyOptions& options = {}) {
  const ElamModel truth = model_of(paper_loop(), kPrinted, true);
  const std::vector<double> begins{from, 0.5 * (from + to), to, 30.0, to > from ? 0.0 : 60.0, to};
  const FitData data{
      {drive("begins", begins, Plant(truth)), drive("loop", {0, 20, 40, 60, 40, 20, 0, 30, 60, 0}, Plant(truth))},
      truth.ascending,
      truth.descending};
  return identify("elam", data, options).samples;
}

}  // namespace

TEST_CASE("ELAM: a recording's first branch counts only if it starts within 0.6 psi of an end") {
  // All samples but each branch's first: 5 and 9. Without the first branch two less.
  struct Row {
    double from, to;
    int samples;
  };
  const Row rows[] = {{0, 60, 14}, {0.59, 60, 14}, {0.61, 60, 12}, {20, 60, 12},
                      {60, 0, 14}, {59.41, 0, 14}, {59.39, 0, 12}, {40, 0, 12}};
  for (const bool free_run : {false, true})
    for (const auto& [from, to, samples] : rows) {
      CAPTURE(free_run, from, to);
      CHECK(elam_samples(from, to, {.free_run = free_run}) == samples);
    }
}

TEST_CASE("ELAM: branches with unknown turning point are used if one direction would be missing without them") {
  const ElamModel truth = model_of(paper_loop(), kPrinted, true);
  const FitData data{{drive("h", {20, 40, 60, 30, 0}, Plant(truth))}, truth.ascending, truth.descending};
  CHECK(identify("elam", data, {}).samples == 4);
  for (const int splits : {1, 2, 8}) CHECK_NOTHROW(identify("elam", data, {.splits = splits}));
}

TEST_CASE("ELAM: a direction with branches only from an end stays undetermined, with the split at mid-pattern") {
  for (const double noise : {0.0, 0.003}) {
    CAPTURE(noise);
    const FitData falls = paper_data(kDescendingTurns, noise), rises = paper_data(kAscendingTurns, noise);
    const ModelFit down = identify("elam", falls, {}), up = identify("elam", rises, {});
    CHECK(down.undetermined == std::vector<std::string>{"alpha_a1", "alpha_a0", "beta_a"});
    CHECK(down.model->parameters()[2].value == 0.0);
    CHECK(down.model->parameters()[3].value == 0.5);
    CHECK(down.model->parameters()[4].value == Approx(falls.ascending(30.0) / 3.49));
    CHECK(up.undetermined == std::vector<std::string>{"alpha_d", "beta_d"});
    CHECK(up.model->parameters()[0].value == 0.5);
    CHECK(up.model->parameters()[1].value == Approx(rises.descending(30.0) / 3.49));
  }
}

TEST_CASE("ELAM: parameters within 1e-9 of 0 or 1 count as at a bound, also for the longest split") {
  const std::vector<double> x{0, 60}, y{0, 3};
  const PatternCurve pattern(x, y, 0.0, 3.0);
  using Row = std::pair<ElamParameters, unsigned>;
  const Row rows[] = {{{}, 0},
                      {{1e-9, 0.5, 0, 0.5, 0.5}, 1},
                      {{2e-9, 0.5, 0, 0.5, 0.5}, 0},
                      {{1 - 1e-9, 0.5, 0, 0.5, 0.5}, 1},
                      {{1 - 2e-9, 0.5, 0, 0.5, 0.5}, 0},
                      {{0.5, 0, 0, 0.5, 0.5}, 2},
                      {{0.5, 0.5, 0.5 / 60, 0.5, 0.5}, 4},
                      {{0.5, 0.5, -0.5 / 60, 0.5, 0.5}, 4},
                      {{0.5, 0.5, 0.5 / 60, 0, 0.5}, 8},
                      {{0.5, 0.5, 0, 1, 0.5}, 12},
                      {{0.5, 0.5, 0, 0.5, 1}, 16}};
  for (const auto& [p, bounds] : rows) {
    CAPTURE(p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a);
    CHECK(bounds_met({pattern, pattern, p, {}}) == bounds);
  }
  ElamFit fit;
  fit.undetermined = 0b10101;
  CHECK(undetermined_names(fit) == std::vector<std::string>{"alpha_d", "alpha_a1", "beta_a"});
  // A direction's own row: phi(0), phi(60), beta_a.
  ElamParameters p{0.1, 0.2, 0.01, 0.3, 0.4};
  CHECK(direction_of(p, false, 60.0) == std::array<double, 3>{0.1, 0.2, 0.0});
  CHECK(direction_of(p, true, 60.0)[0] == 0.3);
  CHECK(direction_of(p, true, 60.0)[1] == Approx(0.9));
  CHECK(direction_of(p, true, 60.0)[2] == 0.4);
  const double row[] = {0.2, 0.5, 0.7};
  set_direction(p, true, 60.0, row);
  CHECK((p.alpha_a0 == 0.2 && p.beta_a == 0.7 && p.alpha_d == 0.1));
  CHECK(p.alpha_a1 == Approx(0.005));
  set_direction(p, false, 60.0, row);
  CHECK((p.alpha_d == 0.2 && p.beta_d == 0.5 && p.alpha_a0 == 0.2));
}

TEST_CASE("ELAM: fit errors are over all samples except each branch's first, from the turning point in use") {
  const std::vector<double> x{0, 60}, y{-5, 1};
  const PatternCurve pattern(x, y, -5.0, 1.0);
  const ElamModel model{pattern, pattern, {}, {}};  // straight: a tenth of the input less 5
  const std::vector<TaxelBranch> branches = {{true, {0.5, 20, 60}, {9.0, -2.9, 1.0}}, {false, {60, 30}, {7.0, -2.3}}};
  const ElamFit fit = scored(model, branches);
  CHECK(fit.j_v2 == Approx(0.01 + 0.09));
  CHECK(fit.mean_error_v == Approx((0.1 + 0.0 + 0.3) / 3.0));
  CHECK(fit.max_error_v == Approx(0.3));
  CHECK(fit.full_scale_v == 5.0);
  const auto turn = [&](bool ascending, double at) { return turning_point(model, {ascending, {at, 30}, {0.25, 0}}); };
  CHECK((turn(true, 0.59).x == 0.0 && turn(true, 0.59).y == -5.0));
  CHECK((turn(true, 0.61).x == 0.61 && turn(true, 0.61).y == 0.25));
  CHECK((turn(false, 59.41).x == 60.0 && turn(false, 59.41).y == 1.0));
  CHECK((turn(false, 59.39).x == 59.39 && turn(false, 59.39).y == 0.25));
  CHECK(turn(true, 60.0).x == 60.0);
}
