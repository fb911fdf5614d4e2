// Properties of all models: they do not fall, direct and inverse undo each other, they are stored bit for bit; and what
// distinguishes them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "analysis/models/elam.h"
#include "analysis/models/invert.h"
#include "analysis/models/model_json.h"
#include "analysis/models/play_operators.h"
#include "tests/analysis/support/models.h"
#include "tests/analysis/support/synthetic.h"
#include "tests/support/sanitized.h"

using namespace synthetic;

namespace {

constexpr int kHistories = tactbench::tests::kSanitized ? 200 : 1000, kTurns = 8, kTurnSteps = 4;

double full_scale(const HysteresisModel& model) {
  return std::abs(predict(model, std::vector{model.x_high()}).front());
}

// Outputs that can be reached, with turns at random: the largest error of direct(inverse(y)), of full scale.
double direct_of_inverse(const HysteresisModel& model, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  const auto state = model.state();
  std::vector<double> outputs{state->output_at(model.x_low())};
  for (int t = 0; t < kTurns; ++t) {
    const double low = state->output_at(model.x_low()), high = state->output_at(model.x_high());
    const double from = outputs.back(), to = low + (high - low) * uniform(random);
    for (int k = 1; k <= kTurnSteps; ++k) {
      outputs.push_back(from + (to - from) * k / kTurnSteps);
      state->go(state->input_at(outputs.back()));
    }
  }
  const std::vector<double> again = predict(model, invert(model, outputs));
  double worst = 0.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) worst = std::max(worst, std::abs(again[i] - outputs[i]));
  return worst / full_scale(model);
}

struct InverseOfDirect {
  double worst = 0.0;  // of full scale, where the slope is observable
  int observable = 0, samples = 0;
};

// Turns lie where the slope is observable: an input at which the output does not change cannot be read, nor can what
// follows from a turn there.
void inverse_of_direct(const HysteresisModel& model, unsigned seed, InverseOfDirect& result) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  const double span = model.x_high() - model.x_low(), nudge = 1e-5 * span;
  const double mean_slope = full_scale(model) / span;
  const auto state = model.state();
  const auto observable = [&](double x) {
    const double before = state->output_at(x - nudge), after = state->output_at(x + nudge), at = state->output_at(x);
    return std::min(at - before, after - at) > 1e-3 * mean_slope * nudge;
  };
  std::vector<double> inputs{model.x_low()};
  std::vector<bool> counts{false};
  for (int t = 0; t < kTurns; ++t) {
    const double from = inputs.back();
    double to = from;
    for (int n = 0; n < 50; ++n) {
      to = model.x_low() + span * (0.001 + 0.998 * uniform(random));
      if (std::abs(to - from) > 0.01 * span && observable(to)) break;
      to = from;
    }
    if (to == from) break;
    for (int k = 1; k <= kTurnSteps; ++k) {
      inputs.push_back(k == kTurnSteps ? to : from + (to - from) * k / kTurnSteps);
      counts.push_back(observable(inputs.back()));
    }
    state->go(to);
  }
  const std::vector<double> again = invert(model, predict(model, inputs));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    ++result.samples;
    if (!counts[i]) continue;
    ++result.observable;
    result.worst = std::max(result.worst, std::abs(again[i] - inputs[i]) / span);
  }
}

// The rising ones, and ELAM as in the paper, with exact external branches, with memory and with further pieces.
std::vector<std::unique_ptr<HysteresisModel>> with_elam() {
  auto models = rising_models();
  for (const bool memory : {false, true})
    for (const bool exact_outer : {false, true})
      models.push_back(std::make_unique<ElamHysteresis>(model_of(paper_loop(), kPrinted, exact_outer), memory));
  models.push_back(
      std::make_unique<ElamHysteresis>(model_of(paper_loop(), kPrinted), true, ElamPieces{{0.1}, {}, {}, {-0.2}}));
  return models;
}

}  // namespace

