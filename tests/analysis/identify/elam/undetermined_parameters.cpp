// Parameters that data do not determine are reported and chosen by a rule; determined ones do not change.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <tuple>
#include <vector>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/search.h"
#include "analysis/identify/fit_models.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/models.h"

using namespace synthetic;

namespace {

const std::vector<double> kLoops{0, 60, 0, 60, 0, 60, 0};

}  // namespace

TEST_CASE("undetermined parameters: external loops alone leave all of ELAM open, at the pattern's middle") {
  for (const double noise : {0.0, 0.003, 0.02}) {
    const FitData data = paper_data(kLoops, noise);
    const ModelFit fit = identify("elam", data);
    INFO("noise " << noise);
    CHECK(fit.undetermined == std::vector<std::string>{"alpha_d", "beta_d", "alpha_a1", "alpha_a0", "beta_a"});
    const std::vector<ModelParameter> p = fit.model->parameters();
    CHECK(p[0].value == 0.5);
    CHECK(p[1].value == Approx(data.descending(30.0) / 3.49));
    CHECK(p[2].value == 0.0);
    CHECK(p[3].value == 0.5);
    CHECK(p[4].value == Approx(data.ascending(30.0) / 3.49));
    CHECK(fit.mean_error < 1.2 * noise + 1e-9);
  }
}

TEST_CASE("undetermined parameters: full cycles recorded from mid-range leave all of ELAM open") {
  // Its first branch has no measured turn: it is no inner one.
  for (const bool rises : {true, false}) {
    FitData late = paper_data(kLoops, 0.003);
    History& cut = late.histories.front();
    const auto skipped = rises ? 12 : 42;  // at 24 psi, up or down
    cut.x.erase(cut.x.begin(), cut.x.begin() + skipped);
    cut.y.erase(cut.y.begin(), cut.y.begin() + skipped);
    cut.branches = branches_along(cut.x);
    CHECK(identify("elam", late).undetermined ==
          std::vector<std::string>{"alpha_d", "beta_d", "alpha_a1", "alpha_a0", "beta_a"});
  }
}

TEST_CASE("undetermined parameters: inner branches leave none open, and settling changes none") {
  const FitData data = paper_both(0.032, 0.0205);
  CHECK(identify("elam", data).undetermined.empty());
  CHECK(identify("preisach", data).undetermined.empty());
  ElamModel model{data.ascending, data.descending, {}, {}};
  const ElamSamples samples = searched_samples(model, elam_branches_of(data));
  fit_descending(model, samples.descending);
  fit_ascending(model, samples.ascending);
  const ElamParameters found = model.parameters;
  CHECK(settle_undetermined(model, samples.descending, samples.descending_constant, false) == 0);
  CHECK(settle_undetermined(model, samples.ascending, samples.ascending_constant, true) == 0);
  CHECK(model.parameters.alpha_d == found.alpha_d);
  CHECK(model.parameters.beta_d == found.beta_d);
  CHECK(model.parameters.alpha_a1 == found.alpha_a1);
  CHECK(model.parameters.alpha_a0 == found.alpha_a0);
  CHECK(model.parameters.beta_a == found.beta_a);
}

TEST_CASE("undetermined parameters: Preisach on external loops alone spreads its weights, from any start") {
  const PreisachModel truth = random_preisach();
  FitData data = paper_data(kLoops);
  History& loops = data.histories.front();
  loops.y = predict(truth, loops.x);
  const std::vector<double> grid(loops.x.begin(), loops.x.begin() + 31), up(loops.y.begin(), loops.y.begin() + 31);
  const std::vector<double> down(loops.y.rend() - 61, loops.y.rend() - 30);
  data.ascending = PatternCurve(grid, up, up.front(), up.back());
  data.descending = PatternCurve(grid, down, up.front(), up.back());
  for (const bool by_input : {false, true}) {
    CAPTURE(by_input);
    const ModelFit fit = identify("preisach", data, {.by_input = by_input});
    CHECK(fit.undetermined == std::vector<std::string>{"w"});
    CHECK(fit.mean_error < 0.002 * fit.full_scale);
    // Weights above 0: the sparse vertex that non-negative least squares ends in has at most one a row and a column.
    CHECK(fit.model->parameters().size() > 2 * 30);
  }

  // A recording that begins in mid-range has no inner branch either.
  FitData late = data;
  History& cut = late.histories.front();
  cut.x.erase(cut.x.begin(), cut.x.begin() + 12);
  cut.y.erase(cut.y.begin(), cut.y.begin() + 12);
  cut.branches = branches_along(cut.x);
  CHECK(identify("preisach", late).undetermined == std::vector<std::string>{"w"});
}

