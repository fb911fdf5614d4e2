#include "analysis/models/elam.h"

#include <bit>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <random>

#include "analysis/identify/fit_models.h"
#include "analysis/models/model_json.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

// The paper's loop with any parameters.
ElamModel model_drawn(Random& random) {
  const double u = random(0.02, 0.98), v = random(0.02, 0.98);
  return model_of(paper_loop(), {random(0.02, 0.98), random(0.02, 0.98), (v - u) / 60.0, u, random(0.02, 0.98)},
                  random(0, 1) < 0.3);
}

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

// Goes along turning points in 7 steps each and says where it came out.
std::vector<double> walk(ModelState& state, std::initializer_list<double> turns) {
  std::vector<double> outputs;
  double x = turns.size() > 0 ? *turns.begin() : 0.0;
  for (const double turn : turns) {
    for (int k = 1; k <= 7; ++k) {
      state.go(x + (turn - x) * k / 7);
      outputs.push_back(state.output_at(x + (turn - x) * k / 7));
    }
    x = turn;
  }
  return outputs;
}

History history_through(const std::vector<double>& levels, const ElamHysteresis& plant) {
  History history;
  const auto state = plant.state();
  for (const double x : levels) {
    state->go(x);
    history.x.push_back(x);
    history.y.push_back(state->output_at(x));
  }
  history.branches = branches_along(levels);
  return history;
}

}  // namespace

TEST_CASE("ELAM: in paper mode outputs equal the paper's curves bit for bit") {
  Random random(8);
  for (int trial = 0; trial < 100; ++trial) {
    const ElamHysteresis model(model_drawn(random));
    const ElamModel& elam = model.elam();
    const auto state = model.state();
    ElamCurve curve(elam, true, elam.x0(), elam.y0());
    double x = elam.x0(), y = elam.y0();
    for (int step = 0; step < 60; ++step) {
      const double to = random(elam.x0(), elam.xu());
      if ((to > x) != curve.ascending()) curve = ElamCurve(elam, to > x, x, y);
      x = to;
      y = curve.output(x);
      REQUIRE(same_bits(state->output_at(to), y));
      state->go(to);
      REQUIRE(same_bits(state->output_at(to), y));
    }
  }
}

TEST_CASE("ELAM memory: an inner loop closes and does not affect later outputs") {
  const ElamModel paper = model_of(paper_loop(), kPrinted);
  const ElamHysteresis with(paper, true), without(paper);
  // 20 to 40 psi cycled inside a rise to 50.
  const auto state = with.state(), plain = with.state(), forgetful = without.state();
  walk(*state, {0, 40});
  const double top = state->output_at(40);
  walk(*plain, {0, 40});
  for (int cycle = 0; cycle < 3; ++cycle) {
    walk(*state, {40, 20});
    const double bottom = state->output_at(20);
    walk(*state, {20, 33, 26, 33});
    CHECK(state->output_at(40) == Approx(top).margin(1e-12));
    walk(*state, {33, 40});
    CHECK(state->output_at(40) == Approx(top).margin(1e-12));
    CHECK(state->output_at(20) == Approx(bottom).margin(1e-12));
  }
  for (const double x : {41.0, 45.0, 50.0, 60.0})
    CHECK(state->output_at(x) == Approx(plain->output_at(x)).margin(1e-12));
  // The paper's model drifts [A10].
  walk(*forgetful, {0, 40});
  const double start = forgetful->output_at(40);
  for (int cycle = 0; cycle < 3; ++cycle) walk(*forgetful, {40, 20, 40});
  CHECK(std::abs(forgetful->output_at(40) - start) > 0.01 * 3.49);
  // On the paper's own sequences there is nothing to remember.
  const auto a = with.state(), b = without.state();
  for (const auto* turns : {&kDescendingTurns, &kAscendingTurns}) {
    for (const double x : levels_of(*turns)) {
      a->go(x);
      b->go(x);
      REQUIRE(same_bits(a->output_at(x), b->output_at(x)));
    }
  }
}

TEST_CASE("ELAM: a measured turning point is where the next branch starts") {
  const ElamModel paper = model_of(paper_loop(), kPrinted);
  const ElamHysteresis model(paper);
  const auto state = model.state();
  state->go(30.0);
  state->measured(1.9);
  CHECK(state->output_at(30.0) == 1.9);
  CHECK(same_bits(state->output_at(12.0), ElamCurve(paper, false, 30.0, 1.9).output(12.0)));
  CHECK(same_bits(state->output_at(47.0), ElamCurve(paper, true, 30.0, 1.9).output(47.0)));
  state->go(59.9);
  state->measured(3.1);  // an external branch starts at the pattern's end
  CHECK(same_bits(state->output_at(30.0), ElamCurve(paper, false, 60.0, 3.49).output(30.0)));
  CHECK_THROWS_AS(state->measured(std::nan("")), std::invalid_argument);
  CHECK_THROWS_AS(state->go(std::nan("")), std::invalid_argument);
  state->reset();
  CHECK(same_bits(state->output_at(30.0), ElamCurve(paper, true, 0.0, paper.y0()).output(30.0)));
}

TEST_CASE("ELAM JSON: an invalid document is refused with the member named") {
  const ElamHysteresis model(model_of(paper_loop(), kPrinted));
  const auto refused = [&](const std::string& path, const nlohmann::ordered_json& value, const std::string& word) {
    nlohmann::ordered_json json = model_json(model);
    const nlohmann::ordered_json::json_pointer at(path);
    if (value.is_null())
      json[at.parent_pointer()].erase(at.back());
    else
      json[at] = value;
    INFO(path);
    CHECK_THROWS_WITH(model_from_json(json), Catch::Contains(word));
  };
  refused("/x", nullptr, "\"x\"");
  refused("/ascending", "steep", "\"ascending\"");
  refused("/descending", nlohmann::ordered_json::array({1.0}), "\"descending\"");
  refused("/parameters/beta_a", nullptr, "\"beta_a\"");
  refused("/parameters/alpha_d", "half", "\"alpha_d\"");
  refused("/options/memory", 1, "\"memory\"");
  refused("/options/splits", 7, "\"pieces\"");
  refused("/ascending/30", 9.0, "ends");
}

TEST_CASE("ELAM: a joint free-run fit has a smaller free-run error than the separate fit") {
  // A plant that no ELAM is: with the memory that the fit is not told of, and other splits up and down.
  const ElamHysteresis truth(model_of(paper_loop(), {0.7, 0.95, -0.004, 0.5, 0.4}, true), true);
  std::mt19937 engine(4);
  std::normal_distribution<double> noise(0.0, 0.03);
  FitData data{{}, truth.elam().ascending, truth.elam().descending};
  data.histories.push_back(history_through(levels_of({0, 60, 0, 50, 10, 40, 20, 50, 0, 60, 20, 50, 30, 60, 0}), truth));
  for (double& y : data.histories[0].y) y += noise(engine);
  IdentifyOptions options;
  const ModelFit separate = identify("elam", data, options);
  options.free_run = true;
  const ModelFit joint = identify("elam", data, options);
  const auto state = separate.model->state();
  double j = 0.0;
  const History& history = data.histories[0];
  for (const Branch& branch : history.branches)
    for (int i = branch.first + 1; i <= branch.last; ++i) {
      const auto at = static_cast<std::size_t>(i);
      state->go(history.x[at]);
      const double off = state->output_at(history.x[at]) - history.y[at];
      j += off * off;
    }
  INFO("free-run J " << joint.j << ", separate " << j);
  CHECK(joint.j < j);
  CHECK(joint.j > 0.3 * 0.03 * 0.03 * joint.samples);
}