TEST_CASE("models: outputs do not fall when the input rises, in any state") {
  std::mt19937 random(1);
  for (const auto& model : with_elam()) {
    INFO(model->name());
    std::uniform_real_distribution<double> uniform(model->x_low(), model->x_high());
    const auto state = model->state();
    bool rises = true, bounded = true;
    for (int turn = 0; turn < 300; ++turn) {
      state->go(uniform(random));
      double before = state->output_at(model->x_low());
      for (int k = 1; k <= 200; ++k) {
        const double y = state->output_at(model->x_low() + (model->x_high() - model->x_low()) * k / 200);
        rises = rises && y >= before - 1e-12;
        before = y;
      }
      bounded = bounded && state->output_at(model->x_high() + 10.0) == state->output_at(model->x_high()) &&
                state->output_at(model->x_low() - 10.0) == state->output_at(model->x_low());
    }
    CHECK(rises);
    CHECK(bounded);
  }
}

TEST_CASE("models: the output does not depend on the number of samples between two turning points") {
  std::mt19937 random(2);
  for (const auto& model : with_elam()) {
    INFO(model->name());
    std::uniform_real_distribution<double> uniform(model->x_low(), model->x_high());
    const auto coarse = model->state(), fine = model->state();
    double x = model->x_low(), worst = 0.0;
    for (int turn = 0; turn < 100; ++turn) {
      const double to = uniform(random);
      coarse->go(to);
      for (int k = 1; k < 7; ++k) fine->go(x + (to - x) * k / 7);
      fine->go(to);
      x = to;
      const double probe = uniform(random);
      worst = std::max(worst, std::abs(coarse->output_at(probe) - fine->output_at(probe)));
    }
    CHECK(worst < 1e-12);
    coarse->reset();
    CHECK(coarse->output_at(0.5 * (model->x_low() + model->x_high())) ==
          model->state()->output_at(0.5 * (model->x_low() + model->x_high())));
  }
}

