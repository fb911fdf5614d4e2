// The two round trips that every model promises (analysis/models/model.h), on random histories with interrupted
// branches.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/analysis/support/models.h"
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

// Turns lie where the slope is observable: an input at which the output stands still cannot be read, nor can what
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

}  // namespace

TEST_CASE("models: direct of inverse is the output on 1000 random histories of each model") {
  auto models = rising_models();
  for (auto& model : wavering_models()) models.push_back(std::move(model));
  for (const auto& model : models) {
    double worst = 0.0;
    for (unsigned seed = 0; seed < kHistories; ++seed) worst = std::max(worst, direct_of_inverse(*model, seed));
    INFO(model->name());
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("models: inverse of direct is the input where the slope is observable, 1000 random histories of each model") {
  for (const auto& model : rising_models()) {
    InverseOfDirect result;
    for (unsigned seed = 0; seed < kHistories; ++seed) inverse_of_direct(*model, seed, result);
    INFO(model->name() << ": " << result.observable << " of " << result.samples);
    CHECK(result.worst < 1e-9);
    CHECK(result.observable > 0.5 * result.samples);
  }
}

TEST_CASE("models: a stored model is the same bit for bit") {
  auto models = rising_models();
  for (auto& model : wavering_models()) models.push_back(std::move(model));
  std::mt19937 random(7);
  for (const auto& model : models) {
    INFO(model->name());
    const auto again = model_from_json(nlohmann::ordered_json::parse(model->to_json().dump()));
    REQUIRE(again->name() == model->name());
    CHECK(again->x_low() == model->x_low());
    CHECK(again->x_high() == model->x_high());
    CHECK(again->to_json() == model->to_json());
    std::uniform_real_distribution<double> uniform(model->x_low(), model->x_high());
    std::vector<double> inputs;
    for (int i = 0; i < 200; ++i) inputs.push_back(uniform(random));
    CHECK(predict(*again, inputs) == predict(*model, inputs));
    CHECK(again->parameters().size() == model->parameters().size());
    CHECK(again->operations_per_sample() > 0);
  }
}

TEST_CASE("models: an incomplete stored model is refused, naming the member") {
  for (const auto& model : rising_models()) {
    const nlohmann::ordered_json good = model->to_json();
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

TEST_CASE("models: an input that is not finite is refused and changes nothing") {
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
