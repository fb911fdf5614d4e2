// GPI's evolution strategy: it goes on where it was, and ends.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/rivals/gpi_evolution.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

struct Problem {
  FitData data = paper_both(0.03, 0.02);
  FitSamples samples{data};
  GpiTree tree{samples};
  GpiTree::Target target = tree.target(shares());
  GpiLanes lanes{tree};
  GpiFound start;
  Problem() {
    start.at = {0.8, 0.1, -0.5, 0.3, -0.1, -0.2, -2.0, 0.3};
    start.j = j(start.at);
  }
  double j(const GpiPoint& at) {
    lanes.at.fill(at);
    lanes.evaluate(target, false);
    return lanes.j[0];
  }

 private:
  [[nodiscard]] std::vector<double> shares() const {
    std::vector<double> y = samples.outputs(data);
    for (double& value : y) value /= data.ascending.y().back();
    return y;
  }
};

}  // namespace

TEST_CASE("GPI: its evolution strategy ends at its last generation, or when steps no longer matter") {
  Problem problem;
  GpiEvolution small(problem.lanes, problem.target, problem.start, 1e-5);
  small.go(problem.lanes, problem.target, 100);
  CHECK(small.best().at == problem.start.at);
  GpiEvolution once(problem.lanes, problem.target, problem.start, 0.05), twice = once;
  once.go(problem.lanes, problem.target, 6);
  for (const int last : {3, 3, 6}) twice.go(problem.lanes, problem.target, last);
  CHECK(twice.best().at == once.best().at);
  CHECK(once.best().j < problem.start.j);
}