TEST_CASE("models: direct of inverse returns the output on 1000 random histories per model") {
  auto models = with_elam();
  for (auto& model : wavering_models()) models.push_back(std::move(model));
  for (const auto& model : models) {
    double worst = 0.0;
    for (unsigned seed = 0; seed < kHistories; ++seed) worst = std::max(worst, direct_of_inverse(*model, seed));
    INFO(model->name());
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("models: inverse of direct returns the input where the slope is observable, on random histories") {
  for (const auto& model : rising_models()) {
    InverseOfDirect result;
    for (unsigned seed = 0; seed < kHistories; ++seed) inverse_of_direct(*model, seed, result);
    INFO(model->name() << ": " << result.observable << " of " << result.samples);
    CHECK(result.worst < 1e-9);
    CHECK(result.observable > 0.5 * result.samples);
  }
}

TEST_CASE("models: a stored model is read back bit for bit") {
  auto models = with_elam();
  for (auto& model : wavering_models()) models.push_back(std::move(model));
  std::mt19937 random(7);
  for (const auto& model : models) {
    INFO(model->name());
    const auto again = model_from_json(nlohmann::ordered_json::parse(model_json(*model).dump()));
    REQUIRE(again->name() == model->name());
    CHECK(again->x_low() == model->x_low());
    CHECK(again->x_high() == model->x_high());
    CHECK(model_json(*again) == model_json(*model));
    std::uniform_real_distribution<double> uniform(model->x_low(), model->x_high());
    std::vector<double> inputs;
    for (int i = 0; i < 200; ++i) inputs.push_back(uniform(random));
    CHECK(predict(*again, inputs) == predict(*model, inputs));
    CHECK(again->parameters().size() == model->parameters().size());
    CHECK(again->operations_per_sample() > 0);
  }
}

TEST_CASE("models: an incomplete stored model is refused with the member named") {
  for (const auto& model : rising_models()) {
    const nlohmann::ordered_json good = model_json(*model);
    for (const auto& [name, value] : good.items()) {
      INFO(model->name() << "." << name);
      nlohmann::ordered_json bad = good;
      bad.erase(name);
      CHECK_THROWS_WITH(model_from_json(bad), Catch::Contains("\"" + name + "\""));
      bad = good;
      bad[name] = nullptr;
      CHECK_THROWS_AS(model_from_json(bad), std::invalid_argument);
    }
  }
  CHECK_THROWS_WITH(model_from_json({{"model", "spline"}}), Catch::Contains("spline"));
  CHECK_THROWS_AS(model_from_json(nlohmann::ordered_json::array()), std::invalid_argument);
}

TEST_CASE("models: a non-finite input is refused and changes nothing") {
  for (const auto& model : rising_models()) {
    const auto state = model->state();
    const double x = 0.4 * model->x_low() + 0.6 * model->x_high();
    state->go(x);
    const double y = state->output_at(x);
    CHECK_THROWS_AS(state->go(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
    CHECK_THROWS_AS(state->go(std::numeric_limits<double>::infinity()), std::invalid_argument);
    CHECK(state->output_at(x) == y);
    CHECK_THROWS_AS(invert(*model, std::vector{1.0, std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
  }
}

TEST_CASE("models: the play operators follow Eqs (3) and (4)") {
  CHECK(generalized_play(2.0, 3.0, 0.5, 0.0) == 1.5);   // pushed up
  CHECK(generalized_play(2.0, 3.0, 0.5, 2.0) == 2.0);   // within its band
  CHECK(generalized_play(2.0, 3.0, 0.5, 9.0) == 3.5);   // pulled down
  CHECK(generalized_play(3.0, 2.0, 0.0, 2.5) == 3.0);   // crossed envelopes: the left one [A14]
  CHECK(one_sided_play(0.6, 0.2, 0.0) == Approx(0.4));  // rises r later
  CHECK(one_sided_play(0.5, 0.2, 0.4) == 0.4);
  CHECK(one_sided_play(0.3, 0.2, 0.4) == 0.3);  // falls at once
}

TEST_CASE("models: GPI and MPI equal the sums of Eqs (2) and (5)") {
  const GpiModel gpi(kGpiTable2, 0.0, 60.0, 0.0);
  const MpiModel mpi(kRisingMpi, 0.0, 60.0, 0.0);
  double h[5] = {}, o[10] = {};
  bool same = true;
  const std::vector<double> inputs{0, 20, 40, 25, 33, 60, 10, 12, 0, 50};
  const std::vector<double> gpi_y = predict(gpi, inputs), mpi_y = predict(mpi, inputs);
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const double x = inputs[k], u = x / 60.0;
    double sum = 0.0, cubic = 0.06 * x - 6e-4 * x * x + 4e-6 * x * x * x;
    for (int i = 0; i <= 4; ++i) {
      const double r = 0.2972 * i, left = 1.6350 - 0.5754 * std::exp(1.1216 - 0.0524 * x);
      const double right = 1.5428 - 13.0421 * std::exp(-1.9648 - 0.0825 * x);
      h[i] = std::max(left - r, std::min(right + r, h[i]));
      sum += 1.7531 * std::exp(-4.4935 * r) * h[i];
    }
    for (int i = 1; i <= 10; ++i) {
      o[i - 1] = std::max(u - (i - 1) / 10.0, std::min(u, o[i - 1]));
      cubic += 2.0 * std::exp(-0.3 * (i - 2) * (i - 2)) / 10.0 * o[i - 1];
    }
    same = same && std::abs(gpi_y[k] - sum) < 1e-12 && std::abs(mpi_y[k] - cubic) < 1e-12;
  }
  CHECK(same);
}

TEST_CASE("POLY: an equal input makes no turning point, scaling or shifting its polynomial changes nothing") {
  const PolyModel poly = rising_poly();
  const auto state = poly.state();
  state->go(15.0);
  state->measured(1.7);
  state->go(15.0);  // [A8]
  CHECK(state->output_at(15.0) == 1.7);
  PolyParameters p, q;  // [A2]
  p.a = {0, 0, 0, 1e-5, -0.001, 0.1, 0};
  p.b = {0, 0, 0, 0, -0.0005, 0.08, 0};
  for (std::size_t i = 0; i < 7; ++i) q.a[i] = 3.0 * p.a[i] + (i == 6 ? 0.7 : 0.0), q.b[i] = 0.5 * p.b[i];
  const std::vector<double> inputs{0, 30, 10, 45, 60, 5};
  const auto y = predict(PolyModel(p, 0, 60, 0, 3.49), inputs), w = predict(PolyModel(q, 0, 60, 0, 3.49), inputs);
  for (std::size_t i = 0; i < y.size(); ++i) CHECK(y[i] == Approx(w[i]).margin(1e-12));
}

TEST_CASE("models: Preisach equals the sum of its cells, each a play operator") {
  const PreisachModel model = random_preisach(5, 6, 0.0);
  const auto weights = model_json(model)["weights"].get<std::vector<double>>();
  std::vector<double> on(weights.size(), 0.0);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0.0, 60.0);
  std::vector<double> inputs;
  for (int i = 0; i < 500; ++i) inputs.push_back(uniform(random));
  const std::vector<double> outputs = predict(model, inputs);
  double worst = 0.0;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    double y = 0.1;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        const auto share = [&](std::size_t n) {
          return std::clamp(inputs[k] / 10.0 - static_cast<double>(n), 0.0, 1.0);
        };
        double& cell = on[PreisachModel::cell(i, j)];
        cell = std::max(share(i), std::min(share(j), cell));
        y += weights[PreisachModel::cell(i, j)] * cell;
      }
    worst = std::max(worst, std::abs(y - outputs[k]));
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("models: the inverse returns the nearest input of a flat section, and stays within the reachable range") {
  const auto stair = [](double x) { return x < 1.0 ? x : x < 2.0 ? 1.0 : x - 1.0; };
  const double up[] = {0.0, 3.0}, down[] = {3.0, 0.0};
  CHECK(first_crossing(stair, up, 1.0) == Approx(1.0).margin(1e-15));
  CHECK(first_crossing(stair, down, 1.0) == Approx(2.0));
  CHECK(first_crossing(stair, up, 5.0) == 3.0);
  CHECK(first_crossing(stair, down, -1.0) == 0.0);
  CHECK(first_crossing(stair, down, 0.0) == Approx(0.0).margin(1e-15));
  // Not monotone: the first of several.
  const auto hill = [](double x) { return x * (2.0 - x) + (x > 2.0 ? 3.0 * (x - 2.0) : 0.0); };
  const double way[] = {0.0, 1.0, 2.0, 3.0};
  CHECK(first_crossing(hill, way, 0.75) == Approx(0.5));
  for (const auto& model : wavering_models()) {
    const auto state = model->state();
    state->go(30.0);
    const double y = state->output_at(30.0);
    CHECK(state->input_at(y) == Approx(30.0));
    CHECK(state->input_at(state->output_at(60.0) + 9.0) >= 30.0);
    CHECK(state->input_at(-9.0) <= 30.0);
  }
}

TEST_CASE("models: invalid parameters are refused") {
  GpiParameters bad = kGpiTable3;
  bad.alpha = -1.0;
  CHECK_THROWS_AS(GpiModel(bad, 0, 60, 0), std::invalid_argument);
  CHECK_THROWS_AS(GpiModel(kGpiTable3, 60, 60, 0), std::invalid_argument);
  CHECK_THROWS_AS(PreisachModel(0, 60, 0, {1.0, 2.0}), std::invalid_argument);
  CHECK_THROWS_AS(PreisachModel(0, 60, 0, {1.0, -2.0, 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(PolyModel({}, 0, 60, 0, 3.49), std::invalid_argument);
}
