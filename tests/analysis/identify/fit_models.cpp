// Identification of the models beside ELAM: what generated the data comes out again, and data that cannot carry a model
// are refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/models/model_json.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/models.h"

using namespace synthetic;

namespace {

constexpr std::array<const char*, 5> kOthers = {"gpi", "mpi", "poly", "preisach", "monotone"};

// The external loop and the paper's two sequences as `model` gives them.
FitData data_from(const HysteresisModel& model, const std::vector<std::vector<double>>& turns) {
  const double low = model.x_low();
  std::vector<double> x = levels_of({0, 60, 0});
  for (double& at : x) at += low;
  std::vector<double> y = predict(model, x);
  const std::vector<double> grid(x.begin(), x.begin() + 31), up(y.begin(), y.begin() + 31);
  std::vector<double> down(y.rbegin(), y.rbegin() + 31);
  down.front() = up.front();
  FitData data{{}, PatternCurve(grid, up, up.front(), up.back()), PatternCurve(grid, down, up.front(), up.back())};
  for (const auto& sequence : turns) {
    std::vector<double> inputs = levels_of(sequence);
    for (double& at : inputs) at += low;
    History history{"made", inputs, predict(model, inputs), branches_along(inputs), {}, {}};
    data.histories.push_back(std::move(history));
  }
  return data;
}

double largest_difference(const HysteresisModel& a, const HysteresisModel& b) {
  std::mt19937 random(5);
  double worst = 0.0;
  for (int n = 0; n < 20; ++n) {
    const std::vector<double> inputs = random_inputs(random, 10, a.x_low(), a.x_high(), 5);
    const std::vector<double> y = predict(a, inputs), z = predict(b, inputs);
    for (std::size_t i = 0; i < y.size(); ++i) worst = std::max(worst, std::abs(y[i] - z[i]));
  }
  return worst;
}

}  // namespace

TEST_CASE("identification: noiseless data give back the model that made them") {
  SECTION("MPI") {
    for (const double low : {0.0, 5.0}) {
      const MpiModel truth({.a1 = 0.1, .a2 = -0.001, .a3 = 5e-6, .rho = 3.0, .tau = 0.7}, low, low + 60.0, 0.3);
      const ModelFit fit = identify_mpi(data_from(truth, {kDescendingTurns, kAscendingTurns}), {});
      CHECK(fit.j < 1e-12);
      CHECK(fit.model->parameters()[4].value == Approx(0.7).epsilon(1e-4));
      CHECK(fit.model->parameters()[3].value == Approx(3.0).epsilon(1e-4));
      CHECK(fit.samples == 660);
      CHECK(largest_difference(truth, *fit.model) < 1e-6);
    }
  }
  SECTION("POLY") {
    for (const bool free_run : {false, true}) {
      const PolyModel truth = rising_poly();
      const ModelFit fit = identify_poly(data_from(truth, {kDescendingTurns, kAscendingTurns}), {.free_run = free_run});
      CHECK(fit.j < 1e-16);
      CHECK(largest_difference(truth, *fit.model) < 1e-8);
    }
  }
  SECTION("Preisach") {
    const PreisachModel truth = random_preisach();
    FitData data = data_from(truth, {kDescendingTurns, kAscendingTurns});
    std::mt19937 random(3);
    for (int n = 0; n < 12; ++n) {  // inputs that tell all cells apart
      const std::vector<double> inputs = random_inputs(random, 40, 0.0, 60.0, 4);
      data.histories.push_back({"random", inputs, predict(truth, inputs), branches_along(inputs), {}, {}});
    }
    const ModelFit fit = identify_preisach(data, {});
    CHECK(fit.max_error < 1e-5);
    CHECK(largest_difference(truth, *fit.model) < 1e-3);
  }
  SECTION("GPI") {
    const GpiModel truth(kGpiTable2, 0.0, 60.0, 0.0);
    FitData data = data_from(truth, {kDescendingTurns});
    // The printed model does not start where its loop ends: its own loop as the pattern would move its origin.
    const PatternCurve pattern({std::vector<double>{0, 60}}, {std::vector<double>{0, 3.49}}, 0.0, 3.49);
    data.ascending = data.descending = pattern;
    const ModelFit fit = identify_gpi(data, {});
    CHECK(fit.j < 1e-6);
    CHECK(fit.starts == 16);
    CHECK(fit.model->parameters()[1].value == Approx(0.0524).epsilon(0.02));  // the same whatever the scale
    CHECK(fit.model->parameters()[5].value == Approx(0.0825).epsilon(0.02));
  }
  SECTION("monotone") {
    const MonotoneModel truth(PatternCurve(std::vector<double>{0, 20, 60}, std::vector<double>{0, 2, 3}, 0.0, 3.0));
    const ModelFit fit = identify_monotone(data_from(truth, {kDescendingTurns}), {});
    CHECK(fit.j < 1e-20);
    CHECK(largest_difference(truth, *fit.model) < 1e-12);
  }
}

