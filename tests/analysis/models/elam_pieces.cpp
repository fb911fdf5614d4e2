// ELAM with more than one split point a branch.
#include "analysis/models/elam.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/model_json.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

ElamModel any_model(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.02, 0.98);
  const double u = share(random), v = share(random);
  return model_of(paper_loop(), {share(random), share(random), (v - u) / 60.0, u, share(random)}, share(random) < 0.3);
}

// `splits` split points with pieces up to e^`most` larger or smaller.
ElamPieces any_pieces(std::mt19937& random, int splits, double most) {
  std::uniform_real_distribution<double> log(-most, most);
  ElamPieces pieces;
  for (int i = 1; i < splits; ++i) {
    (random() % 2 == 0 ? pieces.descending_low : pieces.descending_high).push_back(log(random));
    (random() % 2 == 0 ? pieces.ascending_low : pieces.ascending_high).push_back(log(random));
  }
  return pieces;
}

}  // namespace

TEST_CASE("ELAM with pieces that are not resized is the paper's, with one split bit for bit") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0.0, 60.0);
  for (int trial = 0; trial < 200; ++trial) {
    const ElamModel model = any_model(random);
    const ElamPieces same = any_pieces(random, 2 + trial % 7, 0.0);
    const bool ascending = trial % 2 == 0;
    const double x = any(random), y = model.descending(x);
    const ElamCurve paper(model, ascending, x, y);
    const ElamPiecedCurve one(model, {}, ascending, x, y), many(model, same, ascending, x, y);
    for (int k = 0; k <= 60; ++k) {
      CHECK(one.output(k) == paper.output(k));
      CHECK(one.input(0.06 * k) == paper.input(0.06 * k));
      CHECK(many.output(k) == Approx(paper.output(k)).margin(1e-12));
    }
  }
}

TEST_CASE("ELAM with any pieces never falls, meets its ends and is inverted, with memory and without") {
  std::mt19937 random(5);
  for (int trial = 0; trial < 300; ++trial) {
    const ElamModel elam = any_model(random);
    const ElamHysteresis model(elam, trial % 2 == 0, any_pieces(random, 1 + trial % 8, kMostPieceLog));
    const double span = elam.yu() - elam.y0();
    const auto state = model.state();
    const std::vector<double> inputs = random_inputs(random, 8, 0.0, 60.0, 5);
    for (const double x : inputs) {
      state->go(x);
      const double here = state->output_at(x);
      double below = elam.y0();
      for (int k = 0; k <= 60; k += 3) {
        const double y = state->output_at(k);
        CHECK(y >= below - 1e-12 * span);
        below = y;
        CHECK(state->output_at(state->input_at(y)) == Approx(y).margin(1e-9 * span));
      }
      CHECK(state->output_at(0.0) == Approx(std::min(here, elam.y0())).margin(1e-12));
      CHECK(state->output_at(60.0) == Approx(std::max(here, elam.yu())).margin(1e-12));
    }
  }
}

TEST_CASE("ELAM with more splits fits what one cannot and never worse") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 4; ++trial) {
    const ElamHysteresis plant(model_of(paper_loop(), kPrinted), false, any_pieces(random, 3, 0.7));
    FitData data = paper_both();
    for (History& history : data.histories) history.y = predict(plant, history.x);
    const double one = identify_elam(data, {}).j;
    for (const int splits : {2, 3, 5}) {
      IdentifyOptions options;
      options.splits = splits;
      const ModelFit fit = identify_elam(data, options);
      INFO("trial " << trial << ", " << splits << " splits, J " << fit.j << ", with one " << one);
      CHECK(fit.j <= one * (1.0 + 1e-9));
      if (splits == 3) CHECK(fit.j < 0.05 * one);
      CHECK(fit.model->parameters().size() == 5 + 2 * static_cast<std::size_t>(splits - 1));
    }
  }
  const FitData noisy = paper_both(0.03, 0.02);
  const double one = identify_elam(noisy, {}).j;
  for (int splits = 2; splits <= kMostSplits; ++splits) {
    IdentifyOptions options;
    options.splits = splits;
    const ModelFit fit = identify_elam(noisy, options);
    INFO(splits << " splits");
    CHECK(fit.j <= one * (1.0 + 1e-9));
    const auto again = model_from_json(model_json(*fit.model));
    CHECK(model_json(*again) == model_json(*fit.model));
    CHECK(predict(*again, noisy.histories[0].x) == predict(*fit.model, noisy.histories[0].x));
  }
}

TEST_CASE("an impossible number of splits and pieces that do not join are refused") {
  const FitData data = paper_both();
  IdentifyOptions options;
  for (options.splits = 0; options.splits < 10; options.splits += 9)
    CHECK_THROWS_AS(identify_elam(data, options), std::invalid_argument);
  const ElamModel model = model_of(paper_loop(), kPrinted);
  CHECK_THROWS_AS(ElamHysteresis(model, false, {{0.1}, {}, {}, {}}), std::invalid_argument);
  CHECK_THROWS_AS(ElamHysteresis(model, false, {{2.1}, {}, {0.0}, {}}), std::invalid_argument);
  nlohmann::ordered_json json = model_json(ElamHysteresis(model, false, {{0.1}, {}, {}, {-0.2}}));
  json["options"]["splits"] = 3;
  CHECK_THROWS_WITH(model_from_json(json), Catch::Contains("\"splits\""));
  json["pieces"].erase("ascending_low");
  CHECK_THROWS_WITH(model_from_json(json), Catch::Contains("\"ascending_low\""));
}