TEST_CASE("score: every model is scored from measured turning points and in free run, in any fit mode") {
  const FitData data = paper_both(0.032, 0.0205);
  const ScoreOptions options{.noise = 0.016, .x_low = 0.0, .y_low = 0.0, .x_high = 60.0, .y_high = 3.49};
  for (const char* name : {"elam", "gpi", "mpi", "poly", "preisach", "monotone"}) {
    for (const bool free_run : {false, true}) {
      const ModelFit fit = identify(name, data, {.free_run = free_run, .starts = 1});
      const Score found = score(*fit.model, data.histories, options);
      ErrorSum both[2];
      for (const bool running : {false, true})
        for (const History& history : data.histories) {
          const std::vector<double> y = predict_history(*fit.model, history, running);
          for (std::size_t i = 1; i < y.size(); ++i) both[running ? 1 : 0].add(std::abs(y[i] - history.y[i]));
        }
      INFO(name << (free_run ? ", free run" : ""));
      CHECK(found.direct.mean() == Approx(both[0].mean()));
      CHECK(found.free_running.mean() == Approx(both[1].mean()));
      const bool by_inputs = name[0] != 'e' && std::string(name) != "poly";
      CHECK((found.direct.mean() == found.free_running.mean()) == by_inputs);
    }
  }
}

// Which member is taken of those that samples leave open, on straight patterns where it can be worked out by hand.

using namespace tactbench::analysis;

namespace {

const PatternCurve kStraight(std::vector<double>{0, 10}, std::vector<double>{0, 10}, 0.0, 10.0);

// Both pieces of a curve are straight. All samples lie on the piece that ends at 8 psi and 8 V (falling) or at 10 psi
// and 10 V (rising, from 2 psi and 2 V), 1 psi from that end, where the split in the middle of the pattern gives a
// slope of 1: they determine that piece's slope (1 - beta) / (1 - alpha) alone. The model has a slope of 1.1 and meets
// them.
struct OneSlope {
  bool ascending;
  int samples;
  ElamModel model{kStraight, kStraight, {}, {}};
  std::vector<CurveSamples> curves;
  OneSlope(bool up, int n) : ascending(up), samples(n) {
    // From 2 psi on, phi(8 psi) = 0.4.
    model.parameters = {0.4, 1.0 - 1.1 * 0.6, 0.01, 0.32, 1.0 - 1.1 * 0.6};
    const double turn = up ? 2.0 : 8.0, end = up ? 10.0 : 8.0;
    curves = {{turn, turn, {end - 1.0}, {end - 1.1}, {static_cast<double>(n)}}};
  }
  unsigned settle(double constant) { return settle_undetermined(model, curves, constant, ascending); }
  // J of the split in the middle, above the J of the model.
  [[nodiscard]] double gained() const { return samples * 0.1 * 0.1; }
};

}  // namespace

TEST_CASE("undetermined parameters: the middle is chosen if chance explains its J, else the nearest fitting point") {
  // 6 a parameter of J over degrees of freedom: 2 of 14 and 26 samples falling, 3 of 21 rising.
  for (const auto& [ascending, samples, share] :
       {std::tuple(false, 14, 12.0 / 12.0), std::tuple(false, 26, 12.0 / 24.0), std::tuple(true, 21, 18.0 / 18.0)}) {
    CAPTURE(ascending, samples);
    OneSlope chance(ascending, samples);
    CHECK(chance.settle(1.01 * chance.gained() / share) == (ascending ? 0b11100U : 0b11U));
    const ElamParameters& middle = chance.model.parameters;
    CHECK((ascending ? middle.beta_a : middle.beta_d) == Approx(0.5));
    CHECK((ascending ? middle.alpha_a0 : middle.alpha_d) == Approx(0.5));
    CHECK((ascending ? middle.alpha_a1 : 0.0) == Approx(0.0).margin(1e-12));

    OneSlope more(ascending, samples);
    const ElamParameters before = more.model.parameters;
    CHECK(more.settle(0.99 * more.gained() / share) == (ascending ? 0b11100U : 0b11U));
    const ElamParameters& near = more.model.parameters;
    if (ascending) {
      const double phi = near.alpha_a0 + 8.0 * near.alpha_a1;
      CHECK((1.0 - near.beta_a) / (1.0 - phi) == Approx(1.1).epsilon(1e-3));
      CHECK(near.beta_a > before.beta_a);
    } else {
      // The foot of the perpendicular from the middle on the line of one slope.
      const double way = (0.1 * 1.0 + 0.16 * 1.1) / (1.0 + 1.1 * 1.1);
      CHECK(near.alpha_d == Approx(0.4 + way).epsilon(1e-5));
      CHECK(near.beta_d == Approx(0.34 + 1.1 * way).epsilon(1e-5));
    }
  }
}

TEST_CASE("undetermined parameters: if J is 0 along a whole edge, the point nearest the middle is chosen") {
  // With beta 0 the piece below the split is flat, wherever the split lies above 2 psi: alpha is open, beta is not.
  ElamModel model{kStraight, kStraight, {0.9, 0.0, 0.0, 0.5, 0.5}, {}};
  const std::vector<CurveSamples> curves{{8, 8, {2}, {0}, {1}}};
  CHECK(settle_undetermined(model, curves, 0.0, false) == 0b1U);
  CHECK(model.parameters.alpha_d == Approx(0.5));
  CHECK(model.parameters.beta_d == 0.0);
}