TEST_CASE("identification: the errors are those of the model walked along the data") {
  for (const bool free_run : {false, true}) {
    const FitData data = paper_both(0.032, 0.0205);
    for (const char* name : kOthers) {
      const ModelFit fit = identify(name, data, {.free_run = free_run});
      double j = 0.0, sum = 0.0, largest = 0.0;
      int samples = 0;
      for (const History& history : data.histories) {
        const std::vector<double> y = predict_history(*fit.model, history, free_run);
        for (std::size_t i = 1; i < y.size(); ++i, ++samples) {
          const double off = std::abs(y[i] - history.y[i]);
          j += off * off;
          sum += off;
          largest = std::max(largest, off);
        }
      }
      INFO(name << (free_run ? ", free run" : ""));
      CHECK(fit.samples == samples);
      CHECK(fit.j == Approx(j).epsilon(1e-9));
      CHECK(fit.mean_error == Approx(sum / samples).epsilon(1e-9));
      CHECK(fit.max_error == Approx(largest).epsilon(1e-9));
      CHECK(fit.full_scale == 3.49);
      CHECK(fit.model->name() == name);
    }
  }
}

TEST_CASE("identification: no parameters near the fitted ones have a smaller error") {
  const FitData data = paper_both(0.032, 0.0205);
  for (const char* name : {"gpi", "mpi", "poly"}) {
    const ModelFit fit = identify(name, data);
    const nlohmann::ordered_json best = model_json(*fit.model);
    const auto j_of = [&](const nlohmann::ordered_json& json) {
      const auto model = model_from_json(json);
      double j = 0.0;
      for (const History& history : data.histories) {
        const std::vector<double> y = predict_history(*model, history, false);
        for (std::size_t i = 1; i < y.size(); ++i) j += (y[i] - history.y[i]) * (y[i] - history.y[i]);
      }
      return j;
    };
    const nlohmann::ordered_json flat = best.flatten();
    for (const auto& [member, value] : flat.items()) {
      // POLY: its last coefficient is a constant that cancels. A range is data, not a parameter.
      if (!value.is_number() || member == "/x_low" || member == "/x_high" || member.starts_with("/y_")) continue;
      for (const double factor : {0.999, 1.001}) {
        nlohmann::ordered_json moved = best;
        moved[nlohmann::ordered_json::json_pointer(member)] = value.get<double>() * factor;
        INFO(name << member);
        CHECK(j_of(moved) >= fit.j * (1.0 - 1e-9));
      }
    }
  }
}

// Measured inputs: off the grid, wavering within a branch, branches of unequal length, a range that does not begin at
// 0, a history that starts in the middle.
TEST_CASE("identification: measured inputs, unequal branches and an origin elsewhere are fitted as well") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const ElamModel truth = model_of(paper_loop(), kPrinted, true);
  const auto moved = [](const PatternCurve& curve) {
    std::vector<double> x(curve.x().begin(), curve.x().end()), y(curve.y().begin(), curve.y().end());
    for (double& at : x) at += 100.0;
    for (double& at : y) at += 1.0;
    return PatternCurve(x, y, y.front(), y.back());
  };
  FitData data{{}, moved(truth.ascending), moved(truth.descending)};
  for (const std::vector<double>& turns : {kDescendingTurns, std::vector<double>{30, 60, 7, 44, 13, 60, 0}}) {
    const std::vector<double> levels = levels_of(turns);
    Plant plant(truth);
    History history{"measured", {}, {}, branches_along(levels), {}, {}};
    if (turns.front() > 0.0) plant(turns.front());
    for (const double level : levels) {
      const double real = std::clamp(level + 0.4 * normal(random), 0.0, 60.0);
      history.x.push_back(100.0 + real);
      history.y.push_back(1.0 + plant(level) + (level < 50 ? 0.05 * (real - level) : 0.0) + 0.003 * normal(random));
    }
    data.histories.push_back(std::move(history));
  }
  const double limits[] = {2.5, 4.0, 3.5, 1.0, 7.0};
  for (std::size_t n = 0; n < kOthers.size(); ++n) {
    const ModelFit fit = identify(kOthers[n], data);
    INFO(kOthers[n] << " " << 100.0 * fit.mean_error / 3.49);
    CHECK(100.0 * fit.mean_error / 3.49 < limits[n]);
    CHECK(fit.model->x_low() == 100.0);
    CHECK(fit.full_scale == Approx(3.49));
    CHECK(fit.model->state()->output_at(100.0) == Approx(1.0).margin(0.4));
  }
}

TEST_CASE("identification: a long history is thinned for the regressions, not for the errors") {
  std::mt19937 random(2);
  const std::vector<double> inputs = random_inputs(random, 12000, 0.0, 60.0, 4);
  const PolyModel truth = rising_poly();
  FitData data = data_from(truth, {kDescendingTurns});
  data.histories.push_back({"long", inputs, predict(truth, inputs), branches_along(inputs), {}, {}});
  for (const char* name : {"mpi", "poly", "monotone"}) {
    // Free run: a random turn within 1 % of an end is not an external one.
    const ModelFit fit = identify(name, data, {.free_run = true});
    CHECK(fit.samples == 210 + static_cast<int>(inputs.size()) - 1);
    if (std::string(name) == "poly") CHECK(fit.j < 1e-8);
  }
}
