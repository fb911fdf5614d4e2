// ELAM's searches for its rising half: candidates beside each other, and where nothing depends on an unknown.
#include <catch2/catch.hpp>
#include <stdexcept>
#include <vector>

#include "analysis/identify/elam/ascending_search.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

// Rises from the lowest input and from two turns inside, of a model drawn anywhere, with noise.
struct Rises {
  ElamModel model = model_of(paper_loop(), {});
  std::vector<CurveSamples> curves;
  Rises(Random& random, double noise) {
    const double u = random(0.0, 1.0), v = random(0.0, 1.0);
    model.parameters = {0.5, 0.5, (v - u) / 60.0, u, random(0.0, 1.0)};
    for (const double turn : {0.0, random(10.0, 25.0), random(30.0, 45.0)}) {
      CurveSamples& own = curves.emplace_back();
      own.x_turn = turn;
      own.y_turn = turn == 0.0 ? model.y0() : model.descending(turn);
      const ElamCurve curve(model, true, own.x_turn, own.y_turn);
      for (int i = 1; i <= 6; ++i) {
        own.x.push_back(turn + (60.0 - turn) * i / 6.5);
        own.y.push_back(curve.output(own.x.back()) + random(-noise, noise));
        own.weight.push_back(1.0 + i % 3);
      }
    }
  }
};

}  // namespace

TEST_CASE("ELAM: a search lowers J, and candidates beside each other end where each does alone") {
  Random random(12);
  for (int problem = 0; problem < 6; ++problem) {
    CAPTURE(problem);
    const Rises rises(random, problem % 3 == 0 ? 0.3 : 0.02);
    const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
    AscendingSearch search(lanes, 8), alone(lanes, 1);
    std::vector<Value> values(8);
    for (Value& value : values) value.at = {random(0.0, 1.0), random(0.0, 1.0), random(0.0, 1.0)};
    search.evaluate(values);
    const std::vector<Value> before = values;
    search.descend(values, 8, Gradient::kSpace);
    for (std::size_t i = 0; i < values.size(); ++i) {
      CHECK(values[i].j <= before[i].j);
      for (const double unknown : values[i].at) CHECK((unknown >= 0.0 && unknown <= 1.0));
      Value own = before[i];
      alone.descend(std::span(&own, 1), 8, Gradient::kSpace);
      CHECK(own.j == Approx(values[i].j).epsilon(1e-9));
      Value plane = before[i];
      alone.descend(std::span(&plane, 1), 8, Gradient::kPlane);
      CHECK(plane.at[2] == before[i].at[2]);
    }
    CHECK(AscendingSearch(lanes, 24).evolve(values[0]).j <= values[0].j);
  }
}

TEST_CASE("ELAM: a search takes as many candidates as it has lanes") {
  Random random(13);
  const Rises rises(random, 0.1);
  const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
  AscendingSearch search(lanes, 9);  // makes 16
  std::vector<Value> many(17);
  CHECK_THROWS_AS(search.evaluate(many), std::invalid_argument);
  CHECK_THROWS_AS(search.descend(many, 1, Gradient::kPlane), std::invalid_argument);
  AscendingSearch eight(lanes, 8);
  CHECK_THROWS_AS(eight.evaluate(std::span(many).first(9)), std::invalid_argument);
  CHECK_NOTHROW(eight.evaluate(std::span(many).first(8)));
}

TEST_CASE("ELAM: searches rest where J depends on nothing, or not on the split of the shortest rises") {
  Random random(14);
  const Rises rises(random, 0.1);
  Value start;
  start.at = {0.2, 0.4, 0.7};
  for (const Gradient gradient : {Gradient::kPlane, Gradient::kSpace}) {
    const LaneProblem none = lane_problem(rises.model, {}, true);
    AscendingSearch search(none, 24);
    Value there = start;
    search.descend(std::span(&there, 1), 3, gradient);
    CHECK(there.at == start.at);
    CHECK(there.j == 0.0);
    CHECK(search.evolve(there).at == start.at);
    // Rises from the lowest input are split at v alone.
    const LaneProblem longest = lane_problem(rises.model, std::span(rises.curves).first(1), true);
    AscendingSearch of_one(longest, 1);
    there = start;
    of_one.descend(std::span(&there, 1), 5, gradient);
    CHECK(there.at[0] == start.at[0]);
    CHECK(there.at[1] != start.at[1]);
  }
}
